// Where the viewer's head is, relative to the head that a frame was made for: turned and moved by mouse, fingers, keys
// and the device's own turning. Axes and keys as in client/view/head_motion.h; but the head begins at once, and stays in
// its box.
import {aboutAxis, composed, conjugate, headingOf, multiply, normalized, rotate} from "./poses.js";

const turnPerSecond = 1, metresPerSecond = 0.15, firstTurnWithinMs = 2000;
const halfTurn = Math.PI;
/// Keys that act for as long as they are down: what they push.
const held = {
    ArrowLeft: ["yaw", 1], ArrowRight: ["yaw", -1], ArrowUp: ["pitch", 1], ArrowDown: ["pitch", -1],
    d: ["x", 1], a: ["x", -1], e: ["y", 1], q: ["y", -1], s: ["z", 1], w: ["z", -1],
};

/// The screen's turn in the world, of a device held so (W3C DeviceOrientation: angles in degrees about z, x and y).
function deviceOrientation({alpha, beta, gamma}, screenAngle) {
    const rad = degrees => degrees * Math.PI / 180;
    const turned = multiply(multiply(aboutAxis([0, 0, 1], rad(alpha)), aboutAxis([1, 0, 0], rad(beta))),
                            aboutAxis([0, 1, 0], rad(gamma)));
    // Its world has z up, ours y; its screen lies along x and y.
    const up = aboutAxis([1, 0, 0], -Math.PI / 2);
    return multiply(multiply(up, turned), aboutAxis([0, 0, 1], -rad(screenAngle)));
}

export class Head {
    constructor(element) {
        this.down = new Set();
        this.centre();
        this.device = null;   // its turn, while it is followed
        this.turned = null;   // what hears of it
        this.dragged = null;  // the pointer that turns
        this.turnPerPixel = 0;  // radians, of what is dragged in the middle of the view
        element.addEventListener("pointerdown", event => {
            if (event.button !== 0 || this.dragged !== null)
                return;
            element.setPointerCapture(event.pointerId);
            this.dragged = event.pointerId;
            this.draggedTo = [event.clientX, event.clientY];
        });
        element.addEventListener("pointermove", event => {
            if (this.dragged !== event.pointerId)
                return;
            if (!event.buttons) {  // it was let go where nobody heard
                this.dragged = null;
                return;
            }
            const [x, y] = this.draggedTo;
            this.draggedTo = [event.clientX, event.clientY];
            this.yaw += this.turnPerPixel * (event.clientX - x);
            this.tilt(this.turnPerPixel * (event.clientY - y));
        });
        for (const end of ["pointerup", "pointercancel"])
            element.addEventListener(end, event => {
                if (event.pointerId === this.dragged)
                    this.dragged = null;
            });
        addEventListener("blur", () => this.down.clear());
    }

    centre() {
        this.yaw = this.pitch = 0;
        this.offset = [0, 0, 0];
        this.deviceCentre = null;
    }

    tilt(angle) {
        this.pitch = Math.min(Math.max(this.pitch + angle, -halfTurn / 2), halfTurn / 2);
    }

    /// Whether the key is one that is held.
    key(name, isDown) {
        if (!(name in held))
            return false;
        if (isDown)
            this.down.add(name);
        else
            this.down.delete(name);
        return true;
    }

    ignoreDevice() {
        removeEventListener("deviceorientation", this.turned);
        this.turned = this.device = this.deviceCentre = null;
    }

    /// Begins, or ends. Some browsers ask the person first, and only after a touch. False: the browser refused, or no
    /// reading came in time.
    async followDevice() {
        if (this.turned) {
            this.ignoreDevice();
            return true;
        }
        if (globalThis.DeviceOrientationEvent?.requestPermission)
            if (await DeviceOrientationEvent.requestPermission().catch(() => "no") !== "granted")
                return false;
        if (this.turned)  // asked for twice
            return true;
        this.turned = event => {
            if (event.alpha === null || event.beta === null || event.gamma === null)
                return;
            this.device = deviceOrientation(event, screen.orientation?.angle ?? 0);
        };
        const {turned} = this;
        addEventListener("deviceorientation", turned);
        await new Promise(resolve => setTimeout(resolve, firstTurnWithinMs));
        if (this.device !== null || this.turned !== turned)
            return true;
        this.ignoreDevice();
        return false;
    }

    /// Goes on for so many seconds; stays within `lean` metres.
    steer(seconds, lean) {
        const push = {yaw: 0, pitch: 0, x: 0, y: 0, z: 0};
        for (const name of this.down)
            push[held[name][0]] += held[name][1];
        this.yaw += seconds * turnPerSecond * push.yaw;
        this.tilt(seconds * turnPerSecond * push.pitch);
        const moved = rotate(aboutAxis([0, 1, 0], this.yaw), [push.x, push.y, push.z]);
        this.offset = this.offset.map((metres, i) => metres + seconds * metresPerSecond * moved[i]);
        const away = Math.hypot(...this.offset);
        if (away > lean)
            this.offset = this.offset.map(metres => metres * lean / away);
    }

    /// In the world, for a frame whose head is `around`. What tilts it goes between the device's heading and the rest of
    /// its turn: up and down stay so wherever the device points.
    pose(around) {
        let heading = [1, 0, 0, 0], rest = heading;
        if (this.device) {
            // Where it was turned to at first is straight ahead.
            const turned = headingOf(this.device);
            this.deviceCentre ??= conjugate(turned);
            heading = multiply(this.deviceCentre, turned);
            rest = multiply(conjugate(turned), this.device);
        }
        const level = multiply(aboutAxis([0, 1, 0], this.yaw), heading);
        const orientation = multiply(multiply(level, aboutAxis([1, 0, 0], this.pitch)), rest);
        return composed(around, {position: this.offset, orientation: normalized(orientation)});
    }
}
