// A live stream over a WebSocket: bytes come, heads go (docs/stream-format.md, "From the viewer").
import {StreamError} from "./bytes.js";

const mostHeadsPerSecond = 30;
/// A server says something at least once a second (docs/stream-format.md, "Live").
const longestSilence = {first: 30000, later: 10000};

function message(time, {position, orientation}, view, steers) {
    const bytes = new DataView(new ArrayBuffer(steers ? 92 : 100));  // the last number, 0: it only looks
    [..."EQVM"].forEach((letter, i) => bytes.setUint8(i, letter.charCodeAt(0)));
    bytes.setUint16(4, 1, true);
    bytes.setUint16(6, 1, true);
    bytes.setUint32(8, steers ? 80 : 88, true);
    const tangents = [0.5 * view.width / view.focal, 0.5 * view.height / view.focal];
    [time, ...position, ...orientation, ...tangents].forEach((number, i) => bytes.setFloat64(12 + 8 * i, number, true));
    return bytes.buffer;
}

export class LiveSocket {
    constructor(url, key, {onBytes, onProblem, onEnd}) {
        this.socket = new WebSocket(url + key);
        this.socket.binaryType = "arraybuffer";
        this.sent = 0;
        let isOver = false;
        const over = act => {
            if (!isOver)
                act();
            isOver = true;
            clearTimeout(this.watch);
            this.socket.close();
        };
        const wait = milliseconds => {
            clearTimeout(this.watch);
            this.watch = setTimeout(() => over(() => onProblem(new StreamError(
                `${url}: the server has said nothing for ${milliseconds / 1000} s`))), milliseconds);
        };
        wait(longestSilence.first);
        this.socket.onmessage = ({data}) => {
            if (isOver)
                return;
            wait(longestSilence.later);
            try {
                onBytes(new Uint8Array(data));
            } catch (error) {
                over(() => onProblem(error));
            }
        };
        this.socket.onclose = ({code, reason}) => over(() => {
            if (code === 1000)
                onEnd();
            else
                onProblem(new StreamError(`${url}: the server hung up${reason ? ` (${reason})` : ""}`));
        });
    }

    /// Where the head is, in the scene's world; at most so often as servers want to know. Whether it was sent.
    sendHead(time, head, view, steers) {
        const now = performance.now();
        if (this.socket.readyState !== WebSocket.OPEN || now - this.sent < 1000 / mostHeadsPerSecond ||
            this.socket.bufferedAmount > 65536)
            return false;
        this.sent = now;
        this.socket.send(message(time, head, view, steers));
        return true;
    }

    close() {
        this.socket.onclose = this.socket.onmessage = null;
        clearTimeout(this.watch);
        this.socket.close();
    }
}
