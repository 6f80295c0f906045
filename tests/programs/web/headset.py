"""The page in a headset that a script moves."""

import json

import numpy as np

from page import IPD, PROGRAMS, Web, keep, multiplied, rotated, share_alike, turned

# A headset that does what a script says: globalThis.headset has its head and where its eyes are.
FAKE_HEADSET = """
globalThis.headset = {position: [0, 1.6, 0], orientation: [1, 0, 0, 0], ended: false};
const transform = ({position, orientation}) => ({
    position: {x: position[0], y: position[1], z: position[2]},
    orientation: {w: orientation[0], x: orientation[1], y: orientation[2], z: orientation[3]},
});
class FakeSession extends EventTarget {
    renderState = {};
    updateRenderState(state) { Object.assign(this.renderState, state); }
    async requestReferenceSpace() { return {}; }
    requestAnimationFrame(act) {
        setTimeout(() => act(performance.now(), {getViewerPose: () => {
            const {position, orientation} = headset;
            const views = (headset.eyes ?? [position, position]).map((eye, i) => ({
                eye: ["left", "right"][i], transform: transform({position: eye, orientation}),
                // Wider to the outside than to the inside, and higher than low, as headsets have it.
                projectionMatrix: [1, 0, 0, 0, 0, 16 / 9, 0, 0, (i ? 1 : -1) * 0.1, 0.05, -1, -1, 0, 0, -0.02, 0],
            }));
            return {transform: transform(headset), views};
        }}), 10);
    }
}
globalThis.XRWebGLLayer = class {
    framebuffer = null;
    constructor(session, gl) { this.canvas = gl.canvas; }
    getViewport({eye}) {
        const width = this.canvas.width / 2;
        return {x: eye === "left" ? 0 : width, y: 0, width, height: this.canvas.height};
    }
};
WebGL2RenderingContext.prototype.makeXRCompatible = async () => {};
Object.defineProperty(navigator, "xr", {value: {
    isSessionSupported: async mode => mode === "immersive-vr",
    requestSession: async () => new FakeSession(),
}});
"""


class Headset(Web):
    """By WebXR both eyes see what they should: from where the head is, relative to where it began."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.browser.before_pages(FAKE_HEADSET)

    def begin(self):
        """In the first frame, with 320x180 pixels an eye. What the stream says of that frame."""
        file = self.pece420()
        self.open_stream(file)
        self.browser.evaluate("equistream.player.plays = false; equistream.player.seek(0)")
        self.browser.wait_for("equistream.player.shown?.index === 0 && equistream.shownFrame.frame === equistream.player.shown && !document.getElementById('headset').hidden")
        self.browser.evaluate("document.getElementById('headset').click()")
        self.browser.wait_for("equistream.headset.centre")
        self.browser.evaluate("Object.assign(equistream.canvas, {width: 640, height: 180})")
        return json.loads(PROGRAMS.run("info", file, "--json"))["tracks"][0]["first_frame"]

    def test_both_eyes(self):
        around = self.begin()["head"]
        turn = turned(25, 10)
        eyes = [np.array([0.02, 0.03, -0.04]) + rotated(turn, (side * IPD / 2, 0, 0)) for side in (-1, 1)]
        self.browser.evaluate("Object.assign(headset, %s)" % json.dumps({
            "position": [0.02, 1.63, -0.04], "orientation": list(turn),
            "eyes": [list(eye + (0, 1.6, 0)) for eye in eyes]}))
        seen = self.settled()
        place, facing = np.array(around["position_m"]), np.array(around["orientation_wxyz"])
        self.browser.evaluate("equistream.headset.session = null")
        for i, eye in enumerate(eyes):
            view = {"width": 320, "height": 180, "focal": 160, "middle": [[176, 144][i], 94.5]}
            expected = self.look(0, place + rotated(facing, eye), multiplied(facing, turn), (320, 180), view)
            share = share_alike(seen[:, 320 * i:320 * (i + 1)], expected)
            if share < 0.99:
                keep(f"headset.{i}", seen=seen, expected=expected)
            self.assertGreaterEqual(share, 0.99)
        self.assertLess(share_alike(seen[:, :320], seen[:, 320:]), 0.9)

    def test_beyond_the_head_box_the_picture_fades_to_grey(self):
        """As in `view`: from the box's edge on, over half its radius and at least 25 cm."""
        first = self.begin()
        box = first["lean_m"] + first["ipd_m"] / 2
        for beyond, fading in ((-0.01, 0), (0.1, 0.4), (1, 1)):
            self.browser.evaluate(f"headset.position = [0, 1.6 + {box + beyond}, 0]")
            seen = self.settled()
            eyes = [self.pixels(f"equistream.renderer.read({i})", (320, 180)) for i in (0, 1)]
            expected = faded(np.concatenate(eyes, axis=1), fading)
            self.assertLessEqual(np.abs(seen - expected).max(), 0 if fading == 0 else 1)
            said = f"outside the head box of {100 * box:.0f} cm: parallax is beyond its error bound (c: back)"
            self.assertEqual(self.said("state"), said if fading else "")
        self.assertLess(np.ptp(seen), 0.5 * np.ptp(eyes))
        self.browser.evaluate("dispatchEvent(new KeyboardEvent('keydown', {key: 'c'}))")
        self.browser.wait_for("document.getElementById('state').textContent === ''")


def faded(rgb, fading):
    """So far to grey, of which more than half is the middle one."""
    grey = 0.4 * (rgb @ (0.2126, 0.7152, 0.0722)) + 0.6 * 127.5
    return (1 - fading) * rgb + fading * grey[..., np.newaxis]
