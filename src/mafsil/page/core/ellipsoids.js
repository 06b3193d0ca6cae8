// Ellipsoids of the tip: velocities that joint rates of norm one make, forces that joint efforts of norm one balance.

import { symmetricEigen } from "./linear.js";

const STILL = 1e-6; // share of the largest velocity below which the tip cannot be moved that way

/**
 * Half axes of both ellipsoids along common directions: sigma v for velocities, v / sigma for forces.
 *
 * @param {ArrayLike<number>} J  body Jacobian, 6 rows of n
 * @param {number} n
 * @param {ArrayLike<number>} T  pose of the tip, 16 numbers
 * @returns {{directions: number[][], velocities: number[], forces: (number | null)[]}}
 *   directions: three unit vectors in {s}, the fastest first; velocities: per unit of joint rates; forces: per unit of
 *   joint efforts, null where the tip cannot be moved and the structure bears any force
 *
 * Reference: Lynch and Park, Modern Robotics, sec. 5.4.
 */
export function tipEllipsoids(J, n, T) {
  const row = (i) => Array.from({ length: n }, (_, k) => J[(3 + i) * n + k]), rows = [0, 1, 2].map(row);
  const { values, vectors } = symmetricEigen(rows.map((a) => rows.map((b) => a.reduce((sum, x, k) => sum + x * b[k], 0))));
  const velocities = values.map((value) => Math.sqrt(Math.max(value, 0)));
  return {
    directions: vectors.map((v) => [0, 1, 2].map((i) => T[4 * i] * v[0] + T[4 * i + 1] * v[1] + T[4 * i + 2] * v[2])),
    velocities,
    forces: velocities.map((sigma) => (sigma > STILL * velocities[0] ? 1 / sigma : null)),
  };
}
