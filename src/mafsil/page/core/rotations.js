// Rotations for people and pointers: shown, not computed with; kernels do the mechanics.

/** Quaternion (w, x, y, z) of the rotation in 16 numbers of a pose. Reference: Shepperd, 1978. */
export function quaternionOf(T) {
  const [a, b, c] = [T[0], T[5], T[10]], trace = a + b + c, size = [trace, a, b, c];
  const most = size.indexOf(Math.max(...size)), root = Math.sqrt(Math.max(0, 1 + 2 * size[most] - trace)), f = 0.5 / root;
  const d = [T[9] - T[6], T[2] - T[8], T[4] - T[1]], s = [T[6] + T[9], T[2] + T[8], T[1] + T[4]];
  if (most === 0) return [root / 2, d[0] * f, d[1] * f, d[2] * f];
  if (most === 1) return [d[0] * f, root / 2, s[2] * f, s[1] * f];
  if (most === 2) return [d[1] * f, s[2] * f, root / 2, s[0] * f];
  return [d[2] * f, s[1] * f, s[0] * f, root / 2];
}

/** Product of quaternions. */
export function product([a, b, c, d], [w, x, y, z]) {
  return [a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y, a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w];
}

/** A quaternion turned about an axis of the world. */
export function turned(quaternion, axis, angle) {
  const s = Math.sin(angle / 2);
  return product([Math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s], quaternion);
}

/** Roll, pitch, yaw about the fixed axes x, y, z: R = Rz(yaw) Ry(pitch) Rx(roll) [rad]. */
export function rollPitchYaw(T) {
  const pitch = Math.atan2(-T[8], Math.hypot(T[0], T[4]));
  if (Math.hypot(T[0], T[4]) < 1e-9) return [Math.atan2(-T[6], T[5]), pitch, 0];
  return [Math.atan2(T[9], T[10]), pitch, Math.atan2(T[4], T[0])];
}

/** Quaternion of roll, pitch, yaw. */
export function quaternionFrom([roll, pitch, yaw]) {
  return turned(turned(turned([1, 0, 0, 0], [1, 0, 0], roll), [0, 1, 0], pitch), [0, 0, 1], yaw);
}

/** Rotation vector: axis times angle [rad]. */
export function rotationVector(T) {
  let [w, x, y, z] = quaternionOf(T);
  if (w < 0) [w, x, y, z] = [-w, -x, -y, -z];
  const sine = Math.hypot(x, y, z), factor = sine > 1e-12 ? 2 * Math.atan2(sine, w) / sine : 2;
  return [x * factor, y * factor, z * factor];
}
