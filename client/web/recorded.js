// A recorded stream: its packets as far as they have come, fed to the decoders as frames are wanted, over and over.
import {expectedFound} from "./bytes.js";

/// Frames that are decoded ahead of the one on show; and frames on their way, some of which decoders hold back.
const framesAhead = 3, framesOnTheWay = 24;
/// A track that has no packet for so many of main's has a hole, or has ended.
const longestSilence = 16;

/// A recording stays in memory as a whole. A browser that has no more of that ends the page without a word.
const mostBytes = 2e9;

/// Throws StreamError for a recording of so many bytes, if that is too many.
export function requireRoom(what, bytes, found = `${(bytes / 1e9).toFixed(1)} GB`) {
    if (bytes > mostBytes)
        throw expectedFound(what, "a recording of at most 2 GB, since the browser keeps all of it in memory " +
                            "(equistream serve --web sends larger ones)", found);
}

/// How many at the beginning of a sorted list are so.
function countWhile(list, isSo) {
    let low = 0, high = list.length;
    while (low < high) {
        const middle = (low + high) >> 1;
        if (isSo(list[middle]))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

export class Recording {
    constructor(maker) {
        this.maker = maker;
        this.packets = new Map();  // by role, in the order they are decoded in
        this.times = new Map();    // of main's frames, by index
        this.frames = [];          // these indices, ascending
        this.bytes = 0;            // of all packets
        this.isComplete = false;
        this.rewind(0);
    }

    add(packet) {
        this.bytes += packet.bytes.length;
        requireRoom("the stream so far", this.bytes, "more");
        if (!this.packets.has(packet.role))
            this.packets.set(packet.role, []);
        this.packets.get(packet.role).push(packet);
        const {index, time} = packet.info;
        if (packet.role !== "main" || packet.lacksInfo || this.times.has(index))
            return;
        this.times.set(index, time);
        this.frames.splice(countWhile(this.frames, each => each < index), 0, index);
    }

    /// The index of the frame on show at a time.
    frameAt(time) {
        return this.frames.findLast(each => this.times.get(each) <= time + 1e-6) ?? this.frames[0];
    }

    /// Seconds from the first frame to the end of the last.
    get length() {
        if (this.frames.length === 0)
            return 0;
        const {framesPerSecond} = this.packets.get("main").find(packet => !packet.lacksInfo).info;
        const first = this.frames[0], last = this.frames.at(-1);
        const span = Math.min(this.times.get(last) - this.start, (last - first) / framesPerSecond);  // one may be damaged
        return Math.max(span, 0) + 1 / framesPerSecond;
    }

    /// Whether the next frame may wait for bytes that have not come.
    get isStarved() {
        return !this.isComplete && [...this.packets.keys()].some(role => !this.peek(role));
    }

    get start() {
        return this.times.get(this.frames[0]) ?? 0;
    }

    /// Goes on from the last key frame at or before a frame.
    rewind(index) {
        this.maker.restart();
        this.next = new Map();
        this.fed = -1;  // the highest index of main
        this.silent = new Map();  // by role: main's packets since its own last one
        this.isFinished = false;
        this.feeding = false;
        this.from = index;
        for (const [role, packets] of this.packets) {
            let at = 0;
            packets.forEach((packet, i) => at = packet.key && packet.info.index <= index ? i : at);
            this.next.set(role, at);
        }
    }

    /// Decodes further where fewer frames than wanted are ready.
    async feed(ready) {
        if (this.feeding)
            return;
        this.feeding = true;
        const {maker} = this, {generation} = maker;
        maker.release();
        try {
            while (generation === maker.generation && ready() + maker.whole.length < framesAhead &&
                   maker.waiting < framesOnTheWay && !maker.isBusy && await this.feedOne()) {
            }
        } finally {
            if (generation === maker.generation)
                this.feeding = false;
        }
    }

    take(role) {
        const at = this.next.get(role) ?? 0;
        this.next.set(role, at + 1);
        return this.packets.get(role)[at];
    }

    peek(role) {
        return this.packets.get(role)?.[this.next.get(role) ?? 0];
    }

    async feedOne() {
        if (!this.peek("main")) {
            if (this.isComplete && !this.isFinished && this.fed >= 0) {
                const {generation} = this.maker;
                await this.maker.finish();
                if (generation === this.maker.generation)
                    this.isFinished = true;
            }
            return false;
        }
        const packet = this.take("main");
        this.fed = Math.max(this.fed, packet.info.index);
        await this.maker.push(packet);
        // The other tracks' packets of about the same frames: which come first differs with their B-frames.
        for (const role of this.packets.keys())
            if (role !== "main")
                await this.feedBeside(role);
        return true;
    }

    async feedBeside(role) {
        const begin = this.next.get(role) ?? 0;
        while (this.peek(role)?.info.index <= this.fed)
            await this.maker.push(this.take(role));
        const isSilent = (this.next.get(role) ?? 0) === begin && (this.peek(role) || this.isComplete);
        const silent = isSilent ? (this.silent.get(role) ?? 0) + 1 : 0;
        this.silent.set(role, silent);
        if (silent === longestSilence)
            await this.maker.rest(role);
    }
}
