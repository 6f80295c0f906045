// Fragmented MP4 as `equistream encode` writes it, in pieces of any size: tracks, then packets in the order they lie.
import {ByteQueue, ByteReader, expectedFound} from "./bytes.js";

/// Headers are small. A fragment is a group of at most 10,000 pictures in each track.
const largestHeader = 16 << 20, largestFragment = 1 << 30, mostTracks = 127, mostSamples = mostTracks * 10000;

/// The boxes of a box's content.
function* boxesIn(bytes, what) {
    const reader = new ByteReader(bytes, what);
    while (reader.left >= 8) {
        const size = reader.u32(), name = reader.name();
        const content = size === 1 ? reader.u64() - 16 : size === 0 ? reader.left : size - 8;
        if (!(content >= 0))
            throw expectedFound(what, "a box of at least its own header", `${size} bytes`);
        yield {name, content: reader.take(content)};
    }
}

function find(bytes, ...path) {
    let content = bytes;
    for (const name of path) {
        content = [...boxesIn(content, "mp4")].find(box => box.name === name)?.content;
        if (!content)
            return null;
    }
    return content;
}

function readTrack(trak) {
    const header = find(trak, "tkhd"), entries = find(trak, "mdia", "minf", "stbl", "stsd");
    if (!header || !entries)
        return null;
    const tkhd = new ByteReader(header, "mp4 track");
    tkhd.skip(header[0] === 1 ? 20 : 12);
    const id = tkhd.u32();
    const stsd = new ByteReader(entries, "mp4 sample description");
    stsd.skip(8);
    const [entry] = boxesIn(entries.subarray(stsd.at), "mp4 sample description");
    if (!entry || entry.content.length < 78)
        return null;
    // The fields of a visual sample entry come before its boxes.
    return {id, codec: entry.name, description: find(entry.content.subarray(78), "avcC")};
}

/// Where the samples of a fragment's track lie, from the fragment's first byte on: at most `most` of them.
function readRuns(traf, track, most) {
    const header = find(traf, "tfhd");
    if (!header)
        return null;
    const tfhd = new ByteReader(header, "mp4 fragment");
    const flags = tfhd.u32() & 0xffffff;
    track.id = tfhd.u32();
    if (flags & 1)
        throw expectedFound("mp4 fragment", "data counted from the fragment", "a place in the file");
    tfhd.skip(flags & 2 ? 4 : 0);
    tfhd.skip(flags & 8 ? 4 : 0);
    const usual = flags & 0x10 ? tfhd.u32() : 0;
    const runs = [];
    let left = most;
    for (const {name, content} of boxesIn(traf, "mp4 fragment")) {
        if (name !== "trun")
            continue;
        const trun = new ByteReader(content, "mp4 run");
        const has = trun.u32() & 0xffffff, count = trun.u32();
        const run = {offset: has & 1 ? trun.i32() : 0, sizes: []};
        trun.skip(has & 4 ? 4 : 0);
        const beside = (has & 0x100 ? 4 : 0) + (has & 0x400 ? 4 : 0) + (has & 0x800 ? 4 : 0);
        const each = beside + (has & 0x200 ? 4 : 0);
        if (count > left || (each > 0 && count > trun.left / each))
            throw expectedFound("mp4 run", `as many samples as there are bytes for, at most ${mostSamples} a fragment`,
                                `${count}`);
        left -= count;
        for (let i = 0; i < count; ++i) {
            trun.skip(has & 0x100 ? 4 : 0);
            const size = has & 0x200 ? trun.u32() : usual;
            if (size === 0)
                throw expectedFound("mp4 run", "samples that have bytes", "one of 0 bytes");
            run.sizes.push(size);
            trun.skip((has & 0x400 ? 4 : 0) + (has & 0x800 ? 4 : 0));
        }
        runs.push(run);
    }
    return runs;
}

export class Mp4Reader {
    /// Calls onTrack({id, codec, description}) and onPacket(id, bytes); the bytes are the packet's own.
    constructor(onTrack, onPacket) {
        this.onTrack = onTrack;
        this.onPacket = onPacket;
        this.queue = new ByteQueue();
        this.fragment = null;  // of a moof: its runs, and how many of its bytes have gone
    }

    static fits(bytes) {
        return bytes.length >= 8 && ["ftyp", "styp", "moov"].includes(String.fromCharCode(...bytes.subarray(4, 8)));
    }

    push(bytes) {
        this.queue.push(bytes);
        while (this.readBox()) {
        }
    }

    /// False where the rest has not come yet.
    readBox() {
        if (this.queue.length < 16)
            return false;
        const reader = new ByteReader(this.queue.peek(16), "mp4");
        const short = reader.u32(), name = reader.name();
        const size = short === 1 ? reader.u64() : short, header = short === 1 ? 16 : 8;
        const most = name === "mdat" ? largestFragment : largestHeader;
        if (!(size >= header && size <= most))
            throw expectedFound("mp4", `a box of at most ${most} bytes, as \`equistream encode\` writes`,
                                `${name} of ${size}`);
        if (this.queue.length < size)
            return false;
        const content = this.queue.peek(size).subarray(header);
        if (name === "moov")
            this.readTracks(content);
        else if (name === "moof")
            this.fragment = {runs: this.readFragment(content), from: size};
        else if (name === "mdat" && this.fragment)
            this.readPackets(content, this.fragment.from + header);
        this.queue.drop(size);
        return true;
    }

    /// There will be no more bytes. Of a fragment that was cut, the samples that are there are read.
    end() {
        if (!this.fragment || this.queue.length < 16)
            return;
        const reader = new ByteReader(this.queue.peek(16), "mp4");
        const header = reader.u32() === 1 ? 16 : 8;
        if (reader.name() === "mdat")
            this.readPackets(this.queue.peek(this.queue.length).subarray(header), this.fragment.from + header, true);
    }

    readTracks(moov) {
        const tracks = [...boxesIn(moov, "mp4")].filter(box => box.name === "trak");
        for (const {content} of tracks.slice(0, mostTracks)) {
            const track = readTrack(content);
            if (track)
                this.onTrack(track);
        }
    }

    readFragment(moof) {
        const all = [];
        let left = mostSamples;
        for (const {name, content} of boxesIn(moof, "mp4 fragment")) {
            if (name !== "traf")
                continue;
            const track = {};
            for (const run of readRuns(content, track, left) ?? []) {
                all.push({...run, id: track.id});
                left -= run.sizes.length;
            }
        }
        return all;
    }

    readPackets(data, dataOffset, isCut = false) {
        const packets = [];
        let total = 0;
        for (const {id, offset, sizes} of this.fragment.runs) {
            let at = offset - dataOffset;
            for (const size of sizes) {
                if (isCut && at + size > data.length)
                    break;
                total += size;  // samples that share bytes would take more than came
                if (!(at >= 0 && at + size <= data.length && total <= data.length))
                    throw expectedFound("mp4 fragment", "samples within its data", `one at ${at} of ${size} bytes`);
                packets.push({id, at, bytes: data.slice(at, at + size)});
                at += size;
            }
        }
        packets.sort((a, b) => a.at - b.at);
        for (const {id, bytes} of packets)
            this.onPacket(id, bytes);
        this.fragment = null;
    }
}
