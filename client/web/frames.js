// Packets into whole frames: each role's picture of one index together, its depth as distances.
import {TrackDecoder} from "./decoder.js";
import {expectedFound} from "./bytes.js";

const depthOf = {main: "depth", window: "window-depth"};

/// Frames whose pictures have not all come, and of them those that hold some; older ones are given up. Recordings
/// have fewer on the way (recorded.js).
const mostPartial = 300, mostHeld = 32;
/// Packets that wait for a decoder: of a live stream, where more are left out up to the next key frames; and of a
/// recording, which goes on once there are fewer.
const mostQueued = 90, mostAhead = 6;

/// Of a picture and its depth, or of a sphere and its window: one place; of the first also one camera.
const samePose = (a, b) => JSON.stringify(a.pose) === JSON.stringify(b.pose);
const sameView = (a, b) => samePose(a, b) && JSON.stringify(a.camera) === JSON.stringify(b.camera);

/// Distinguishes pictures before and after a jump.
let generation = 0;

export class FrameMaker {
    /// Calls onFrame({index, info, main, window}) in ascending order of index; main and window are {info, picture,
    /// distances, key}. `onNote` is called with what is left out.
    constructor(helper, {onFrame, onNote, onProblem, isLive}) {
        this.helper = helper;
        this.onFrame = onFrame;
        this.onNote = onNote;
        this.onProblem = onProblem;
        this.isLive = isLive;
        this.decoders = new Map();
        this.leftOut = new Set();  // roles whose track cannot be shown
        this.passed = 0;           // frames that were left out because they came late
        this.number = 0;           // never used again: pictures from before a jump may still come
        this.restart();
    }

    /// Forgets all frames that are not whole.
    restart() {
        this.generation = ++generation;
        this.partial = new Map();
        this.infos = new Map();
        this.newest = new Map();  // by role: the last index that came
        this.started = new Set();
        this.whole = [];           // frames that wait for their depth to be unpacked
        this.inTurn = Promise.resolve();
        for (const decoder of this.decoders.values())
            decoder.reset();
    }

    get isClosed() {
        return this.generation === 0;
    }

    close() {
        this.generation = 0;
        for (const decoder of this.decoders.values())
            decoder.close();
    }

    async decoderOf(role, track) {
        if (!this.decoders.has(role)) {
            track.isLive = this.isLive;
            const decoder = new TrackDecoder(`${role} track`, track, {
                onPicture: (number, picture) => this.decoded(number, picture),
                onProblem: error => this.failed(role, error), onEnd: error => this.ended(role, error),
            });
            decoder.opening = decoder.open();
            this.decoders.set(role, decoder);
        }
        const decoder = this.decoders.get(role);
        await decoder.opening;
        return decoder;
    }

    /// Without its depth a picture is still turned; without itself there is nothing to see.
    failed(role, error) {
        if (role === "main")
            return this.onProblem(error);
        this.leftOut.add(role);
        this.onNote(`${error.message}: shown without it`);
        this.release();
    }

    /// Another decoder begins at the track's next key frame.
    ended(role, error) {
        if (error && role === "main")
            this.onProblem(error);
        else if (error)
            this.onNote(error.message);
        this.release();
    }

    /// Packets of a track must begin with a key frame.
    async push({role, track, key, info, bytes, lacksInfo, sets}) {
        if (this.isClosed || this.leftOut.has(role) || (!key && !this.started.has(role)))
            return;
        if (!lacksInfo && (info.packing !== "none" || info.isOds))
            return this.failed("main", expectedFound("main track", "one eye's sphere (encode --stereo tracks)",
                                                     `both eyes, ${info.packing}; equistream view plays it`));
        const {generation} = this;
        if (this.decoders.get(role)?.isClosed) {  // by an error, or by a browser that wanted its memory back
            if (!key)
                return;
            this.decoders.delete(role);
        }
        this.started.add(role);  // so that frames wait for it while its decoder opens
        let decoder;
        try {
            decoder = await this.decoderOf(role, track);
        } catch (error) {
            return this.failed(role, error);
        }
        if (generation !== this.generation)
            return;
        if (this.isLive && decoder.waiting >= mostQueued) {
            this.started.clear();
            this.passed += role === "main" ? 1 : 0;
            return;
        }
        const number = ++this.number;
        if (!lacksInfo) {
            this.infos.set(number, {role, info, generation});
            this.frame(info.index).expected.add(role);
        }
        decoder.push(number, key, bytes, sets);
    }

    get waiting() {
        return this.partial.size + this.whole.length;
    }

    /// Whether a decoder has as many packets as it needs to go on.
    get isBusy() {
        return [...this.decoders.values()].some(decoder => decoder.waiting >= mostAhead);
    }

    /// Stops waiting for a track that has been silent for long. Its decoder is flushed, and it begins again with a key
    /// frame.
    async rest(role) {
        const {generation} = this;
        await this.decoders.get(role)?.finish();
        if (generation !== this.generation)
            return;
        this.started.delete(role);
        this.release();
    }

    /// All that was pushed goes on, unless there is a restart meanwhile.
    async finish() {
        const {generation} = this;
        await Promise.all([...this.decoders.values()].map(decoder => decoder.finish()));
        if (generation !== this.generation)
            return;
        this.isFinished = true;
        this.release();
        this.isFinished = false;
        await this.inTurn;
    }

    frame(index) {
        if (!this.partial.has(index)) {
            if (this.partial.size >= mostPartial)
                this.giveUp([...this.partial.keys()]);
            this.partial.set(index, {expected: new Set(), pictures: new Map()});
        }
        return this.partial.get(index);
    }

    /// The oldest of these frames waits no more.
    giveUp(indices) {
        const index = Math.min(...indices), {pictures} = this.partial.get(index);
        this.partial.delete(index);
        if (pictures.has("main"))
            this.unpack(index, pictures);
        else
            ++this.passed;
    }

    decoded(number, picture) {
        const known = this.infos.get(number);
        this.infos.delete(number);
        if (!known || known.generation !== this.generation)
            return;
        const {role, info} = known;
        this.newest.set(role, info.index);
        if (this.isAsTagged(role, info, picture))
            this.partial.get(info.index)?.pictures.set(role, {info, picture});
        const held = [...this.partial.keys()].filter(index => this.partial.get(index).pictures.size > 0);
        if (held.length > mostHeld)
            this.giveUp(held);
        this.release();
    }

    isAsTagged(role, info, picture) {
        const step = info.depth?.halved ? 2 : 1, width = info.camera.width / step, height = info.camera.height / step;
        if (picture.width !== width || picture.height !== height)
            this.onNote(expectedFound(`${role} picture ${info.index}`, `${width}x${height} as it is tagged`,
                                      `${picture.width}x${picture.height}`).message);
        else if (role in depthOf && picture.planes[0].bits !== 8)
            this.failed(role, expectedFound(`${role} track`, "8 bits a sample (encode --transfer srgb)", "HDR"));
        else if (role in depthOf && !picture.isHalved)
            this.failed(role, expectedFound(`${role} track`, "colour of half the size (4:2:0)", "4:4:4"));
        else
            return true;
        return false;
    }

    /// Frames go on in order, once all of their pictures have come or never will.
    release() {
        for (const index of [...this.partial.keys()].sort((a, b) => a - b)) {
            const {pictures} = this.partial.get(index);
            if (!this.isFinished && ["main", ...this.decoders.keys()].some(role => this.isAwaited(role, index)))
                return;
            this.partial.delete(index);
            if (pictures.has("main"))
                this.unpack(index, pictures);
        }
    }

    /// Whether a picture of this role may still come for a frame. In a container the tracks may lie apart.
    isAwaited(role, index) {
        const {expected, pictures} = this.partial.get(index);
        if (this.leftOut.has(role) || pictures.has(role) || this.newest.get(role) > index ||
            this.decoders.get(role)?.isClosed)
            return false;
        // A recording's packets come in turn: a track that lacks its key frame here says nothing up to the next.
        return this.isLive || this.started.has(role) || expected.has(role);
    }

    /// One frame after the other. Live, the newest takes the place of the one that waits.
    unpack(index, pictures) {
        if (this.isLive) {
            this.passed += this.whole.length;
            this.whole = [];
        }
        this.whole.push({index, pictures});
        const made = this.generation;
        this.inTurn = this.inTurn.then(() => this.make(made)).catch(this.onProblem);
    }

    async make(made) {
        if (made !== this.generation || this.whole.length === 0)
            return;
        const {index, pictures} = this.whole.shift();
        const frame = {index, info: pictures.get("main").info};
        for (const role of ["main", "window"])
            if (pictures.has(role) && !this.leftOut.has(role))
                frame[role] = await this.withDepth(role, pictures.get(role), pictures.get(depthOf[role]));
        // A window without the distances that the sphere has would take them from all.
        const {window, main} = frame;
        if (window && ((main.distances && !window.distances) || !samePose(window.info, main.info) ||
                       !window.info.camera.isSphere)) {
            this.forget({window});
            delete frame.window;
        }
        if (made === this.generation)
            this.onFrame(frame);
        else
            this.forget(frame);
    }

    async withDepth(role, {info, picture}, depth) {
        const view = {info, picture, key: `${this.generation}.${role}.${info.index}`};
        if (!depth?.info.depth || this.leftOut.has(depthOf[role]))
            return view;
        if (!sameView(info, depth.info)) {
            this.onNote(expectedFound(`depth of frame ${info.index}`, "the camera and pose of its colour", "others")
                .message);
            return view;
        }
        try {
            const [{data, stride}] = picture.planes;
            const luma = {data: depth.info.depth.halved ? data.slice() : new Uint8Array(0), stride};
            const order = {key: view.key, picture: depth.picture, info: depth.info, luma};
            view.distances = (await this.helper.ask("depth", order)).distances;
        } catch (error) {
            this.failed(depthOf[role], error);
        }
        return view;
    }

    /// A frame that nobody shows any more.
    forget(frame) {
        for (const view of [frame.main, frame.window])
            if (view?.distances)
                this.helper.ask("forget", {key: view.key}).catch(() => {});  // where the helper has ended, it is gone
    }
}
