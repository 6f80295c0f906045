// A recorded stream: its packets as far as they have come, fed to the decoders as frames are wanted, over and over.

/// So many frames are decoded ahead of the one on show, and so many may be on their way.
const framesAhead = 3, framesOnTheWay = 24;

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
        this.first = Infinity;     // and last: the earliest and the latest time
        this.last = -Infinity;
        this.isComplete = false;
        this.rewind(0);
    }

    add(packet) {
        if (!this.packets.has(packet.role))
            this.packets.set(packet.role, []);
        this.packets.get(packet.role).push(packet);
        const {index, time} = packet.info;
        if (packet.role !== "main" || this.times.has(index))
            return;
        this.times.set(index, time);
        this.frames.splice(countWhile(this.frames, each => each < index), 0, index);
        this.first = Math.min(this.first, time);
        this.last = Math.max(this.last, time);
    }

    /// The index of the frame on show at a time.
    frameAt(time) {
        const count = countWhile(this.frames, each => this.times.get(each) <= time + 1e-6);
        return this.frames[Math.max(count - 1, 0)];
    }

    /// Seconds from the first frame to the end of the last.
    get length() {
        const main = this.packets.get("main") ?? [];
        return main.length === 0 ? 0 : this.last - this.first + 1 / main[0].info.framesPerSecond;
    }

    get start() {
        return this.times.size === 0 ? 0 : this.first;
    }

    /// Goes on from the last key frame at or before a frame.
    rewind(index) {
        this.maker.restart();
        this.next = new Map();
        this.fed = -1;  // the highest index of main
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
        const generation = this.maker.generation;
        while (generation === this.maker.generation && ready() < framesAhead && this.maker.waiting < framesOnTheWay &&
               await this.feedOne()) {
        }
        if (generation === this.maker.generation)
            this.feeding = false;
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
            while (role !== "main" && this.peek(role)?.info.index <= this.fed)
                await this.maker.push(this.take(role));
        return true;
    }
}
