"""The first experiment in miniature, on the bundled scene: it ends, goes on where it stopped, and draws and tabulates.

usage: smoke_test.py BIN_DIR
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
BIN = pathlib.Path(sys.argv.pop(1)).resolve()


class Smoke(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_study_"))

    def tearDown(self):
        shutil.rmtree(self.root, ignore_errors=True)

    def run_script(self, script, *words, code=0):
        result = subprocess.run([sys.executable, HERE / script, *map(str, words)], capture_output=True, text=True)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def run_experiment(self, *words, **options):
        return self.run_script("run.py", "--bin", BIN, "--work", self.root / "work", "--out", self.root / "results", "--frames", "60-61",
                               "--spp", 1, "--size", "256x256", "--sphere-size", "512x256", "--codecs", "h264", "--crfs", 24,
                               "--repeat", 1, *words, "pavilion", **options)

    def test_whole_way(self):
        self.run_experiment("--render-only")
        (self.root / "work/pavilion/steps/render-sphere-left-seed2.json").unlink()  # as if it had been interrupted there
        self.run_experiment()
        result = json.loads((self.root / "results/pavilion.json").read_text())
        self.assertEqual(len(result["systems"]), 3 * 2 * 2)
        resumed = {(render["name"], render["seed"]) for render in result["renders"] if render["resumed"]}
        self.assertEqual(resumed, {("sphere-left", 2)})
        for entry in result["systems"]:
            for eye in ("left", "right"):
                self.assertGreater(entry["against_other_seed"][0]["eyes"][eye]["ssim"], 0)
                self.assertIn("display", entry["noise_free"]["eyes"][eye])
            if entry["codec"] != "none":
                self.assertGreater(entry["played"][0]["bytes"]["main"], 0)
                self.assertGreater(entry["played"][0]["bytes"]["small"], 0)
                self.assertIn("small", entry["played"][0]["filled"]["right"])
        again = self.run_experiment()
        self.assertNotIn("equistream", again.stdout.replace(str(self.root), ""), "a finished step ran again")
        self.run_script("charts.py", "--results", self.root / "results")
        for name in ("accuracy-time", "accuracy-bytes"):
            self.assertTrue((self.root / f"results/{name}.svg").exists() and (self.root / f"results/{name}.png").exists())
        page = self.root / "page.md"
        page.write_text("# Page\n\nwritten by hand\n\n<!-- table cost pavilion -->\nold\n<!-- end -->\n\nand after\n")
        self.run_script("report.py", "--results", self.root / "results", "--page", page)
        text = page.read_text()
        self.assertIn("written by hand", text)
        self.assertLess(text.index("H.264, CRF 24"), text.index("and after"))
        self.assertNotIn("old\n", text)

    def test_errors_are_one_line(self):
        result = self.run_script("run.py", "--bin", self.root, "--work", self.root / "work", "pavilion", code=1)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1)
        result = self.run_script("charts.py", "--results", self.root, code=1)
        self.assertIn("found none", result.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=1)
