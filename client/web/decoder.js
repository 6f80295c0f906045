// One track's packets into planes of samples, by WebCodecs.
import {StreamError, expectedFound} from "./bytes.js";
import {describeAvc, withParameterSets} from "./frame_data.js";

/// What one sample of a plane takes, and how a picture's planes are laid out.
const layouts = {
    I420: {planes: 3, bits: 8}, NV12: {planes: 2, bits: 8}, I420P10: {planes: 3, bits: 10}, I444: {planes: 3, bits: 8},
    I420A: {planes: 3, bits: 8},
};

/// Samples of chroma that lie side by side, apart.
function apart({data, stride}, width, height) {
    const planes = [new Uint8Array(width * height), new Uint8Array(width * height)];
    for (let y = 0; y < height; ++y)
        for (let x = 0; x < width; ++x)
            for (const i of [0, 1])
                planes[i][y * width + x] = data[y * stride + 2 * x + i];
    return planes.map(plane => ({data: plane, stride: width, bits: 8}));
}

function isSame(bytes, others) {
    return bytes.length === others.length && bytes.every((byte, i) => byte === others[i]);
}

async function copied(frame, name) {
    const layout = layouts[frame.format];
    const {width, height} = frame.visibleRect;
    if (!layout)
        throw expectedFound(`${name}: this browser's decoder`, `samples as ${Object.keys(layouts).join(", ")}`,
                            frame.format ?? "none that a page may read");
    const buffer = new ArrayBuffer(frame.allocationSize());
    const places = await frame.copyTo(buffer);
    const bytesEach = layout.bits > 8 ? 2 : 1;
    const planes = places.slice(0, layout.planes).map(({offset, stride}, i) => {
        const rows = i === 0 || frame.format === "I444" ? height : Math.ceil(height / 2);
        const samples = Math.floor(Math.min(stride * rows, buffer.byteLength - offset) / bytesEach);
        const Samples = bytesEach === 2 ? Uint16Array : Uint8Array;
        const data = new Samples(buffer, offset, samples);
        return {data, stride: stride / bytesEach, bits: layout.bits};
    });
    return {width, height, isHalved: frame.format !== "I444",
            planes: frame.format === "NV12" ? [planes[0], ...apart(planes[1], width >> 1, height >> 1)] : planes};
}

export class TrackDecoder {
    /// Calls onPicture(number, {width, height, planes}) with the numbers that push() was given, in the order they are
    /// shown in, onProblem(error) where its pictures are of no use, and onEnd(error) once it is closed by what it was
    /// given. The error is null where a browser took it away, of a page that is not looked at.
    constructor(name, track, {onPicture, onProblem, onEnd}) {
        this.name = name;
        this.onEnd = onEnd;
        this.config = {codec: track.avc.codec, description: track.description, optimizeForLatency: track.isLive};
        this.turn = Promise.resolve();
        this.decoder = new VideoDecoder({
            output: frame => {
                // Copies end in the order they began in.
                const copy = copied(frame, name).finally(() => frame.close());
                this.turn = this.turn.then(() => copy).then(picture => onPicture(frame.timestamp, picture))
                    .catch(onProblem);
            },
            error: error => onEnd(error.name === "QuotaExceededError" ? null : this.notDecoded(error)),
        });
    }

    notDecoded(error) {
        return new StreamError(`${this.name}: this browser cannot decode it (${error.message})`);
    }

    async open() {
        const config = {...this.config, hardwareAcceleration: "prefer-software"};
        for (const each of [config, this.config])
            if ((await VideoDecoder.isConfigSupported(each)).supported)
                return this.decoder.configure(this.config = each);
        throw expectedFound(this.name, "video that this browser decodes",
                            `${this.config.codec} (encode with --codec h264, and depth with --depth pece420)`);
    }

    get isClosed() {
        return this.decoder.state === "closed";
    }

    /// Packets that have not been decoded.
    get waiting() {
        return this.decoder.decodeQueueSize;
    }

    /// A window's size may change with a key frame. Not all browsers look for parameter sets within packets.
    follow({sps, pps}) {
        if (!(sps.length >= 4 && pps && Math.max(sps.length, pps.length) < 65536))
            return;
        const description = withParameterSets(this.config.description, {sps, pps});
        if (isSame(description, this.config.description))
            return;
        this.config = {...this.config, description, codec: describeAvc(description).codec};
        this.decoder.configure(this.config);
    }

    push(number, key, bytes, sets) {
        if (this.decoder.state !== "configured")
            return;
        try {
            if (key && sets)
                this.follow(sets);
            this.decoder.decode(new EncodedVideoChunk({type: key ? "key" : "delta", timestamp: number, data: bytes}));
        } catch (error) {  // the decoder checks key frames itself, and throws
            this.close();
            this.onEnd(this.notDecoded(error));
        }
    }

    /// All that was pushed comes; the next packet must be a key frame.
    async finish() {
        if (this.decoder.state === "configured")
            await this.decoder.flush().catch(() => {});  // a jump is none's fault
        await this.turn;
    }

    reset() {
        if (this.decoder.state !== "configured")
            return;
        this.decoder.reset();
        this.decoder.configure(this.config);
    }

    close() {
        if (!this.isClosed)
            this.decoder.close();
    }
}
