// A stream's bytes as pictures' packets by track, each with what it says of itself.
import {StreamError, expectedFound} from "./bytes.js";
import {describeAvc, readPicture} from "./frame_data.js";
import {MatroskaReader} from "./matroska.js";
import {Mp4Reader} from "./mp4.js";

/// Tracks that the page uses; it does without the others.
const usedRoles = new Set(["main", "depth", "window", "window-depth"]);

export class StreamReader {
    /// Calls onPacket({role, track, key, info, bytes}) for what the page uses. What cannot be shown goes into
    /// `leftOut`, a set of roles.
    constructor(name, onPacket, leftOut = new Set()) {
        this.name = name;
        this.onPacket = onPacket;
        this.leftOut = leftOut;
        this.container = null;
        this.begin = new Uint8Array(0);
        this.tracks = new Map();
        this.byRole = new Map();
        this.problems = new Set();  // each is told once
    }

    push(bytes) {
        if (!this.container && !this.recognise(bytes))
            return;
        this.container.push(this.begin.length > 0 ? this.begin : bytes);
        this.begin = new Uint8Array(0);
    }

    recognise(bytes) {
        const begin = new Uint8Array(this.begin.length + bytes.length);
        begin.set(this.begin);
        begin.set(bytes, this.begin.length);
        this.begin = begin;
        if (begin.length < 8)
            return false;
        const Container = [MatroskaReader, Mp4Reader].find(each => each.fits(begin));
        if (!Container)
            throw expectedFound(this.name, "a stream that `equistream encode` wrote as .mkv or .mp4", "other bytes");
        this.container = new Container(track => this.addTrack(track), (id, packet) => this.take(id, packet));
        return true;
    }

    addTrack(track) {
        if (track.codec !== "avc1" && track.codec !== "avc3") {
            this.otherCodec = track.codec;
            this.problems.add(`a track of ${track.codec} is left out: browsers decode encode --codec h264, ` +
                              "of depth encode --depth pece420");
            return;
        }
        track.avc = describeAvc(track.description);
        this.tracks.set(track.id, track);
    }

    /// There will be no more bytes.
    end() {
        const expected = this.otherCodec ? "H.264, which browsers decode (encode --codec h264)"
                                         : "pictures with poses, as `equistream encode` writes";
        if (!this.byRole.has("main"))
            throw expectedFound(this.name, expected, this.otherCodec ?? "none");
    }

    take(id, bytes) {
        const track = this.tracks.get(id);
        if (!track)
            return;
        let picture;
        try {
            picture = readPicture(bytes, track.avc.lengthBytes);
        } catch (error) {
            if (!(error instanceof StreamError))
                throw error;
            this.problems.add(error.message);  // a damaged picture is left out
            return;
        }
        if (!picture.info) {
            this.problems.add("pictures without frame data are left out");
            return;
        }
        const {role} = picture.info;
        if (!usedRoles.has(role) || this.leftOut.has(role))
            return;
        const first = this.byRole.get(role) ?? track;
        this.byRole.set(role, track);
        if (first.id !== track.id) {  // a stream that begins again says all its tracks again
            this.problems.add("tiles are not shown by this page: the sphere around them is");
            this.leftOut.add("window").add("window-depth");
            return;
        }
        this.onPacket({role, track, key: picture.key, info: picture.info, bytes});
    }
}
