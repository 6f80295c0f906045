"""render --accumulate: less noise along a walk, the true mean of a still head, orders with changing samples, and what is said.

usage: accumulate_test.py BIN_DIR
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import OpenEXR

BIN = pathlib.Path(sys.argv.pop(1))
SIZE = ["--size", "192x96", "--progress", "none"]
STILL = [0, 1.6, 3.15]


def run(*words):
    return subprocess.run([BIN / "equistream", *map(str, words)], capture_output=True, text=True, timeout=300)


def planes_of(file):
    with OpenEXR.File(str(file), separate_channels=True) as exr:
        return {name: np.asarray(channel.pixels, np.float32) for part in exr.parts for name, channel in part.channels.items()}


def shown(planes):
    return np.clip(np.stack([planes[c] for c in "RGB"], -1), 0, 1) ** (1 / 2.2)


class Accumulate(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="equistream_accumulate_")
        cls.root = pathlib.Path(cls.folder.name)
        made = run("scene", "generate", "pavilion", "--out", cls.root / "scene")
        assert made.returncode == 0, made.stderr
        cls.scene = cls.root / "scene/pavilion.json"
        cls.still_path = cls.root / "still.csv"
        cls.still_path.write_text("time_s,x_m,y_m,z_m,qw,qx,qy,qz\n" + "".join(f"{t},{STILL[0]},{STILL[1]},{STILL[2]},1,0,0,0\n" for t in (0, 9)))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def render(self, name, *words):
        ended = run("render", self.scene, *SIZE, *words, "--out", self.root / name)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return self.root / name / "centre", ended.stderr

    def test_a_walk(self):
        """Through leaves and rails a few pixels wide. Remembering more takes more noise away, and errs more: 6.1 dB and 2.0 dB with twice as many frames at edges."""
        def last(name, *words):
            return [shown(planes_of(self.render(f"{name}-{seed}", "--aovs", "none", "--seed", seed, *words)[0] / "frame.0015.exr")) for seed in (1, 2)]

        def noise(pair):
            return np.mean((pair[0] - pair[1]) ** 2) / 2

        walk = ["--frames", "0-15", "--spp", "4"]
        truth = last("truth-walk", "--frames", "15", "--spp", "128")
        single, kept = last("single", *walk), last("kept", *walk, "--accumulate", "32")
        errors = [np.mean([np.mean((seen - truth[0]) ** 2) for seen in pair]) - noise(truth) for pair in (single, kept)]
        self.assertGreater(10 * np.log10(noise(single) / noise(kept)), 5.7)
        self.assertGreater(10 * np.log10(errors[0] / errors[1]), 2.25)

    def test_a_still_head(self):
        words = ["--path", self.still_path, "--aovs", "samples,variance"]
        kept, _ = self.render("still", *words, "--frames", "0-15", "--spp", "4", "--accumulate", "2")
        planes = planes_of(kept / "frame.0015.exr")
        ball = planes["samples"] < 30  # what moves by itself, and what comes out behind it
        self.assertLess(np.mean(ball), 0.1)
        self.assertAlmostEqual(np.mean(planes["samples"][~ball]) / 64, 1, delta=0.15)
        truths = [shown(planes_of(self.render(f"truth-{seed}", *words[:2], "--aovs", "none", "--frames", "15", "--spp", "64", "--seed", seed)[0] / "frame.0015.exr")) for seed in (5, 6)]
        off = np.mean((shown(planes) - truths[0])[~ball] ** 2) / np.mean((truths[1] - truths[0])[~ball] ** 2)
        self.assertLess(10 * np.log10(off), 0.6)

    def ordered(self, out, orders, *words):
        """The answers."""
        words = ["render", self.scene, *SIZE, "--follow", "--accumulate", "32", *words, "--out", self.root / out]
        with subprocess.Popen([BIN / "equistream", *map(str, words)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as renderer:
            renderer.stdout.readline()
            answers = []
            for order in orders:
                renderer.stdin.write(json.dumps(order) + "\n")
                renderer.stdin.flush()
                answers.append(json.loads(renderer.stdout.readline()))
            renderer.stdin.close()
        return answers

    def test_orders_of_a_window(self):
        pose = {"position_m": list(STILL), "orientation_wxyz": [1, 0, 0, 0]}
        orders = [{"frame": frame, "spp": spp, "base_spp": base_spp, **pose} for frame, spp, base_spp in ((0, 2, 1), (1, 4, 1), (2, 4, 2))]
        answers = self.ordered("window", orders, "--window", "gaze,90x60", "--aovs", "samples")
        for answer, spp, expected in zip(answers, (2, 4, 4), (1, 2, 4)):
            self.assertIn(f"spp-{spp}/window/", answer["window"])
            self.assertNotIn("samples", planes_of(answer["window"]))
            self.assertAlmostEqual(float(np.median(planes_of(answer["file"])["samples"])), expected, delta=0.25 * expected)

    def test_orders_of_a_window_of_fewer_pixels(self):
        pose = {"position_m": list(STILL), "orientation_wxyz": [1, 0, 0, 0]}
        orders = [{"frame": frame, "spp": 1, "window_halvings": halvings, **pose} for frame, halvings in enumerate((0, 2, 1, 0))]
        answers = self.ordered("halved", orders, "--window", "gaze,90x60", "--aovs", "depth")
        whole, quartered, halved, again = (planes_of(answer["window"])["depth.Z"] for answer in answers)
        self.assertEqual(quartered.shape, tuple(side // 2 for side in whole.shape))
        self.assertEqual(again.shape, whole.shape)
        self.assertAlmostEqual(halved.size / whole.size, 0.5, delta=0.08)  # of whole blocks
        pairs = whole.reshape(quartered.shape[0], 2, quartered.shape[1], 2)

        def share_off(shift):
            """Of distances that none of the four finer pixels around has."""
            seen = np.roll(quartered, shift, (0, 1))
            return np.mean((seen < pairs.min((1, 3)) * 0.99) | (seen > pairs.max((1, 3)) * 1.01))

        for shift in ((0, 1), (1, 0), (0, -1), (-1, 0)):  # the same directions: a pixel beside is off more often
            self.assertLess(share_off((0, 0)), 0.25 * share_off(shift))

    def test_orders(self):
        orders = [{"frame": frame, "spp": spp, "position_m": [x, *STILL[1:]], "orientation_wxyz": [1, 0, 0, 0]} for frame, spp, x in ((0, 2, 0), (3, 4, 0), (4, 1, 0), (8, 2, 0.05))]
        files = [answer["file"] for answer in self.ordered("follow", orders, "--aovs", "motion,samples")]
        samples, motion = zip(*((planes["samples"], np.hypot(planes["backward.u"], planes["backward.v"])) for planes in map(planes_of, files)))
        for index, expected in enumerate((2, 6, 7, 9)):
            self.assertAlmostEqual(float(np.median(samples[index])), expected, delta=0.25 * expected, msg=index)
        self.assertLess(np.median(motion[2]), 0.01)
        self.assertGreater(np.median(motion[3]), 0.1)

    def test_resumed_as_if_never_interrupted_and_never_mixed(self):
        out, _ = self.render("resumed", "--frames", "0-3", "--spp", "2", "--accumulate", "8", "--aovs", "samples")
        whole = (out / "frame.0003.exr").read_bytes()
        (out / "frame.0003.exr").unlink()
        _, said = self.render("resumed", "--frames", "0-3", "--spp", "2", "--accumulate", "8", "--aovs", "samples")
        self.assertIn("--accumulate renders 3 finished frames again", said)
        _, said = self.render("later", "--frames", "2-3", "--spp", "2", "--accumulate", "8")
        self.assertIn("--accumulate begins anew at frame 2; frames before it are not read", said)
        refused = run("render", self.scene, *SIZE, "--frames", "0-3", "--spp", "2", "--accumulate", "8", "--out", self.root / "later")
        self.assertEqual(refused.returncode, 2, refused.stderr)
        self.assertEqual((out / "frame.0003.exr").read_bytes(), whole)
        for words, said in ((["--accumulate", "9"], "accumulate"), ([], "accumulate")):
            ended = run("render", self.scene, *SIZE, "--frames", "0-3", "--spp", "2", "--aovs", "samples" if words else "none", *words, "--out", self.root / "resumed")
            self.assertEqual(ended.returncode, 2)
            self.assertIn(said, ended.stderr)

    def test_resumed_beside_another_stream_that_is_kept(self):
        words = ["--frames", "0-3", "--spp", "2", "--accumulate", "8", "--aovs", "depth,samples", "--layers"]
        out, _ = self.render("several", *words)
        whole = (out / "frame.0003.exr").read_bytes()
        (out / "frame.0003.exr").unlink()
        self.render("several", *words)
        self.assertEqual((out / "frame.0003.exr").read_bytes(), whole)

    def test_other_streams_stay_as_they_are(self):
        out, said = self.render("layers", "--frames", "0-1", "--spp", "1", "--accumulate", "8", "--aovs", "depth", "--layers")
        self.assertIn("--accumulate averages the first surfaces only; --layers is not averaged", said)
        plain, _ = self.render("plain", "--frames", "0-1", "--spp", "1", "--aovs", "depth", "--layers")
        self.assertEqual(json.loads((out / "manifest.json").read_text())["accumulated_frames"], 8)
        self.assertEqual(sorted(planes_of(out / "frame.0001.exr")), sorted(planes_of(plain / "frame.0001.exr")))
        first, second = (planes_of(folder.parent / "hidden/frame.0001.exr") for folder in (out, plain))
        for name in first:
            np.testing.assert_array_equal(first[name], second[name], name)

    @unittest.skipUnless((BIN / "equistream-render-mitsuba").exists(), "built without Mitsuba")
    def test_mitsuba(self):
        ended = run("render", self.scene, "--host", "mitsuba", *SIZE, "--path", self.still_path, "--frames", "0-3", "--spp", "2", "--accumulate", "8", "--aovs", "samples", "--out", self.root / "mitsuba")
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertAlmostEqual(float(np.median(planes_of(self.root / "mitsuba/centre/frame.0003.exr")["samples"])), 8, delta=0.1)


if __name__ == "__main__":
    unittest.main()
