// Where a picture's samples lie: warp/resample.h's SourceGrid, and the names of wrapping.glsl.h.

export function gridOf(camera) {
    const {width, height} = camera;
    if (!camera.isSphere)
        return {width, height, isSphere: false, closes: false, north_pole: false, south_pole: false, middle: 0, top: 0,
                columnsPerRadian: 0, rowsPerRadian: 0, focal: 0.5 * width / Math.tan(0.5 * camera.fovX)};
    const [left, right] = camera.longitudes, [low, high] = camera.latitudes;
    const closes = right - left > 2 * Math.PI - 1e-9;
    return {width, height, isSphere: true, closes, north_pole: closes && high > Math.PI / 2 - 1e-9,
            south_pole: closes && low < -Math.PI / 2 + 1e-9, middle: 0.5 * (left + right), top: high,
            columnsPerRadian: width / (right - left), rowsPerRadian: height / (high - low), focal: 1};
}
