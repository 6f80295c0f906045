"""`equistream view` of what cannot be shown: one line where it is the first frame, and a viewer that goes on where it is a later one.

usage: unshown_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from display import PATIENCE_S, Display, ViewerProcess, psnr, wait_for  # noqa: E402
from independent import *  # noqa: E402,F403

PROGRAMS = Programs(sys.argv.pop(1))
SIZE = "160x90"


def foreign_config(folder, steps):
    """An OpenColorIO config whose one view is a curve with a matrix after it, so many times."""
    (folder / "curve.spi1d").write_text("Version 1\nFrom 0 1\nLength 3\nComponents 1\n{\n0\n0.6\n1\n}\n")
    step = """        - !<FileTransform> {src: curve.spi1d, interpolation: linear}
        - !<MatrixTransform> {matrix: [0.9, 0.1, 0, 0, 0, 0.9, 0.1, 0, 0.1, 0, 0.9, 0, 0, 0, 0, 1]}
"""
    config = folder / f"steps.{steps}.ocio"
    config.write_text(f"""ocio_profile_version: 2
search_path: {folder}
roles: {{scene_linear: lin, aces_interchange: aces, default: lin}}
displays:
  Wall:
    - !<View> {{name: Steps, colorspace: shown}}
active_displays: [Wall]
active_views: [Steps]
colorspaces:
  - !<ColorSpace> {{name: aces}}
  - !<ColorSpace>
    name: lin
    to_scene_reference: !<MatrixTransform> {{matrix: [0.44, 0.38, 0.18, 0, 0.09, 0.81, 0.10, 0, 0.02, 0.11, 0.87, 0, 0, 0, 0, 1]}}
  - !<ColorSpace>
    name: shown
    from_scene_reference: !<GroupTransform>
      children:
{step * steps}""")
    return config


class Unshown(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_unshown_"))
        cls.scene = PROGRAMS.scene("pavilion", cls.root)
        folder = cls.root / "frames"
        PROGRAMS.run("render", cls.scene, "--frames", "0-2", "--fps", 5, "--size", "256x128", "--spp", 1, "--aovs", "none", "--out", folder)
        cls.streams = {}
        for transfer in ("srgb", "pq"):
            cls.streams[transfer] = cls.root / f"{transfer}.mkv"
            PROGRAMS.run("encode", folder, "--out", cls.streams[transfer], "--transfer", transfer, "--depth", "none", "--preset", "ultrafast", "--progress", "none")
        cls.display = Display()

    @classmethod
    def tearDownClass(cls):
        cls.display.close()
        shutil.rmtree(cls.root, ignore_errors=True)

    def line_of(self, status, *words):
        """What it says before it ends."""
        result = subprocess.run([str(w) for w in [PROGRAMS.folder / "equistream", "view", *words]], env=self.display.environment, capture_output=True, text=True,
                                timeout=PATIENCE_S)
        self.assertEqual((result.returncode, len(result.stderr.splitlines())), (status, 1), result.stderr)
        return result.stderr

    def test_pictures_of_another_size_than_they_are_tagged_with(self):
        scaled = self.root / "scaled.mkv"
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-i", self.streams["srgb"], "-map", "0:v:0", "-vf", "scale=128:64", "-c:v", "libx264", "-udu_sei", "1", scaled],
                       check=True)
        self.assertIn("frame 0, main: expected a picture of 256x128, as it is tagged, found 128x64", self.line_of(1, scaled, "--paused"))

    def test_views_of_more_tables_than_a_driver_takes(self):
        said = self.line_of(2, self.streams["pq"], "--paused", "--ocio", foreign_config(self.root, 400))
        self.assertRegex(said, r"OpenColorIO's view: expected at most \d+ tables, here, found 40\d")
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", self.root, self.streams["pq"], "--paused", "--ocio", foreign_config(self.root, 2))
        self.addCleanup(viewer.close)
        self.assertGreater(viewer.picture().std(), 5)

    def test_spheres_that_are_too_wide_for_a_method_are_turned(self):
        wide, config = self.root / "wide", pathlib.Path(tempfile.mkdtemp(dir=self.root))
        PROGRAMS.run("render", self.scene, "--frames", "0", "--size", "16384x182", "--range", "360,4", "--spp", 1, "--aovs", "depth", "--out", wide)
        seen = []
        for words, kept in ((["--json"], config), (["--method", "rotation"], None)):
            out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
            viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", out, wide, "--paused", "--size", SIZE, *words, config=kept)
            self.addCleanup(viewer.close)
            seen.append(viewer.picture())
            viewer.press("x")  # which shows the other method beside it, where there is one
            seen.append(viewer.picture())
            viewer.press("Escape")
            self.assertEqual(viewer.end(), (0, ""))
            if kept:
                self.assertEqual(json.loads(viewer.printed)["panel"]["method"]["in use"], "rotation")
        for other in seen[1:]:
            self.assertTrue((other == seen[0]).all())
        self.assertGreater(seen[0].std(), 5)
        self.assertEqual(json.loads((config / "equistream" / "view.json").read_text())["settings"], {})  # the choice stays as it was

    def truth(self):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        PROGRAMS.run("render", self.scene, "--camera", "perspective", "--eye", "both", "--frames", "0-2", "--fps", 5, "--size", SIZE, "--spp", 4, "--aovs", "none",
                     "--out", folder)
        return folder

    def test_a_truth_whose_first_frame_is_broken(self):
        truth = self.truth()
        (truth / "left" / "frame.0000.exr").write_bytes(b"no picture")
        self.assertIn("frame.0000.exr", self.line_of(2, self.streams["srgb"], "--truth", truth))

    def test_a_truth_with_a_broken_frame_loses_no_frame(self):
        truth = self.truth()
        (truth / "left" / "frame.0001.exr").write_bytes(b"no picture")
        out = pathlib.Path(tempfile.mkdtemp(dir=self.root))
        viewer = ViewerProcess(self.display, PROGRAMS.folder / "equistream", out, self.streams["srgb"], "--paused", "--truth", truth, "--method", "rotation")
        self.addCleanup(viewer.close)
        width = int(SIZE.split("x")[0])
        played = self.root / "played"
        PROGRAMS.run("play", self.streams["srgb"], "--method", "rotation", "--size", SIZE, "--frames", "0-2", "--progress", "none", "--out", played)

        def plain(frame):
            return np.asarray(Image.open(played / "left" / f"frame.{frame:04}.png").convert("RGB")).astype(float)

        def true(frame):
            exposure = json.loads(self.scene.read_text()).get("exposure", 1)
            return bytes_of(srgb(exposure * colour_of(read_frame(truth / "left" / f"frame.{frame:04}.exr")))).astype(float)

        def shows(left, right):
            seen = viewer.picture()
            return psnr(seen[:, : width // 2 - 2], left[:, : width // 2 - 2]) > 45 and psnr(seen[:, width // 2 + 2 :], right[:, width // 2 + 2 :]) > 45

        viewer.press("x")
        wait_for(lambda: shows(plain(0), true(0)), "the truth of the first frame")
        viewer.press("period")
        wait_for(lambda: shows(plain(1), plain(1)), "the next frame, which has none")
        viewer.press("period")
        wait_for(lambda: shows(plain(2), true(2)), "the truth of the last frame")


if __name__ == "__main__":
    unittest.main()
