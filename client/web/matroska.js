// Matroska as `equistream encode` and `serve` write it, in pieces of any size: tracks, then packets in their order.
import {ByteQueue, ByteReader, expectedFound} from "./bytes.js";

const id = {
    header: 0x1a45dfa3, segment: 0x18538067, cluster: 0x1f43b675, tracks: 0x1654ae6b, trackEntry: 0xae,
    trackNumber: 0xd7, codecId: 0x86, codecPrivate: 0x63a2, simpleBlock: 0xa3, blockGroup: 0xa0, block: 0xa1,
};
/// Their content is elements, and they may end anywhere.
const opened = new Set([id.segment, id.cluster, id.blockGroup]);
const largestHeader = 16 << 20, largestPacket = 256 << 20, mostTracks = 127;

/// A number whose first byte says how many bytes it has; null where they have not all come. Sizes lose that mark, and
/// those whose bits are all set are unknown: Infinity.
function readNumber(bytes, at, mostBytes, isSize) {
    if (at >= bytes.length)
        return null;
    const count = Math.clz32(bytes[at]) - 23;
    if (count > mostBytes)
        throw expectedFound("matroska", `a number of at most ${mostBytes} bytes`, `a first byte of ${bytes[at]}`);
    if (at + count > bytes.length)
        return null;
    const mask = (0x80 >> (count - 1)) - 1;
    let value = isSize ? bytes[at] & mask : bytes[at], unknown = (bytes[at] & mask) === mask;
    for (let i = 1; i < count; ++i) {
        value = 256 * value + bytes[at + i];
        unknown = unknown && bytes[at + i] === 255;
    }
    return {value: isSize && unknown ? Infinity : value, bytes: count};
}

function readElement(bytes, at) {
    const name = readNumber(bytes, at, 4, false);
    const size = name && readNumber(bytes, at + name.bytes, 8, true);
    return size && {id: name.value, size: size.value, header: name.bytes + size.bytes};
}

function* elementsIn(bytes) {
    for (let at = 0; at < bytes.length;) {
        const element = readElement(bytes, at);
        if (!element || !(element.size <= bytes.length - at - element.header))
            throw expectedFound("matroska", "elements within their parent", `${bytes.length - at} bytes left`);
        at += element.header;
        yield {id: element.id, content: bytes.subarray(at, at + element.size)};
        at += element.size;
    }
}

function readTrack(entry) {
    const track = {id: 0, codec: "", description: null};
    for (const {id: name, content} of elementsIn(entry)) {
        if (name === id.trackNumber)
            track.id = content.reduce((sum, byte) => 256 * sum + byte, 0);
        else if (name === id.codecId)
            track.codec = new ByteReader(content, "matroska").text(content.length);
        else if (name === id.codecPrivate)
            track.description = content.slice();
    }
    track.codec = {"V_MPEG4/ISO/AVC": "avc1", "V_MPEGH/ISO/HEVC": "hvc1"}[track.codec] ?? track.codec;
    return track;
}

export class MatroskaReader {
    /// As Mp4Reader's.
    constructor(onTrack, onPacket) {
        this.onTrack = onTrack;
        this.onPacket = onPacket;
        this.queue = new ByteQueue();
        this.skipping = 0;
    }

    static fits(bytes) {
        return bytes.length >= 4 && new ByteReader(bytes, "matroska").u32() === id.header;
    }

    push(bytes) {
        this.queue.push(bytes);
        while (this.read()) {
        }
    }

    /// There will be no more bytes: whole pictures have gone already.
    end() {}

    read() {
        if (this.skipping > 0) {
            const count = Math.min(this.skipping, this.queue.length);
            this.queue.drop(count);
            this.skipping -= count;
            if (this.skipping > 0)
                return false;
        }
        const bytes = this.queue.peek(this.queue.length);
        const element = readElement(bytes, 0);
        if (!element)
            return false;
        const {id: name, size, header} = element;
        if (opened.has(name)) {
            this.queue.drop(header);
            return true;
        }
        const isPacket = name === id.simpleBlock || name === id.block;
        if (!isPacket && name !== id.tracks) {
            if (size === Infinity)
                throw expectedFound("matroska", "an element whose size is known", `0x${name.toString(16)}`);
            this.queue.drop(header);
            this.skipping = size;
            return true;
        }
        const most = isPacket ? largestPacket : largestHeader;
        if (!(size <= most))
            throw expectedFound("matroska", `an element of at most ${most} bytes`, `${size}`);
        if (bytes.length < header + size)
            return false;
        const content = bytes.subarray(header, header + size);
        if (isPacket)
            this.readPacket(content);
        else
            this.readTracks(content);
        this.queue.drop(header + size);
        return true;
    }

    readTracks(content) {
        const entries = [...elementsIn(content)].filter(element => element.id === id.trackEntry);
        for (const entry of entries.slice(0, mostTracks))
            this.onTrack(readTrack(entry.content));
    }

    readPacket(content) {
        const number = readNumber(content, 0, 8, true);
        if (!number || content.length <= number.bytes + 3)
            throw expectedFound("matroska", "a block with its header and a picture", `${content.length} bytes`);
        if (content[number.bytes + 2] & 6)
            throw expectedFound("matroska", "blocks of one picture", "laces");
        this.onPacket(number.value, content.slice(number.bytes + 3));
    }
}
