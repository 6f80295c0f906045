// A live stream over a WebSocket: bytes come, heads go (docs/stream-format.md, "To browsers", "From the viewer"). A
// connection that is lost is asked for again, as `view` does.
import {StreamError, expectedFound} from "./bytes.js";
import {reachOf} from "./eye.js";

const mostHeadsPerSecond = 30;
/// Milliseconds. A server says something at least once a second (docs/stream-format.md, "Live").
const longestSilence = {first: 30000, later: 10000};
/// Before the first attempt to reach a server again, doubled before each further one: as in frame_loader.cpp.
const firstPause = 250, longestPause = 4000;
/// Codes (RFC 6455, 7.4.1) by which a server says that what it heard was wrong. It would hear the same again.
const faults = new Set([1002, 1003, 1007, 1008, 1009, 1010]);
const closedWithoutAWord = 1006;
/// A server may come between an attempt and the question whether it is there: once is no refusal.
const mostRefusals = 2;

function message(time, {position, orientation}, views, steers) {
    const bytes = new DataView(new ArrayBuffer(steers ? 92 : 100));  // the last number, 0: it only looks
    [..."EQVM"].forEach((letter, i) => bytes.setUint8(i, letter.charCodeAt(0)));
    bytes.setUint16(4, 1, true);
    bytes.setUint16(6, 1, true);
    bytes.setUint32(8, steers ? 80 : 88, true);
    const tangents = reachOf(views);
    [time, ...position, ...orientation, ...tangents].forEach((number, i) => bytes.setFloat64(12 + 8 * i, number, true));
    return bytes.buffer;
}

export class LiveStream {
    /// Calls onBytes(bytes) and at the end onEnd() or onProblem(error). onLost(line) says that it asks again; onBack()
    /// comes before the first bytes of another connection. `key`: what the server wants to know, behind the address.
    constructor(url, key, heard) {
        this.url = url;
        this.key = key;
        this.heard = heard;
        this.sent = 0;      // when a head was, last
        this.attempts = 0;  // to reach a server that was lost
        this.follow().catch(error => this.isClosed || heard.onProblem(error));
    }

    async follow() {
        let before = 0, refusals = 0;  // bytes of the last connection that had any
        for (;;) {
            const {code, why, isOpened, bytes} = await this.connection();
            if (code === 1000)
                return this.heard.onEnd();
            // One that is cut in the same place again was cut when it was recorded.
            const isFinal = faults.has(code) || (bytes > 0 && bytes === before);
            before = bytes || before;
            if (isFinal || before === 0)
                throw new StreamError(`${this.url}: ${why}`);
            refusals = !isOpened && await this.isThere() ? refusals + 1 : 0;
            if (this.isClosed)
                return;
            if (refusals === mostRefusals)
                throw expectedFound(this.url, "a server that accepts this page",
                                    "a refusal (open the address that serve prints now)");
            ++this.attempts;
            this.heard.onLost(`${why}: trying again (${this.attempts})`);
            const pause = Math.min(longestPause, firstPause * 2 ** (this.attempts - 1));
            await new Promise(resolve => this.timer = setTimeout(resolve, pause));
        }
    }

    /// One connection: how it ended. Rejects where what came is no stream.
    connection() {
        return new Promise((resolve, reject) => {
            const socket = this.socket = new WebSocket(this.url + this.key);
            socket.binaryType = "arraybuffer";
            let isOpened = false, bytes = 0;
            const over = (why, code) => {
                this.hangUp();
                resolve({code, why, isOpened, bytes});
            };
            const wait = milliseconds => {
                clearTimeout(this.timer);
                this.timer = setTimeout(over, milliseconds, `the server sent nothing for ${milliseconds / 1000} s`);
            };
            wait(longestSilence.first);
            socket.onopen = () => isOpened = true;
            socket.onmessage = ({data}) => {
                wait(longestSilence.later);
                try {
                    if (this.attempts > 0)
                        this.heard.onBack();
                    this.attempts = 0;
                    bytes += data.byteLength;
                    this.heard.onBytes(new Uint8Array(data));
                } catch (error) {
                    this.hangUp();
                    reject(error);
                }
            };
            socket.onclose = ({code, reason}) => {
                const lost = isOpened ? "the connection was lost" : "no connection to the server";
                over(code === closedWithoutAWord ? lost : `the server closed the connection${reason ? ` (${reason})` : ""}`, code);
            };
        });
    }

    /// Whether a server answers at all: browsers do not say why they got no WebSocket.
    isThere() {
        const asked = {cache: "no-store", signal: AbortSignal.timeout(longestPause)};
        return fetch(this.url.replace(/^ws/, "http"), asked).then(({status}) => status < 500, () => false);
    }

    /// Where the head is, in the scene's world; at most so often as servers want to know. Whether it was sent.
    /// `views`: of the eyes.
    sendHead(time, head, views, steers) {
        const now = performance.now();
        if (this.socket.readyState !== WebSocket.OPEN || now - this.sent < 1000 / mostHeadsPerSecond ||
            this.socket.bufferedAmount > 65536)
            return false;
        this.sent = now;
        this.socket.send(message(time, head, views, steers));
        return true;
    }

    hangUp() {
        clearTimeout(this.timer);
        this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
        this.socket.close();
    }

    close() {
        this.isClosed = true;
        if (this.socket)  // an address may be none
            this.hangUp();
    }
}
