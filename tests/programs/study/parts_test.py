"""Parts of a render that jobs of a farm made are one sequence afterwards, of which nothing is rendered again.

usage: parts_test.py BIN_DIR
"""

import pathlib
import shutil
import sys
import tempfile
import unittest

import equistream as es
import render_list
from presets import PRESETS
from scene_work import SceneWork

BIN = pathlib.Path(sys.argv.pop(1)).resolve()
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


if __name__ == "__main__":
    unittest.main()
