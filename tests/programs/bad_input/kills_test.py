"""Programs that are killed (SIGKILL) at random moments: what is finished stays, nothing broken has a finished name, and the same
command run again ends in the bytes of a run that nothing interrupted.

usage: kills_test.py BIN_DIR [--kills N] [--jobs NAMES] [--seed N] [--report FILE]   (all else is unittest's)

FILE has each job as it was tried last.
"""

import argparse
import json
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
import OpenEXR

ARGUMENTS = argparse.ArgumentParser(description=__doc__)
ARGUMENTS.add_argument("bin", type=pathlib.Path)
ARGUMENTS.add_argument("--kills", type=int, default=4, help="of each job")
ARGUMENTS.add_argument("--jobs", default="", help="names between commas; default: all")
ARGUMENTS.add_argument("--seed", type=int, default=1)
ARGUMENTS.add_argument("--report", type=pathlib.Path)
TOLD, sys.argv[1:] = ARGUMENTS.parse_known_args()
RANDOM = random.Random(TOLD.seed)
REPORT = json.loads(TOLD.report.read_text()) if TOLD.report and TOLD.report.exists() else {"jobs": {}, "same_pixels_other_bytes": []}
OTHER_BYTES = REPORT["same_pixels_other_bytes"]  # of frames whose pixels are the same


def start(*words):
    return subprocess.Popen([TOLD.bin / "equistream", *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)


def run(*words):
    process = start(*words)
    _, told = process.communicate(timeout=500)
    assert process.returncode == 0, told


def is_unfinished(path):
    return any(name.endswith((".part", ".aside")) or ".tmp" in name for name in path.parts)


def unfinished(folder):
    return [str(path) for path in folder.rglob("*") if is_unfinished(path.relative_to(folder))]


def finished(folder):
    """Bytes of all files with a name that says they are finished."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and not is_unfinished(path.relative_to(folder)) and not path.name.startswith(".") and path.suffix != ".lock"
    }


def without_times(name, data):
    """Reports say how long things took; all else of them must be the same."""
    if not name.endswith(".json"):
        return data
    def stripped(value):
        if isinstance(value, dict):
            return {key: stripped(item) for key, item in value.items() if key not in ("machine", "milliseconds") and not key.endswith("_ms")}
        return [stripped(item) for item in value] if isinstance(value, list) else value
    return stripped(json.loads(data))


class Kills(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.root = pathlib.Path(tempfile.mkdtemp(prefix="equistream_kills_"))
        cls.addClassCleanup(shutil.rmtree, cls.root, ignore_errors=True)
        cls.scene, cls.frames, cls.foreign = cls.root / "scene" / "motion.json", cls.root / "frames", cls.root / "foreign"
        run("scene", "generate", "motion", "--out", cls.scene.parent)
        run("render", cls.scene, "--frames", "0-5", "--size", "192x96", "--spp", 4, "--aovs", "depth", "--out", cls.frames)
        cls.foreign.mkdir()
        for index, source in enumerate(sorted((cls.frames / "centre").glob("*.exr"))):
            with OpenEXR.File(str(source)) as file:
                channels = file.parts[0].channels
                rgb = np.stack([channels[c].pixels for c in "RGB"], axis=-1) if "R" in channels else channels["RGBA"].pixels[..., :3]
            OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": np.ascontiguousarray(rgb, np.float32)}).write(
                str(cls.foreign / f"shot.{index + 1:04d}.exr")
            )

    def channels_of(self, data):
        copy = self.root / "compared.exr"
        copy.write_bytes(data)
        with OpenEXR.File(str(copy), separate_channels=True) as file:
            return {f"{i} {name}": channel.pixels.tobytes() for i, part in enumerate(file.parts) for name, channel in part.channels.items()}

    def assert_same(self, file, data, expected, when):
        if without_times(file, data) == without_times(file, expected):
            return
        if file.endswith(".exr") and self.channels_of(data) == self.channels_of(expected):
            OTHER_BYTES.append(f"{when}: {file}")  # rare: one frame in thousands is compressed otherwise
            return
        first = next((i for i, (a, b) in enumerate(zip(data, expected, strict=False)) if a != b), min(len(data), len(expected)))
        self.fail(f"{when}: {file} differs from byte {first} on: {data[first - 20 : first + 20]} for {expected[first - 20 : first + 20]}")

    def survives(self, name, words, out_name="out", resumes=True):
        """Kills the job again and again. `resumes`: it goes on with what the killed run has finished; else it begins anew."""
        if TOLD.jobs and name not in TOLD.jobs.split(","):
            self.skipTest("another job was asked for")
        place = self.root / name
        place.mkdir()
        begun = time.monotonic()
        run(*words, "--out", place / out_name)
        duration_s = time.monotonic() - begun
        expected = finished(place)
        self.assertTrue(expected)
        shutil.rmtree(place)
        kills = found = anew = 0
        while kills < TOLD.kills:
            place.mkdir(exist_ok=True)
            kept = finished(place)
            process = start(*words, "--out", place / out_name)
            time.sleep(RANDOM.uniform(0, 1.1 * duration_s))
            process.send_signal(signal.SIGKILL)
            _, told = process.communicate()
            kills += process.returncode == -signal.SIGKILL
            if process.returncode != -signal.SIGKILL:
                self.assertEqual(process.returncode, 0, told)
            left = finished(place)
            for file, data in left.items():
                self.assertIn(file, expected.keys())
                beside = [other for other in left if pathlib.Path(other).parent == pathlib.Path(file).parent and other != file]
                if file.endswith("manifest.json") and not beside or file.endswith("report.json"):
                    continue  # both mark a folder as their program's, and say the rest once there is something to say it of
                self.assert_same(file, data, expected[file], f"{name} after a kill")
            if resumes:
                self.assertLessEqual(kept.keys(), left.keys(), f"{name}: what was finished is gone")
            found += len(left)
            is_over = left.keys() == expected.keys()
            if is_over or RANDOM.random() < 0.3:
                if not is_over:
                    run(*words, "--out", place / out_name)
                again = finished(place)
                self.assertEqual(again.keys(), expected.keys())
                self.assertEqual(unfinished(place), [])
                for file, data in again.items():
                    self.assert_same(file, data, expected[file], f"{name} after it was resumed")
                anew += 1
                shutil.rmtree(place)
        REPORT["jobs"][name] = {"kills": kills, "finished_files_checked": found, "resumed_to_the_end": anew, "seconds_uninterrupted": round(duration_s, 2), "seed": TOLD.seed}
        if TOLD.report:
            TOLD.report.write_text(json.dumps(REPORT, indent=1) + "\n")

    def test_render(self):
        self.survives("render", ["render", self.scene, "--frames", "0-7", "--size", "192x96", "--spp", 8, "--aovs", "depth,motion"])

    def test_render_mitsuba(self):
        if not (TOLD.bin / "equistream-render-mitsuba").exists():
            self.skipTest("built without Mitsuba")
        self.survives("mitsuba", ["render", self.scene, "--host", "mitsuba", "--frames", "0-3", "--size", "96x48", "--spp", 4])

    def test_render_accumulated(self):
        self.survives("accumulate", ["render", self.scene, "--frames", "0-5", "--size", "128x64", "--spp", 4, "--accumulate", 8])

    def test_render_patches(self):
        self.survives("patches", ["render", self.scene, "--frames", "0-5", "--size", "128x64", "--spp", 2, "--patches", "--layers", "--small", "right"])

    def test_render_window(self):
        self.survives("window", ["render", self.scene, "--frames", "0-5", "--size", "128x64", "--spp", 2, "--window", "gaze,90x60"])

    def test_encode(self):
        self.survives("encode", ["encode", self.frames, "--depth", "auto"], "walk.mp4", resumes=False)

    def test_import(self):
        self.survives("import", ["import", self.foreign / "shot.####.exr"])

    def test_play(self):
        self.survives("play", ["play", self.frames, "--method", "rotation", "--size", "96x64"], resumes=False)

    def test_model(self):
        self.survives(
            "model", ["model", self.scene, "--rays", 20000, "--visibility-rays", 200000, "--quantile", 0.9], "model.json", resumes=False
        )


if __name__ == "__main__":
    unittest.main()
