// The page: where a stream comes from, and what is on show.
import {StreamError} from "./bytes.js";
import {layouts, listenFor, of} from "./controls.js";
import {headBoxFading, viewOf} from "./eye.js";
import {FollowedHead} from "./followed.js";
import {openGl} from "./gl.js";
import {Head} from "./head.js";
import {Helper} from "./helper.js";
import {LiveStream} from "./live.js";
import {ShownFrame} from "./picture.js";
import {Player} from "./player.js";
import {composed, eyeOf} from "./poses.js";
import {requireRoom} from "./recorded.js";
import {Renderer} from "./renderer.js";
import {Headset} from "./xr.js";

const textOf = id => JSON.parse(of(id).textContent);
const words = new URLSearchParams(location.search);
const defaultFov = 90 * Math.PI / 180;
/// A head that a headset says is farther away than this has moved.
const stillMetres = 0.003;
/// Of one stream. A damaged one would have a note for each picture.
const mostNotes = 4;

class Page {
    constructor() {
        this.canvas = of("picture");
        this.gl = openGl(this.canvas);
        this.renderer = new Renderer(this.gl, textOf("shaders"), textOf("numbers"));
        this.helper = new Helper(textOf("worker"));
        this.shownFrame = new ShownFrame(this.renderer, this.helper, error => this.fail(error));
        this.head = new Head(this.canvas);
        this.layout = Math.max(0, layouts.indexOf(words.get("layout")));
        this.player = null;
        this.isSought = false;  // the time line's thumb is held
        this.refreshes = [];  // when the last ones were, milliseconds
        this.times = {opened: null, firstPicture: null};
        this.lost = "";  // of a server, in one line
        this.fading = 0;  // 0 to 1: how far the picture has gone to grey
        this.isExact = false;  // a test says what is shown
        this.headset = new Headset(this.gl, (...seen) => this.drawHeadset(...seen), () => this.refreshAgain());
        listenFor(this);
        this.refreshAgain();
    }

    // Streams.

    open(name, isLive) {
        this.live?.close();
        this.live = null;
        this.player?.close();
        this.shownFrame.clear();
        of("problem").textContent = of("note").textContent = this.lost = "";
        this.fading = 0;
        of("start").hidden = true;
        of("loading").hidden = false;
        this.times = {opened: performance.now(), firstPicture: null};
        this.followed = new FollowedHead();
        const notes = new Set();
        this.player = new Player(this.helper, name, {
            isLive, onProblem: error => this.fail(error),
            onNote: text => notes.size < mostNotes && (of("note").textContent = [...notes.add(text)].join("; ")),
        });
        this.player.loops = words.get("loop") !== "0";
        return this.player;
    }

    async read(name, bytes) {
        const player = this.open(name, false);
        try {
            for await (const piece of bytes()) {
                if (player.isClosed)
                    return;
                player.push(piece);
            }
            player.end();
        } catch (error) {
            player.onProblem(error);
            player.recording.isComplete = true;  // what came is played
        }
    }

    openFile(file) {
        return this.read(file.name, async function* () {
            requireRoom(file.name, file.size);
            for (let at = 0; at < file.size; at += 1 << 20)
                yield new Uint8Array(await file.slice(at, at + (1 << 20)).arrayBuffer());
        });
    }

    openUrl(url) {
        return this.read(url, async function* () {
            const answer = await fetch(url).catch(error => {
                throw new StreamError(`${url}: cannot be fetched (${error.message})`);
            });
            if (!answer.ok)
                throw new StreamError(`${url}: the server answers ${answer.status} ${answer.statusText}`);
            const reader = answer.body.getReader();
            try {
                requireRoom(url, Number(answer.headers.get("Content-Length")));
                for (let piece = await reader.read(); !piece.done; piece = await reader.read())
                    yield piece.value;
            } finally {
                reader.cancel().catch(() => {});
            }
        });
    }

    /// `key`: what the server wants to know, behind the address; it is shown nowhere.
    openLive(url, key) {
        const player = this.open(url, true);
        this.live = new LiveStream(url, key, {
            onBytes: bytes => player.push(bytes),
            onLost: line => this.lost = line,
            onBack: () => {
                this.lost = "";
                player.begin();
            },
            onProblem: error => {
                this.lost = "";
                player.onProblem(error);
            },
            onEnd: () => {
                this.lost = "";
                if (player === this.player)
                    of("note").textContent = "the server has ended the stream";
                try {
                    player.end();
                } catch (error) {
                    player.onProblem(error);
                }
            },
        });
    }

    fail(error) {
        of("loading").hidden = true;
        if (!(error instanceof StreamError))
            console.error(error);
        of("problem").textContent = error.message ?? `${error}`;
    }

    /// What a key or a button cannot do says nothing of the stream.
    refuse(error) {
        if (!(error instanceof StreamError) && !(error instanceof DOMException))
            console.error(error);
        of("note").textContent = error.message;
    }

    // What is seen.

    get around() {
        const frame = this.player?.shown ?? this.shownFrame.frame;
        if (frame)
            this.followed.show(frame);
        return this.followed?.around;
    }

    /// A head that only turns leaves the server its own path: a sphere has all directions, but for what is beyond a
    /// window.
    lead(hasMoved, head, views) {
        const {frame} = this.shownFrame;
        const steers = hasMoved || this.followed.isFollowed;
        if (!this.live || !(steers || frame.window) || !this.live.sendHead(frame.info.time, head, views, steers))
            return;
        if (steers)
            this.followed.sent(head);
        else
            this.followed.looked(head);
    }

    viewed() {
        const ratio = Math.min(devicePixelRatio, 2);
        const width = Math.max(16, Math.round(this.canvas.clientWidth * ratio));
        const height = Math.max(16, Math.round(this.canvas.clientHeight * ratio));
        if (this.canvas.width !== width || this.canvas.height !== height)
            Object.assign(this.canvas, {width, height});
        const each = layouts[this.layout] === "side by side" ? Math.floor(width / 2) : width;
        const view = viewOf(each, height, Math.min(defaultFov, 2 * Math.atan(each / height)));
        this.head.turnPerPixel = ratio / view.focal;
        return view;
    }

    refreshAgain() {
        cancelAnimationFrame(this.nextRefresh);
        this.nextRefresh = requestAnimationFrame(time => this.refresh(time));
    }

    refresh(time) {
        if (this.headset.session)
            return;
        this.refreshAgain();
        if (this.isExact || !this.player)
            return;
        const view = this.viewed();
        const seconds = this.goOn(time);
        const head = this.headOf(seconds);
        if (!head)
            return;
        const ipd = this.player.shown?.info.ipd ?? this.shownFrame.frame.info.ipd;
        const sides = this.layout === 0 ? [0] : [-1, 1];
        const eyes = sides.map(side => eyeOf(head, side, ipd));
        this.want(view, eyes);
        if (!this.shownFrame.frame)
            return;
        this.lead(this.head.offset.some(metres => metres !== 0), head, [view]);
        this.fading = headBoxFading(eyes, this.shownFrame.frame.info);
        // What has not changed stays on the screen.
        const seen = JSON.stringify([this.shownFrame.changes, this.canvas.width, view, eyes, this.layout]);
        if (seen === this.seen)
            return;
        this.seen = seen;
        this.present(eyes.map((eye, i) => this.renderer.drawEye(view, eye, i, eyes.length)));
    }

    present(pictures) {
        const {width, height} = this.canvas, half = Math.floor(width / 2);
        const [left, right = left] = pictures;
        if (layouts[this.layout] !== "side by side")
            this.renderer.show(null, {left: 0, bottom: 0, width, height}, left, right, this.layout === 2, this.fading);
        else
            [left, right].forEach((eye, i) => this.renderer.show(
                null, {left: i * half, bottom: 0, width: i ? width - half : half, height}, eye, eye, false,
                this.fading));
        this.hasPicture();
    }

    hasPicture() {
        this.times.firstPicture ??= performance.now();
        of("loading").hidden = true;
    }

    /// To the time of this refresh; seconds since the one before.
    goOn(time) {
        const seconds = Math.min((time - (this.refreshes.at(-1) ?? time)) / 1000, 0.25);
        this.refreshes.push(time);
        if (this.refreshes.length > 60)
            this.refreshes.shift();
        this.player.advance(seconds);
        this.tell();
        return seconds;
    }

    headOf(seconds) {
        const {around} = this, frame = this.player.shown ?? this.shownFrame.frame;
        if (!around || !frame)  // after a jump there may be none yet
            return null;
        this.head.steer(seconds, frame.info.lean);
        return this.head.pose(around);
    }

    want(view, eyes) {
        this.shownFrame.want(this.player.shown, view, eyes);
        this.player.forgetLeft(this.shownFrame.kept);
    }

    drawHeadset(time, eyes, head, framebuffer) {
        if (!this.player)
            return;
        this.goOn(time);
        const {around} = this;
        if (!around)
            return;
        const poses = eyes.map(({local}) => composed(around, local));
        this.want(eyes[0].view, poses);
        if (!this.shownFrame.frame)
            return;
        this.lead(Math.hypot(...head.position) > stillMetres, composed(around, head), eyes.map(eye => eye.view));
        this.fading = headBoxFading(poses, this.shownFrame.frame.info);
        eyes.forEach(({view, place}, i) => {
            const picture = this.renderer.drawEye(view, poses[i], i, eyes.length);
            this.renderer.show(framebuffer, place, picture, picture, false, this.fading);
        });
        this.hasPicture();
    }

    tell() {
        const {player, refreshes} = this, {frame} = this.shownFrame;
        const span = refreshes.at(-1) - refreshes[0];
        const parts = [`${span > 0 ? Math.round(1000 * (refreshes.length - 1) / span) : 0} fps`];
        if (frame) {
            const {width, height} = frame.info.camera;
            const dense = frame.window?.info.camera;
            const seen = dense ? ` + window ${dense.width}x${dense.height}` : "";
            parts.push(`${width}x${height}${seen}${frame.main.distances ? "" : ", no depth"}`);
        }
        const seconds = player.isLive ? (performance.now() - this.times.opened) / 1000 : player.length;
        parts.push(`${seconds > 0 ? (8e-6 * player.bytes / seconds).toFixed(1) : 0} Mbit/s`,
                   `${player.lateFrames} late`);
        of("figures").textContent = parts.join("  ");
        const outside = this.fading > 0 && `outside the head box of ${Math.round(100 * frame.info.boxRadius)} cm: ` +
            "parallax is beyond its error bound (c: back)";
        of("state").textContent = this.lost || outside || "";
        of("line").hidden = player.isLive;
        of("time").max = player.length;
        if (!this.isSought)
            of("time").value = player.time;
        of("pause").textContent = player.plays ? "❚❚" : "▶";
    }

    // For programs that drive the page.

    /// What this eye pose sees of a frame: RGBA, row by row from the top. Other drawing stops. `view` has its own focal
    /// length and middle (eye.js).
    async look({frame, width, height, eye, view = viewOf(width, height, defaultFov)}) {
        this.isExact = true;
        while (this.shownFrame.isMaking)
            await new Promise(resolve => setTimeout(resolve, 5));
        const shown = await this.player.frame(frame);
        await this.shownFrame.show(shown, view, [eye], true);
        this.player.forgetLeft(this.shownFrame.kept);
        this.renderer.drawEye(view, eye, 0, 1);
        return this.renderer.read(0);
    }
}

/// A stream that a page may name: on the host it came from.
function relative(url) {
    const target = new URL(url, location.href);
    if (target.origin !== location.origin)
        throw new StreamError(`?src=${url}: expected a file beside this page, found another host`);
    return target.href;
}

/// The server's secret, which stands behind # in its address: that is the part which browsers send nowhere.
function keyOfAddress() {
    return location.hash.length > 1 ? "?key=" + encodeURIComponent(decodeURIComponent(location.hash.slice(1))) : "";
}

function start() {
    try {
        if (!globalThis.VideoDecoder)
            throw new StreamError("this page needs WebCodecs, which browsers have only on https:// and localhost: use serve --web https://");
        const page = new Page();
        globalThis.equistream = page;
        if (words.has("src"))
            page.openUrl(relative(words.get("src")));
        else if (words.has("live"))
            page.openLive(relative(words.get("live")).replace(/^http/, "ws"), keyOfAddress());
    } catch (error) {
        of("loading").hidden = true;
        of("problem").textContent = error.message;
        if (!(error instanceof StreamError))
            console.error(error);
    }
}

start();
