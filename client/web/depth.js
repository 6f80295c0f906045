// A depth track's samples as distances in metres (docs/stream-format.md, "Depth"); NaN where there is no surface.
import {expectedFound} from "./bytes.js";
import {are_joined} from "./formulas.js";

const peceHalfPeriod = 256, peceFull = 65407;
/// Of halved depth: a quarter of a pixel of the default display (docs/conventions.md, "One bound").
const guidedTolerance = Math.sin(0.25 / 960);

/// A sample's distance is found in a table by its number; `scale` has numbers between whole samples too.
function distanceOf(range, full, sample) {
    const top = range.hasEmpty ? full - Math.floor(full / 8) : full;
    const last = range.hasEmpty ? (top + full) / 2 : Infinity;
    if (sample > last)
        return NaN;
    const box = Math.fround(range.boxRadius), near = Math.fround(range.near);
    return Math.max((near - box) * top / Math.max(sample, 0) + box, near);
}

function tableOf(range, full, count, sampleAt) {
    return Float32Array.from({length: count}, (_, i) => distanceOf(range, full, sampleAt(i)));
}

/// By its code: makes a function (planes, column, row) that gives a distance.
function lookUp(planes, range) {
    const [luma, , wave] = planes;
    if (range.code === "w8" || range.code === "w10") {
        const full = range.code === "w8" ? 255 : 1023;
        if (luma.bits !== (full === 255 ? 8 : 10))
            throw expectedFound(`depth track of ${range.code}`, "its samples", `${luma.bits} bits`);
        const table = tableOf(range, full, full + 1, i => i);
        return (x, y) => table[luma.data[y * luma.stride + x]];
    }
    const halvings = range.code === "pece420" ? 1 : 0;
    // d by luma and the second wave.
    const table = tableOf(range, peceFull, 65536, i => {
        const top = i >> 8, along = i & 1 << 8 ? i & 255 : 255 - (i & 255);
        return top * peceHalfPeriod - peceHalfPeriod / 2 + along * peceHalfPeriod / 255;
    });
    return (x, y) => table[luma.data[y * luma.stride + x] << 8 |
                           wave.data[(y >> halvings) * wave.stride + (x >> halvings)]];
}

/// Depth codes that this page reads.
export const readableCodes = ["w8", "w10", "pece420", "pece444"];

/// planes: {width, height, planes: [{data, stride, bits}, ...]} as decoded. Distances of the camera's samples.
export function unpackDepth(picture, info, lumaOfColour) {
    const {width, height} = info.camera, range = info.depth;
    if (!readableCodes.includes(range.code))
        throw expectedFound("depth track", `a code of ${readableCodes.join(", ")} (encode --depth pece420)`,
                            range.code);
    const step = range.halved ? 2 : 1;
    if (picture.width !== width / step || picture.height !== height / step)
        throw expectedFound("depth track", `${width / step}x${height / step} samples`,
                            `${picture.width}x${picture.height}`);
    const at = lookUp(picture.planes, range);
    const samples = new Float32Array(picture.width * picture.height);
    for (let y = 0, i = 0; y < picture.height; ++y)
        for (let x = 0; x < picture.width; ++x)
            samples[i++] = at(x, y);
    return range.halved ? guidedDepth(samples, picture.width, picture.height, lumaOfColour, info) : samples;
}

/// Of halved depth: each pixel takes the sample among those around whose colour is most like its own
/// (decoded_pictures.h, guided_depth).
function guidedDepth(halved, width, height, luma, info) {
    const {isSphere, longitudes} = info.camera;
    const closes = isSphere && longitudes[1] - longitudes[0] > 2 * Math.PI - 1e-9;
    const box = info.depth.boxRadius, {data, stride} = luma;
    const inverse = Float32Array.from(halved, distance => 1 / distance);
    const sums = new Int32Array(width * height);
    for (let y = 0, i = 0; y < height; ++y)
        for (let x = 0; x < width; ++x, ++i) {
            const at = 2 * y * stride + 2 * x;
            sums[i] = data[at] + data[at + 1] + data[at + stride] + data[at + stride + 1];
        }
    const outside = -1;
    const column = x => closes ? (x + width) % width : x < 0 || x >= width ? outside : x;
    const row = y => y < 0 || y >= height ? outside : y;
    const columns = [0, 0, 0, 0], rows = [0, 0, 0, 0], places = [0, 0, 0, 0];
    const guided = new Float32Array(4 * width * height);
    const k = i => places[i] === outside ? NaN : inverse[places[i]];
    for (let y = 0; y < 2 * height; ++y) {
        const down = y % 2 === 0 ? -1 : 1;
        for (let i = 0; i < 4; ++i)
            rows[i] = row((y >> 1) + (i - 1) * down);
        for (let x = 0; x < 2 * width; ++x) {
            const across = x % 2 === 0 ? -1 : 1;
            for (let i = 0; i < 4; ++i)
                columns[i] = column((x >> 1) + (i - 1) * across);
            const here = 4 * data[y * stride + x];
            let chosen = rows[1] * width + columns[1];
            let nearest = Math.abs(here - sums[chosen]) - 4;
            for (let way = 1; way < 4 && nearest >= 0; ++way) {
                for (let i = 0; i < 4; ++i) {
                    const c = columns[way & 1 ? i : 1], r = rows[way & 2 ? i : 1];
                    places[i] = c === outside || r === outside ? outside : r * width + c;
                }
                if (places[2] === outside || (places[0] === outside && places[3] === outside))
                    continue;
                const off = Math.abs(here - sums[places[2]]);
                if (off > nearest || are_joined(k(0), k(1), k(2), k(3), box, guidedTolerance))
                    continue;
                nearest = off - 1;
                chosen = places[2];
            }
            guided[y * 2 * width + x] = halved[chosen];
        }
    }
    return guided;
}
