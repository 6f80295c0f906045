"""What needs renders. A sphere filtered from one twice as wide is the sphere that is rendered as narrow with all its samples, but for textures, which are
filtered to the width of the pixels that are rendered; and parts of a render that jobs of a farm made are one sequence afterwards, of which nothing is rendered
again.

usage: rendered_test.py BIN_DIR [CLASS]

Filtered spheres: two seeds, so that noise cancels: the mean of the products of both seeds' differences is that of the squared true difference, which is 0
where the filters are the same. Moving the filtered one by half a column of the wide one is what another filter would look like.
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import equistream as es
import numpy as np
import render_list
from narrowed import narrowed
from presets import PRESETS
from scene_work import SceneWork

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
SIZE, TIMES, SAMPLES = (192, 96), 2, 64
SEEDS = (1, 2)


def take_textures_out(glb):
    """Of all materials, whose factors stay."""
    data = glb.read_bytes()
    length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20:20 + length])
    for material in document["materials"]:
        for part in (material, material.get("pbrMetallicRoughness", {})):
            for name in [name for name in part if name.endswith("Texture")]:
                del part[name]
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = data[20 + length:]
    glb.write_bytes(data[:8] + (20 + len(text) + len(rest)).to_bytes(4, "little") + len(text).to_bytes(4, "little") + b"JSON" + text + rest)


class BesideRendered(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_narrowed_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.run_program("scene", "generate", "pavilion", "--out", cls.root / "textured")
        shutil.copytree(cls.root / "textured", cls.root / "plain")
        take_textures_out(cls.root / "plain/pavilion.glb")
        wide = tuple(TIMES * side for side in SIZE)
        # Other seeds, so that the narrow spheres share no noise with the wide ones.
        cls.narrow, cls.wide = ({scene: [cls.render(scene, size, samples, seed + more) for seed in SEEDS] for scene in ("plain", "textured")}
                                for size, samples, more in ((SIZE, SAMPLES, 10), (wide, SAMPLES // TIMES ** 2, 0)))

    @classmethod
    def run_program(cls, *words):
        subprocess.run([str(word) for word in (BIN / "equistream", *words)], check=True, capture_output=True)

    @classmethod
    def render(cls, scene, size, samples, seed):
        out = cls.root / f"{scene}-{size[0]}-{seed}"
        cls.run_program("render", cls.root / scene / "pavilion.json", "--frames", "30", "--eye", "centre", "--size", f"{size[0]}x{size[1]}", "--spp", samples,
                        "--seed", seed, "--aovs", "none", "--progress", "none", "--out", out)
        return next(iter(es.Sequence(out / "centre", "colour")))["colour"].astype(np.float64)

    def products(self, scene, shift=0):
        """Of both seeds' differences. Suns and lamps, whose noise is unbounded, are clipped."""
        filtered = [narrowed(np.roll(wide, shift, axis=1), SIZE) for wide in self.wide[scene]]
        return np.prod([np.minimum(one, 1) - np.minimum(other, 1) for one, other in zip(filtered, self.narrow[scene])], axis=0)

    def standard_errors(self, products):
        """How many of them the mean is above 0."""
        return products.mean() / (products.std() / np.sqrt(products.size))

    def test_they_are_the_same(self):
        self.assertLess(abs(self.standard_errors(self.products("plain"))), 4)

    def test_another_filter_would_show(self):
        self.assertGreater(self.standard_errors(self.products("plain", shift=1)), 8)

    def test_textures_are_a_little_finer(self):
        """The study takes filtered spheres for rendered ones. What that leaves out of its errors, without noise, is at least 45 dB below white."""
        self.assertLess(self.products("textured").mean(), 10 ** -4.5)
        self.assertGreater(self.products("textured", shift=1).mean(), 10 ** -4.5)


PRESET = PRESETS["smoke"]


class Parts(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_parts_"))
        self.addCleanup(shutil.rmtree, self.root, ignore_errors=True)

    def work(self, name):
        return SceneWork(self.root / name, BIN, "pavilion", PRESET)

    def test_each_frame_is_rendered_once(self):
        spec = render_list.perspective(PRESET, 1)
        in_parts, at_once = self.work("parts"), self.work("whole")
        for index in (in_parts.last, in_parts.first):
            in_parts.render_part(spec, index, index)
        folders = [work.folder / work.render(spec) for work in (in_parts, at_once)]
        self.assertEqual([work.render_record(f"render-{spec.name}")["frames_rendered"] for work in (in_parts, at_once)], [0, 2 * PRESET.frames])  # each with a small one
        self.assertEqual(sum(record["paths"] for record in in_parts.render_records()), at_once.render_record(f"render-{spec.name}")["paths"])
        for eye in ("left", "small"):
            for one, other in zip(*(es.Sequence(folder / eye) for folder in folders), strict=True):
                self.assertEqual(one.info.camera_pose, other.info.camera_pose)
                self.assertTrue((one["colour"] == other["colour"]).all())

    def test_half_of_a_record_counts_for_nothing(self):
        spec, work = render_list.perspective(PRESET, 1), self.work("cut")
        work.render_part(spec, work.first, work.first)
        work.expect_scene()
        before = work.render_records(), work.measuring_cpu_s()
        self.assertEqual(len(before[0]), 1)
        steps = work.folder / "steps"
        for name in ("part-x-0-1.json", "render-x.json", "play-x.json"):
            (steps / name).write_text("")
        record = json.loads((steps / f"{before[0][0]['name']}.json").read_text())
        (steps / "render-y.json").write_text(json.dumps(record))
        (steps / "render-y.out").write_text("")
        self.assertEqual((work.render_records(), work.measuring_cpu_s()), before)

    def test_steps_are_of_the_scene_with_all_that_its_model_names(self):
        fingerprints = ["a", "b", "b"]
        with unittest.mock.patch("scene_work.fingerprint_of", lambda program, description: fingerprints.pop(0)):
            for expected in ("a", "b", "b"):
                work = self.work("changed")
                work.expect_scene()
                self.assertEqual(json.loads((work.folder / "steps/scene-info.json").read_text())["context"]["scene"], expected)
                self.assertEqual(work.steps.progress.done, {"a": 2, "b": 1}[expected] if fingerprints else 0)


if __name__ == "__main__":
    unittest.main()
