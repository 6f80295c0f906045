// Poses: a position in metres and a unit quaternion [w, x, y, z] that takes the head's, eye's or camera's axes to the
// world's.

export const multiply = ([a, b, c, d], [e, f, g, h]) => [
    a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f,
    a * h + b * g - c * f + d * e];

export const conjugate = ([w, x, y, z]) => [w, -x, -y, -z];

export function normalized(q) {
    const length = Math.hypot(...q);
    return q.map(number => number / length);
}

/// Nine numbers, row by row.
export function matrixOf([w, x, y, z]) {
    return [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
            2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)];
}

export function rotate(q, [x, y, z]) {
    const m = matrixOf(q);
    return [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z];
}

export const aboutAxis = ([x, y, z], angle) => {
    const s = Math.sin(angle / 2);
    return [Math.cos(angle / 2), s * x, s * y, s * z];
};

/// The part of a turn that is about the vertical.
export function headingOf([w, , y]) {
    return Math.hypot(w, y) < 1e-6 ? [1, 0, 0, 0] : normalized([w, 0, y, 0]);
}

export const plus = (a, b) => a.map((number, i) => number + b[i]);
export const minus = (a, b) => a.map((number, i) => number - b[i]);

/// `local` is in the axes of `around`.
export const composed = (around, local) => ({
    position: plus(around.position, rotate(around.orientation, local.position)),
    orientation: normalized(multiply(around.orientation, local.orientation)),
});

/// side: -1 the left eye, 0 the middle between both, 1 the right one.
export const eyeOf = (head, side, ipd) =>
    composed(head, {position: [0.5 * side * ipd, 0, 0], orientation: [1, 0, 0, 0]});
