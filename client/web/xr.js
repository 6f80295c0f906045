// A headset, by WebXR: both eyes' poses are taken relative to where the head was when the session began, and put where
// the stream's head is.
import {conjugate, headingOf, multiply, rotate} from "./poses.js";

const poseOf = ({position: p, orientation: q}) => ({position: [p.x, p.y, p.z], orientation: [q.w, q.x, q.y, q.z]});

/// Square pixels, of which the eye's part of the framebuffer has as many across.
function viewOfProjection(m, width) {
    const left = (m[8] - 1) / m[0], right = (m[8] + 1) / m[0], low = (m[9] - 1) / m[5], high = (m[9] + 1) / m[5];
    const focal = width / (right - left);
    return {width, height: Math.max(1, Math.round(focal * (high - low))), focal, middle: [-left * focal, high * focal]};
}

export class Headset {
    /// draw(time, eyes, head, framebuffer) with eyes [{view, place, local}]; `local` and `head` are poses relative to
    /// where the head began.
    constructor(gl, draw, onEnd) {
        this.gl = gl;
        this.draw = draw;
        this.onEnd = onEnd;
        this.session = null;
    }

    static async isThere() {
        return Boolean(await navigator.xr?.isSessionSupported("immersive-vr").catch(() => false));
    }

    async start() {
        const session = await navigator.xr.requestSession("immersive-vr");
        let hasEnded = false;
        session.addEventListener("end", () => {
            hasEnded = true;
            this.session = null;
            this.onEnd();
        });
        try {
            await this.gl.makeXRCompatible();
            const baseLayer = new XRWebGLLayer(session, this.gl, {antialias: false, depth: false});
            session.updateRenderState({baseLayer});
            this.space = await session.requestReferenceSpace("local");
            this.space.addEventListener?.("reset", () => this.recentre());  // the headset's own recentring
        } catch (error) {
            session.end().catch(() => {});
            throw error;
        }
        if (hasEnded)
            return;
        this.session = session;
        this.centre = null;
        session.requestAnimationFrame((time, frame) => this.refresh(time, frame));
    }

    /// What was ahead and where the head was becomes the stream's.
    recentre() {
        this.centre = null;
    }

    refresh(time, frame) {
        const {session} = this;
        if (!session)
            return;
        session.requestAnimationFrame((next, nextFrame) => this.refresh(next, nextFrame));
        const viewer = frame.getViewerPose(this.space);
        if (!viewer)
            return;
        const head = poseOf(viewer.transform);
        this.centre ??= {position: head.position, orientation: headingOf(head.orientation)};
        const back = conjugate(this.centre.orientation);
        const local = pose => ({
            position: rotate(back, pose.position.map((metres, i) => metres - this.centre.position[i])),
            orientation: multiply(back, pose.orientation),
        });
        const layer = session.renderState.baseLayer;
        const eyes = viewer.views.map(view => {
            const {x, y, width, height} = layer.getViewport(view);
            return {place: {left: x, bottom: y, width, height}, view: viewOfProjection(view.projectionMatrix, width),
                    local: local(poseOf(view.transform))};
        });
        this.draw(time, eyes, local(head), layer.framebuffer);
    }
}
