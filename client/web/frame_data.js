// What each coded picture says of itself (docs/stream-format.md, "Frame data"), found in H.264 packets of avcC's form.
import {ByteReader, StreamError, expectedFound} from "./bytes.js";

const uuid = [0x69, 0xc4, 0x80, 0x36, 0x51, 0x33, 0x47, 0x84, 0x80, 0x93, 0xec, 0x66, 0xa7, 0x47, 0x51, 0x19];
export const roles = ["main", "small", "depth", "hidden", "hidden-depth", "patches", "patches-depth", "images",
                      "window", "window-depth", "window-images"];
export const depthCodes = ["pece444", "pece420", "hue", "w8", "w10", "w12", "lossless"];
const what = "frame data in the stream";
const largestSide = 32768, mostPixels = 2 ** 28, leastAngle = 0.001, mostQuaternionError = 0.001;

function require(good, name, found) {
    if (!good)
        throw expectedFound(what, `${name} in its range`, `${found}`);
}

class FrameDataReader extends ByteReader {
    number(name, least, most) {
        const value = this.f64();
        require(value >= least && value <= most, name, value);
        return value;
    }
    upTo(name, most) {
        const value = this.u8();
        require(value <= most, name, value);
        return value;
    }
    pose(name) {
        const position = [0, 1, 2].map(() => this.number(name, -1e9, 1e9));
        const orientation = [0, 1, 2, 3].map(() => this.number(name, -2, 2));
        const length = Math.hypot(...orientation);
        require(Math.abs(length - 1) < mostQuaternionError, `a unit quaternion of the ${name}`, length);
        return {position, orientation: orientation.map(each => each / length)};
    }
    short() {
        return this.text(this.u8());
    }
}

const packings = ["none", "side by side", "one above the other"];

function readCamera(fields, isFlat, width, height) {
    const numbers = [0, 1, 2, 3].map(() => fields.number("camera", -100, 100));
    const [first, second, third, fourth] = numbers;
    if (isFlat) {
        require(first >= leastAngle && first < Math.PI, "field of view", first);
        return {isSphere: false, width, height, fovX: first};
    }
    require(second - first >= leastAngle && second - first <= 2 * Math.PI + 1e-9, "longitudes", `${numbers}`);
    require(fourth - third >= leastAngle && third >= -Math.PI / 2 - 1e-9 && fourth <= Math.PI / 2 + 1e-9, "latitudes",
            `${numbers}`);
    return {isSphere: true, width, height, longitudes: [first, second], latitudes: [third, fourth]};
}

function readDepthCode(fields) {
    const code = depthCodes[fields.upTo("depth code", depthCodes.length - 1)];
    const hasEmpty = fields.upTo("whether pixels may hold no surface", 1) === 1;
    const boxRadius = fields.number("head box radius", Number.MIN_VALUE, 1e9);
    const near = fields.number("nearest depth", Number.MIN_VALUE, 1e30);
    require(Math.fround(near) > Math.fround(boxRadius), "nearest depth", near);
    fields.u32();
    return {code, hasEmpty, boxRadius, near, halved: false};
}

function readFields(fields) {
    const info = {role: roles[fields.upTo("track role", roles.length - 1)]};
    const kind = fields.upTo("camera kind", 2), isFlat = kind === 1;
    info.isOds = kind === 2;
    info.eye = fields.upTo("eye", 2);
    fields.upTo("axis lock", 1);
    const width = fields.u32(), height = fields.u32();
    require(width >= 1 && height >= 1 && width <= largestSide && height <= largestSide && width * height <= mostPixels,
            "camera size", `${width}x${height}`);
    info.ordinal = fields.u32();
    info.count = fields.u32();
    info.index = fields.i64();
    require(info.index >= 0 && info.index <= 999999999, "frame index", info.index);
    info.time = fields.number("time", -1e10, 1e10);
    info.framesPerSecond = fields.number("frames per second", 1e-6, 1e6);
    info.camera = readCamera(fields, isFlat, width, height);
    info.pose = fields.pose("camera pose");
    info.head = fields.pose("head pose");
    info.ipd = fields.number("interpupillary distance", 0, 10);
    info.lean = fields.number("head box radius", 0, 1000);
    // Of a sphere at an eye the other eye is a whole distance away.
    info.boxRadius = info.lean + (info.eye === 0 ? 0.5 : 1) * info.ipd;
    require(fields.f64() > 0, "exposure", "another");
    fields.skip(12);
    info.scene = fields.short();
    fields.short();
    if (fields.left > 0)
        fields.short();
    if (fields.left > 0 && fields.upTo("whether depth is coded", 1))
        info.depth = readDepthCode(fields);
    if (fields.left > 0)
        fields.skip(fields.u16());
    if (fields.left > 0 && fields.upTo("whether depth is halved", 1)) {
        require(info.depth, "depth, where it is halved", "none");
        info.depth.halved = true;
    }
    // What clients go by that have a confidence map, or that move what moves by itself.
    if (fields.left > 0)
        fields.skip(4);
    if (fields.left > 0 && fields.upTo("whether the visible loss was measured", 1))
        fields.skip(8);
    if (fields.left > 0)
        fields.skip(fields.u16());
    if (fields.left > 0)
        fields.short();
    info.packing = packings[fields.left > 0 ? fields.upTo("packing of both eyes", packings.length - 1) : 0];
    return info;
}

/// Null where the payload is another's.
function readPayload(payload) {
    const starts = at => uuid.every((byte, i) => payload[at + i] === byte);
    const at = starts(0) ? 0 : starts(16) ? 16 : -1;
    if (at < 0)
        return null;
    const header = new ByteReader(payload.subarray(at + 16), what, true);
    const version = header.u16();
    if (version !== 1)
        throw expectedFound(what, "version 1, which this page reads", `version ${version}`);
    return readFields(new FrameDataReader(header.take(header.u16()), what, true));
}

/// A unit's bytes without those that keep start codes out of it.
function unescaped(bytes) {
    const out = new Uint8Array(bytes.length);
    let count = 0, zeros = 0;
    for (const byte of bytes) {
        if (zeros >= 2 && byte === 3) {
            zeros = 0;
            continue;
        }
        zeros = byte === 0 ? zeros + 1 : 0;
        out[count++] = byte;
    }
    return out.subarray(0, count);
}

function readMessages(unit) {
    const messages = new ByteReader(unescaped(unit), "SEI in the stream");
    const number = () => {
        let sum = 0, byte;
        do
            sum += byte = messages.u8();
        while (byte === 255);
        return sum;
    };
    while (messages.left > 2) {
        const type = number(), payload = messages.take(number());
        const info = type === 5 ? readPayload(payload) : null;
        if (info)
            return info;
    }
    return null;
}

function readInfo(unit, picture) {
    try {
        picture.info = readMessages(unit);
    } catch (error) {
        if (!(error instanceof StreamError))
            throw error;
        picture.problem = error;
    }
}

/// Of an H.264 packet whose units have lengths of so many bytes before them: {key, info, problem, sps, pps}. Without
/// info it is decoded all the same, for others are made from it; the problem is what is wrong with it. The parameter
/// sets are null where the packet has none.
export function readPicture(packet, lengthBytes) {
    const reader = new ByteReader(packet, "H.264 in the stream");
    const picture = {key: false, info: null, problem: null, sps: null, pps: null};
    while (reader.left > 0) {
        let size = 0;
        for (let i = 0; i < lengthBytes; ++i)
            size = 256 * size + reader.u8();
        const unit = reader.take(size);
        const type = size > 0 ? unit[0] & 31 : 0;
        picture.key ||= type === 5;
        if (type === 7)
            picture.sps = unit;
        else if (type === 8)
            picture.pps = unit;
        if (type === 6 && !picture.info)
            readInfo(unit.subarray(1), picture);
    }
    return picture;
}

/// What WebCodecs is told of a track: its name and how many bytes lengths have.
export function describeAvc(description) {
    if (!description || description.length < 7 || description[0] !== 1)
        throw expectedFound("H.264 track", "its avcC header", "none");
    const hex = [...description.subarray(1, 4)].map(byte => byte.toString(16).padStart(2, "0")).join("");
    return {codec: `avc1.${hex}`, lengthBytes: (description[4] & 3) + 1};
}

/// An avcC header with these parameter sets in place of its own (ISO/IEC 14496-15). What else it says of the samples
/// stays: it is the same for all sizes of a track.
export function withParameterSets(description, {sps, pps}) {
    const reader = new ByteReader(description, "avcC header");
    reader.take(5);
    for (const mask of [31, 255])
        for (let left = reader.u8() & mask; left > 0; --left)
            reader.take(reader.u16());
    const sized = unit => [unit.length >> 8, unit.length & 255, ...unit];
    return new Uint8Array([1, ...sps.subarray(1, 4), description[4], 0xe1, ...sized(sps), 1, ...sized(pps),
                           ...reader.take(reader.left)]);
}
