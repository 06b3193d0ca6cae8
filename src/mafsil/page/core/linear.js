// Small dense matrices as arrays of rows: what is shown of Jacobians; ellipsoids of the tip, velocities that joint rates
// of norm one make, forces that joint efforts of norm one balance.

const STILL = 1e-6; // share of the largest velocity below which the tip cannot be moved that way

/**
 * Eigenvalues, largest first, and unit eigenvectors of a symmetric matrix, by Jacobi's rotations.
 *
 * @param {number[][]} matrix
 * @returns {{values: number[], vectors: number[][]}}
 *
 * Reference: Golub and Van Loan, Matrix Computations, sec. 8.5.
 */
export function symmetricEigen(matrix) {
  const n = matrix.length, A = matrix.map((row) => row.slice()), V = A.map((_, i) => A.map((_, j) => Number(i === j)));
  for (let sweep = 0; sweep < 30; sweep++) {
    let off = 0;
    for (let p = 0; p < n; p++) for (let q = p + 1; q < n; q++) {
      off += A[p][q] * A[p][q];
      if (A[p][q] === 0) continue;
      const theta = (A[q][q] - A[p][p]) / (2 * A[p][q]);
      const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1)), c = 1 / Math.hypot(t, 1), s = t * c;
      for (let k = 0; k < n; k++) [A[k][p], A[k][q]] = [c * A[k][p] - s * A[k][q], s * A[k][p] + c * A[k][q]];
      for (let k = 0; k < n; k++) [A[p][k], A[q][k]] = [c * A[p][k] - s * A[q][k], s * A[p][k] + c * A[q][k]];
      for (let k = 0; k < n; k++) [V[k][p], V[k][q]] = [c * V[k][p] - s * V[k][q], s * V[k][p] + c * V[k][q]];
    }
    if (off < 1e-30) break;
  }
  const order = A.map((_, k) => k).sort((i, j) => A[j][j] - A[i][i]);
  return { values: order.map((k) => A[k][k]), vectors: order.map((k) => V.map((row) => row[k])) };
}

/** Singular values of a matrix of few rows, largest first: the ranges in which a Jacobian stretches. */
export function singularValues(rows) {
  const squares = rows.map((a) => rows.map((b) => a.reduce((sum, x, k) => sum + x * b[k], 0)));
  return symmetricEigen(squares).values.map((value) => Math.sqrt(Math.max(value, 0)));
}

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
