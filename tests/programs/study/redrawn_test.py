#!/usr/bin/env python3
"""Every table of docs/results, and every page of the study, is what is drawn of the JSON beside it, byte for byte; the repository stays small.

usage: redrawn_test.py      (with the Python package on PYTHONPATH)
"""

import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
RESULTS = REPOSITORY / "docs/results"
LARGEST_MB = 20
DRAWN = {
    "study": ["programs/study/study.py", "--bin", "unused", "--charts", "only", "--out", "study"],
    "reproject": ["tests/study/reproject/report.py", "--results", "reproject", "--page", "reproject.md"],
    "reliability": ["tests/study/reproject/reliability_page.py", "reproject"],
    "renderer": ["tests/study/renderer/report.py", "--results", "renderer", "--page", "renderer.md"],
    "denoise": ["tests/study/renderer/denoise.py", "--page", "--out", "denoise.json"],
    "denoise, seam": ["tests/study/renderer/seam.py", "--page", "--out", "denoise.json"],
    "accumulate": ["tests/study/renderer/accumulate.py", "--page", "--out", "accumulate.json"],
    "mitsuba": ["tests/study/hosts/report.py", "--results", "mitsuba", "--page", "mitsuba.md"],
    "viewer, speed": ["tests/study/viewer/speed.py", "--page", "viewer.md"],
    "viewer, refresh": ["tests/study/viewer/refresh.py", "--page", "viewer.md"],
    "viewer, gpu": ["tests/study/viewer/gpu.py", "--results", "."],
    "trust": ["tests/study/trust.py", "trust.md"],
    "latency": ["tests/study/viewer/carrying.py", "--page", "latency.md"],
    "stream": ["tests/study/network/streaming.py", "--out", "stream.json", "--page", "stream.md"],
}


def cut_tables(page):
    """Without what stands between markers, which is to be drawn anew."""
    return re.sub(r"(<!-- table [^>]* -->\n).*?(?=<!-- end -->)", r"\1", page, flags=re.S)


class Redrawn(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        self.copy = pathlib.Path(holder.name) / "results"
        shutil.copytree(RESULTS, self.copy)
        for page in self.copy.rglob("*.md"):
            page.write_text(cut_tables(page.read_text()))
        for drawn in (*self.copy.glob("study/*.html"), self.copy / "study/tables.md"):
            drawn.unlink()

    def test_tables_and_pages_are_those_of_their_json(self):
        for name, (script, *words) in DRAWN.items():
            done = subprocess.run([sys.executable, "-B", REPOSITORY / script, *words], cwd=self.copy, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"{name}: {done.stderr}")
        drawn = [*RESULTS.rglob("*.md"), *RESULTS.glob("study/*.html")]
        self.assertGreater(len(drawn), 10)
        for file in drawn:
            self.assertEqual((self.copy / file.relative_to(RESULTS)).read_text(), file.read_text(), f"{file.name}: not what its JSON holds")


class Pages(unittest.TestCase):
    def test_every_point_has_its_picture_beside_the_page(self):
        pages = list(RESULTS.glob("study/*.html"))
        self.assertEqual(len(pages), 5)
        for page in pages:
            text = page.read_text()
            data = json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.S)[1])
            source = re.search(r'<script src="([^":]*)"></script>', text)[1]
            pictures = json.loads((page.parent / source).read_text().removeprefix("const pictures = ").rstrip(";\n"))
            self.assertTrue(all(pictures["views"][point["view"]]["seen"].startswith("data:image/") for point in data["points"]), page.name)


class Size(unittest.TestCase):
    def test_tracked_files_are_small_altogether(self):
        listed = subprocess.run(["git", "-C", REPOSITORY, "ls-files", "-z"], capture_output=True, text=True)
        if listed.returncode != 0:
            self.skipTest("no git checkout")
        files = [REPOSITORY / name for name in listed.stdout.split("\0") if name and (REPOSITORY / name).is_file()]
        self.assertLess(sum(file.stat().st_size for file in files) / 1e6, LARGEST_MB)
        pictures = [str(file) for file in files if file.suffix == ".png" and file.with_suffix(".svg").exists()]
        self.assertEqual(pictures, [], "a chart stands once, as SVG")


if __name__ == "__main__":
    unittest.main()
