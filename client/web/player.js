// Which frame is on show when: of a recording by its time line, of a live stream the newest.
import {expectedFound} from "./bytes.js";
import {FrameMaker} from "./frames.js";
import {Recording} from "./recorded.js";
import {StreamReader} from "./stream.js";

/// After so many laps without a frame the decoder will not find one either.
const mostEmptyLaps = 3;

export class Player {
    /// Calls onNote(text) and onProblem(error).
    constructor(helper, name, {isLive, onNote, onProblem}) {
        this.helper = helper;
        this.name = name;
        this.isLive = isLive;
        // What is still on its way when it is closed is nobody's concern.
        this.onNote = text => this.isClosed || onNote(text);
        this.onProblem = error => {
            if (this.isClosed)
                return;
            this.hasFailed = true;
            onProblem(error);
        };
        this.ready = [];     // frames after the one on show, in order
        this.shown = null;   // nothing for a moment after a jump
        this.left = [];      // frames that were on show
        this.time = 0;       // of the time line, seconds from the first frame
        this.sought = null;  // on it: where to jump next, once a frame of the last jump is on show
        this.plays = true;
        this.loops = true;
        this.passed = 0;     // frames that went without having been shown
        this.bytes = 0;
        this.begin();
        this.recording = isLive ? null : new Recording(this.maker);
        this.hasCome = false;  // a frame, since it began
        this.emptyLaps = 0;    // one after the other
    }

    /// A stream begins: at first, and where a server that was lost is there again. The frame on show stays until the
    /// first one comes. What is still on its way of the stream before is left out.
    begin() {
        if (this.maker) {
            this.passed += this.maker.passed;
            this.maker.close();
        }
        const ifCurrent = act => what => maker === this.maker && act(what);
        const maker = this.maker = new FrameMaker(this.helper, {
            isLive: this.isLive, onProblem: ifCurrent(this.onProblem), onNote: ifCurrent(this.onNote),
            onFrame: frame => maker === this.maker ? this.came(frame) : maker.forget(frame),
        });
        this.packets = Promise.resolve();
        this.reader = new StreamReader(this.name, packet => {
            if (this.recording)
                this.recording.add(packet);
            else
                this.packets = this.packets.then(() => this.pushLive(maker, packet)).catch(ifCurrent(this.onProblem));
        }, maker.leftOut);
        this.highest = -1;  // index of a live stream's main packets
        this.noted = 0;
    }

    push(bytes) {
        this.bytes += bytes.length;
        this.reader.push(bytes);
        this.tellProblems();
    }

    /// A recording that its server sends over and over begins again with lower numbers.
    async pushLive(maker, packet) {
        const {role, key, info} = packet;
        if (role === "main" && maker === this.maker) {
            if (key && info.index <= this.highest) {
                await maker.finish();
                if (maker !== this.maker)
                    return;
                maker.restart();
                this.highest = -1;
            }
            this.highest = Math.max(this.highest, info.index);
        }
        await maker.push(packet);
    }

    tellProblems() {
        const problems = [...this.reader.problems];
        for (const problem of problems.slice(this.noted))
            this.onNote(problem);
        this.noted = problems.length;
    }

    /// There will be no more bytes.
    end() {
        if (this.recording)
            this.recording.isComplete = true;
        else
            this.packets = this.packets.then(() => this.maker.finish()).then(() => this.hasCome || this.nothingCame())
                .catch(this.onProblem);
        this.reader.end();
        if (this.recording)
            this.reader.requireAll();
        this.tellProblems();
    }

    /// Key frames are damaged, and without them there are no others.
    nothingCame() {
        if (!this.hasFailed)
            this.onProblem(expectedFound(this.reader.name, "pictures that can be decoded from a key frame on", "none"));
    }

    close() {
        this.isClosed = true;
        for (const frame of [...this.ready, ...this.left, this.shown])
            if (frame)
                this.maker.forget(frame);
        this.maker.close();
    }

    came(frame) {
        if (this.isClosed)
            return this.maker.forget(frame);
        this.hasCome = true;
        this.emptyLaps = 0;
        // Before a jump's key frame lie frames that are not wanted.
        if (this.recording && frame.index < this.recording.from)
            return this.maker.forget(frame);
        // A page that is not looked at is not refreshed: a live stream's older frames go at once.
        if (!this.recording) {
            this.passed += this.ready.length;
            this.forgetReady();
        }
        this.ready.push(frame);
    }

    get lateFrames() {
        return this.passed + this.maker.passed;
    }

    get length() {
        return this.recording?.length ?? 0;
    }

    timeOf(frame) {
        return frame.info.time - (this.recording?.start ?? 0);
    }

    /// Goes on for so many seconds. Whether another frame is on show now.
    advance(seconds) {
        const before = this.shown;
        if (this.recording)
            this.advanceRecording(seconds);
        else if (this.ready.length > 0)
            this.take();
        return this.shown !== before;
    }

    advanceRecording(seconds) {
        const {recording} = this;
        if (this.sought !== null && (this.shown || recording.isStarved))
            this.seekOn();
        recording.feed(() => this.ready.length).catch(this.onProblem);
        if (!this.shown && this.ready.length > 0) {
            this.take();
            this.time = this.sought ?? this.shown.due; // the next refresh goes on to where it is sought
        }
        if (!this.shown)
            return this.isExhausted && this.beginAgain();
        if (!this.plays)
            return;
        this.time += seconds;
        while (this.ready.length > 0 && this.dueTime(this.ready[0]) <= this.time + 1e-6)
            this.take();
        const next = this.shown.due + 1 / this.shown.info.framesPerSecond;
        if (this.ready.length > 0 || this.time < next)
            return;
        if (this.isExhausted)
            this.atEnd();
        else
            this.time = next;  // what has not been decoded is waited for
    }

    /// Whether all of the recording was decoded, and all that came of it was taken.
    get isExhausted() {
        return this.recording.isFinished && this.maker.waiting === 0 && this.ready.length === 0;
    }

    /// Of the next frame. A time beyond the one that its index implies is damaged.
    dueTime(frame) {
        const {shown} = this, time = this.timeOf(frame);
        return shown ? Math.min(time, shown.due + (frame.index - shown.index) / frame.info.framesPerSecond) : time;
    }

    /// From where it was to go on to its end there is no frame.
    beginAgain() {
        const {recording} = this;
        if (this.sought !== null)
            this.jump(this.sought);
        else if (recording.from > recording.frames[0] || (this.hasCome && this.emptyLaps++ < mostEmptyLaps))
            this.jump(0);
        else
            this.nothingCame();
    }

    atEnd() {
        if (this.loops && this.recording.frames.length === 1) {
            this.time = 0;  // it is on show already
        } else if (this.loops) {
            this.recording.rewind(this.recording.frames[0]);
            this.time = 0;
            this.rewound();
        } else {
            this.plays = false;
            this.isAtEnd = true;
        }
    }

    /// Plays, or stops. From the end it plays from the start.
    toggle() {
        if (this.isAtEnd)
            this.seek(0);
        this.plays = !this.plays;
    }

    rewound() {
        this.isAtEnd = false;
        this.forgetReady();
        if (this.shown)
            this.shown.isSkipped = true;
        this.leave();
    }

    forgetReady() {
        for (const frame of this.ready)
            this.maker.forget(frame);
        this.ready = [];
    }

    leave() {
        if (this.shown)
            this.left.push(this.shown);
        this.shown = null;
    }

    take() {
        const frame = this.ready.shift();
        frame.due = this.dueTime(frame);
        this.leave();
        this.shown = frame;
    }

    /// Frames that are not on show any more go, but for these.
    forgetLeft(kept) {
        for (const frame of this.left.filter(each => !kept.includes(each))) {
            this.passed += frame.wasShown || frame.isSkipped ? 0 : 1;
            this.maker.forget(frame);
        }
        this.left = this.left.filter(each => kept.includes(each));
    }

    /// Of a recording: to the frame at this time of the line. A jump waits for the frame of the one before it: a thumb
    /// that is dragged would else keep every one of them from being shown.
    seek(time) {
        const {recording} = this;
        if (!recording || recording.times.size === 0)
            return;
        const wanted = Math.min(Math.max(time, 0), this.length);
        if (this.shown)
            this.jump(wanted);
        else
            this.sought = this.time = wanted;
    }

    /// To where it was to go meanwhile, unless that is the frame of the last jump.
    seekOn() {
        const {recording, sought} = this;
        this.sought = null;
        if (recording.frameAt(recording.start + sought) !== recording.from)
            this.jump(sought);
        else if (this.shown)
            this.time = this.shown.due;
    }

    jump(time) {
        const {recording} = this;
        this.sought = null;
        recording.rewind(recording.frameAt(recording.start + time));
        this.time = time;
        this.rewound();
    }

    /// Of a recording: stops so many frames from the one on show.
    step(frames) {
        if (!this.shown || this.isLive)
            return;
        this.plays = false;
        const {frames: all, times, start} = this.recording, at = all.indexOf(this.shown.index) + frames;
        if (at >= 0 && at < all.length)
            this.seek(times.get(all[at]) - start);
    }

    /// The frame of this index, once it is decoded, on show.
    async frame(index) {
        if (this.shown?.index === index)
            return this.shown;
        this.plays = false;
        this.sought = null;
        this.recording.rewind(index);
        this.rewound();
        while (this.shown?.index !== index) {
            this.advance(0);
            await new Promise(resolve => setTimeout(resolve, 5));
        }
        return this.shown;
    }
}
