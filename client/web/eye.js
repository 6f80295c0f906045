// What shaders are told of an eye and of a source: eye_rays.glsl and source_grid.glsl, in their own layout.
import {gridOf} from "./grid.js";
import {conjugate, matrixOf, minus, multiply, rotate} from "./poses.js";

/// A view of so many square pixels; the middle is where the eye's axis meets it, in pixels from the upper left corner.
export const viewOf = (width, height, fovX) => ({
    width, height, focal: 0.5 * width / Math.tan(0.5 * fovX), middle: [0.5 * width, 0.5 * height],
});

/// How far views reach from the axis at a distance of 1, to either side, and up or down. A headset's are not even.
export const reachOf = views => ["width", "height"].map((side, i) => Math.max(
    ...views.map(view => Math.max(view.middle[i], view[side] - view.middle[i]) / view.focal)));

/// The angle from the axis to the farthest corner.
export const halfAngleOf = view => Math.atan(Math.hypot(...reachOf([view])));

export const distanceBetween = (a, b) => Math.hypot(...minus(a.position, b.position));

/// How far eyes beyond the head box of a picture make it fade, 0 to 1: as head_box_fading in
/// client/view/head_motion.cpp.
export function headBoxFading(eyes, {pose, boxRadius}) {
    const beyond = Math.max(...eyes.map(eye => distanceBetween(eye, pose))) - (boxRadius + 1e-6);
    return Math.min(Math.max(beyond / Math.max(0.25, 0.5 * boxRadius), 0), 1);
}

/// As EyeRays of a std140 block.
export function eyeBlock(view, eye, source, boxRadius, tolerance) {
    const {focal, middle} = view, m = matrixOf(multiply(conjugate(source.orientation), eye.orientation));
    const away = minus(eye.position, source.position);
    const [x, y, z] = [(0.5 - middle[0]) / focal, (middle[1] - 0.5) / focal, -1];
    const distance = distanceBetween(eye, source);
    return new Float32Array([
        m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z, 0,
        m[0] / focal, m[3] / focal, m[6] / focal, 0,
        -m[1] / focal, -m[4] / focal, -m[7] / focal, 0,
        ...rotate(conjugate(source.orientation), away), 0,
        ...rotate(conjugate(eye.orientation), away), 0,
        m[0], m[3], m[6], 0, m[1], m[4], m[7], 0, m[2], m[5], m[8], 0, 0, 0, 0, 1,
        focal, middle[0] - 0.5, middle[1] - 0.5, distance < 1e-9 ? 0 : 1,
        Math.max(boxRadius, distance), tolerance, 0, 0]);
}

export const eyeBlockFloats = 44;

export function gridBlock(camera) {
    const grid = gridOf(camera), words = new ArrayBuffer(48);
    new Int32Array(words).set([grid.width, grid.height, grid.isSphere, grid.closes, grid.north_pole, grid.south_pole]);
    new Float32Array(words, 24).set([grid.focal, grid.middle, grid.top, grid.columnsPerRadian, grid.rowsPerRadian]);
    return words;
}
