// Frames of a Denavit-Hartenberg table, modified convention: T = Rx(alpha) Tx(a) Rz(theta) Tz(d).

/** 16 numbers of A B, row after row. */
function times(A, B) {
  return Array.from({ length: 16 }, (_, k) => {
    const i = k >> 2, j = k & 3;
    return A[4 * i] * B[j] + A[4 * i + 1] * B[4 + j] + A[4 * i + 2] * B[8 + j] + A[4 * i + 3] * B[12 + j];
  });
}

/**
 * @typedef {{a: number, alpha: number, d: number, theta: number, prismatic: boolean, place: number}} Row
 * @typedef {{base: number[], tool: number[], rows: Row[]}} Table
 */

/**
 * Poses of all frames in {s}.
 *
 * @param {Table} table
 * @param {number[]} q
 * @returns {number[][]}
 */
export function dhFrames({ base, rows }, q) {
  let T = base;
  return rows.map(({ a, alpha, d, theta, prismatic, place }) => {
    const angle = theta + (prismatic ? 0 : q[place]), length = d + (prismatic ? q[place] : 0);
    const ca = Math.cos(alpha), sa = Math.sin(alpha), c = Math.cos(angle), s = Math.sin(angle);
    T = times(T, [c, -s, 0, a, s * ca, c * ca, -sa, -sa * length, s * sa, c * sa, ca, ca * length, 0, 0, 0, 1]);
    return T;
  });
}

/** Poses of {s}, {0}, {1} to {n} and of the tip. @param {Table} table @param {number[]} q @returns {number[][]} */
export function dhChain(table, q) {
  const frames = dhFrames(table, q), identity = Array.from({ length: 16 }, (_, k) => Number(k % 5 === 0));
  return [identity, table.base, ...frames, times(frames.at(-1), table.tool)];
}

/** The arm of a table as Python. @param {Table} table */
export function dhPython({ base, tool, rows }) {
  const list = (T) => `[${[0, 4, 8, 12].map((k) => `[${T.slice(k, k + 4).join(", ")}]`).join(", ")}]`;
  const lines = rows.map(({ a, alpha, d, theta, prismatic }) => `    (${[a, alpha, d, theta].join(", ")}, "${prismatic ? "P" : "R"}"),`);
  return ["import mafsil as mf", "", "robot = mf.Robot.from_dh([", ...lines, `], "modified", base=${list(base)}, tool=${list(tool)})`, ""].join("\n");
}
