// A stream's bytes as pictures' packets by track, each with what it says of itself.
import {StreamError, expectedFound} from "./bytes.js";
import {describeAvc, readPicture} from "./frame_data.js";
import {MatroskaReader} from "./matroska.js";
import {Mp4Reader} from "./mp4.js";

/// Tracks that the page uses; it does without the others.
const usedRoles = new Set(["main", "depth", "window", "window-depth"]);
/// Pictures of a track that has not said yet what it is.
const mostHeld = 32;

export class StreamReader {
    /// Calls onPacket({role, track, key, info, bytes, lacksInfo, sets}) for what the page uses. A picture that lacks
    /// info is without readable frame data; its index is a guess. What cannot be shown goes into `leftOut`, a set of roles.
    constructor(name, onPacket, leftOut = new Set()) {
        this.name = name;
        this.onPacket = onPacket;
        this.leftOut = leftOut;
        this.container = null;
        this.begin = new Uint8Array(0);
        this.tracks = new Map();
        this.byRole = new Map();
        this.problems = new Set();  // each is told once
        this.main = {pictures: 0, after: 0, count: 0, last: 0};  // what main's pictures say of their number
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
        this.container?.end();
        const expected = this.otherCodec ? "H.264, which browsers decode (encode --codec h264)"
                                         : "pictures with poses, as `equistream encode` writes";
        if (!this.byRole.has("main"))
            throw expectedFound(this.name, expected, this.otherCodec ?? "none");
    }

    /// Of a recording, which has all pictures that it says.
    requireAll() {
        const {pictures, after, count, last} = this.main;
        if (after < count || count === 0)
            this.problems.add(`${this.name}: main was cut after frame ${last} (${pictures}` +
                              `${count > 0 ? ` of ${count} pictures play` : " play"})`);
        else if (pictures < count)
            this.problems.add(`${this.name}: main lacks ${count - pictures} of ${count} pictures`);
    }

    countMain({ordinal, count, index}) {
        const {main} = this;
        ++main.pictures;
        main.after = Math.max(main.after, ordinal + 1);
        main.count = Math.max(main.count, count);
        main.last = Math.max(main.last, index);
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
            this.problems.add(picture.problem?.message ?? "pictures without frame data (pose and camera) are ignored");
            this.takeWithoutInfo(track, picture.key, bytes);
            return;
        }
        const {role} = picture.info;
        if (!usedRoles.has(role) || this.leftOut.has(role))
            return;
        const first = this.byRole.get(role) ?? track;
        if (first.id !== track.id && role.startsWith("window")) {
            this.problems.add("this page shows no tiles, only the coarser sphere around them (equistream view shows both)");
            this.leftOut.add("window").add("window-depth");
        } else if (first.id !== track.id) {
            this.problems.add(`a second track of ${role} is left out`);
        }
        if (first.id !== track.id)
            return;
        this.byRole.set(role, track);  // a stream that begins again says all its tracks again
        if (role === "main")
            this.countMain(picture.info);
        track.role = role;
        for (const {key, bytes: held} of track.held?.splice(0) ?? [])
            this.takeWithoutInfo(track, key, held);
        track.highest = Math.max(track.highest ?? -1, picture.info.index);
        this.onPacket({role, track, key: picture.key, info: picture.info, bytes,
                       sets: picture.sps && {sps: picture.sps, pps: picture.pps}});
    }

    /// A picture that does not say what it is goes to its track's decoder: between the one before and the next.
    takeWithoutInfo(track, key, bytes) {
        track.held ??= [];
        if (track.role)
            this.onPacket({role: track.role, track, key, info: {index: (track.highest ?? -1) + 0.5}, bytes,
                           lacksInfo: true});
        else if (track.held.length < mostHeld)
            track.held.push({key, bytes});
    }
}
