#!/usr/bin/env python3
"""Runs the fuzz targets one after the other, and counts the lines of our parsers that their corpora reach.

usage: run.py BUILD [--seconds N] [--targets NAMES] [--corpora FILE] [--report FILE]

BUILD is the folder of the preset `fuzz`; llvm-cov and llvm-profdata of version 14 are needed. Corpora begin with the seeds and with
FILE (tests/fuzz/corpora.tar.xz), which fuzz_test replays in every build. FILE gets the smallest set of inputs that reaches the same code,
but for inputs above 20,000 bytes. --seconds 0 fuzzes nothing. The report adds up what a target was run before. Ends with 1 where a
target has found something; the input lies beside its corpus.
"""

import argparse
import json
import lzma
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
LLVM = "14"
# Inputs above this are left out of the committed corpora.
MAX_INPUT_BYTES = 20000

# Which files read the bytes that a target is given. What writes the same format stands in some of them: targets write what they
# have read, and read it again.
PARSERS = {
    "command_lines": ["programs/cli/program.cpp", "programs/cli/command_line.cpp"],
    "frame_data": ["plugin/stream/frame_info_codec.cpp", "plugin/stream/motion_table.cpp", "plugin/stream/patch_table.cpp"],
    "manifest": ["plugin/export/frame_json.cpp", "plugin/export/json_text.cpp", "plugin/export/sequence.cpp"],
    "scene": ["scenes/library/scene.cpp", "scenes/library/description_json.cpp"],
    "path": ["scenes/library/scene_motion.cpp"],
    "model": ["scenes/library/accessor.cpp", "scenes/library/gltf_document.cpp", "scenes/library/gltf_materials.cpp",
              "scenes/library/gltf_model.cpp"],
    "obj": ["scenes/library/mtl_file.cpp", "scenes/library/obj_document.cpp", "scenes/library/obj_materials.cpp",
            "scenes/library/obj_model.cpp", "scenes/library/polygon.cpp"],
    "exr": ["plugin/export/exr_attributes.cpp", "plugin/export/exr_read.cpp"],
    "foreign_exr": ["host-adapters/import/attribute_sizes.cpp", "host-adapters/import/channel_map.cpp",
                    "host-adapters/import/convert.cpp", "host-adapters/import/foreign_exr.cpp"],
    "stream": ["plugin/stream/source.cpp", "plugin/stream/stream_reader.cpp", "plugin/stream/track_decoder.cpp"],
    "shown_frames": ["client/receive/decoded_pictures.cpp", "client/receive/tiles.cpp"],
    "viewer_messages": ["plugin/stream/viewer_message.cpp", "programs/serve/programmes.cpp"],
    "served_file": ["plugin/stream/send_times.cpp", "plugin/stream/tile_stream.cpp", "programs/serve/recordings.cpp", "programs/serve/recorded_file.cpp"],
    "plugin_calls": ["plugin/abi/equistream.cpp", "plugin/abi/settings.cpp"],
    "client_calls": ["client/abi/caller_data.cpp", "client/abi/client.cpp"],
    "client_model": ["client/model/client_model.cpp"],
}

# Inputs may take as long and as much as this.
LIMITS = ["-timeout=20", "-rss_limit_mb=6000", "-malloc_limit_mb=1500"]
ENVIRONMENT = dict(os.environ, ASAN_OPTIONS="new_delete_type_mismatch=0:detect_leaks=0", LLVM_PROFILE_FILE="/dev/null")


def packed(corpora, file):
    """The same bytes for the same inputs."""
    def plain(entry):
        entry.mtime, entry.uid, entry.gid, entry.uname, entry.gname, entry.mode = 0, 0, 0, "", "", 0o644
        return entry
    with tarfile.open(file, "w:xz", preset=9 | lzma.PRESET_EXTREME, format=tarfile.USTAR_FORMAT) as archive:
        for path in sorted(path for path in corpora.rglob("*") if path.is_file() and 0 < path.stat().st_size <= MAX_INPUT_BYTES):
            archive.add(path, path.relative_to(corpora), filter=plain)


def fuzzed(program, corpus, seconds, seed):
    """Runs one target: how often, and whether it found nothing."""
    command = [program, f"-seed={seed}", f"-max_total_time={seconds}", "-print_final_stats=1", *LIMITS,
               f"-artifact_prefix={corpus}.", corpus]
    begun = time.monotonic()
    done = subprocess.run(command, env=ENVIRONMENT, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True, errors="replace")
    executions = re.search(r"number_of_executed_units: *(\d+)", done.stderr)
    if done.returncode != 0:
        print(done.stderr[-4000:], file=sys.stderr)
    return {"executions": int(executions[1]) if executions else 0, "seconds": round(time.monotonic() - begun), "found": done.returncode != 0}


def smallest(program, corpus, room):
    """The inputs of the corpus that reach code which smaller ones do not, however often."""
    kept = room / corpus.name
    kept.mkdir()
    subprocess.run([program, "-merge=1", "-use_counters=0", *LIMITS, kept, corpus], env=ENVIRONMENT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
    return kept


def reached_lines(programs, corpora, files, room):
    """(reached, of) lines of each file, by all targets together."""
    profiles = []
    for name, program in programs.items():
        profile = room / f"{name}.profraw"
        subprocess.run([program, "-runs=0", *LIMITS, corpora / name], env=ENVIRONMENT | {"LLVM_PROFILE_FILE": str(profile)},
                       stderr=subprocess.DEVNULL, check=True)
        profiles.append(profile)
    merged = room / "all.profdata"
    subprocess.run([f"llvm-profdata-{LLVM}", "merge", "-sparse", *profiles, "-o", merged], check=True)
    libraries = [next(iter(programs.values())).parents[1] / f"lib/{name}.so" for name in ("libequistream", "libequistream_client")]
    objects = [word for file in libraries for word in ("-object", file)]  # all targets are one program
    told = subprocess.run([f"llvm-cov-{LLVM}", "export", "-summary-only", f"-instr-profile={merged}", next(iter(programs.values())),
                           *objects, *(ROOT / file for file in files)], capture_output=True, text=True, check=True)
    lines = {}
    for file in json.loads(told.stdout)["data"][0]["files"]:
        name = next((name for name in files if file["filename"].endswith(name)), None)
        if name is not None:
            lines[name] = (file["summary"]["lines"]["covered"], file["summary"]["lines"]["count"])
    if missing := [file for file in files if file not in lines]:
        print(f"run.py: expected lines of every parser, found none of {', '.join(missing)}", file=sys.stderr)
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--seconds", type=int, default=60, help="a target")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--targets", default=",".join(PARSERS), help="names between commas")
    parser.add_argument("--corpora", type=pathlib.Path, default=HERE / "corpora.tar.xz")
    parser.add_argument("--report", type=pathlib.Path)
    asked = parser.parse_args()
    names = asked.targets.split(",")
    for name in names:
        if name not in PARSERS:
            parser.error(f"--targets: expected names of {', '.join(PARSERS)}, found '{name}'")
    programs = {name: asked.build.resolve() / "bin" / f"fuzz_{name}" for name in PARSERS}
    known = json.loads(asked.report.read_text()) if asked.report and asked.report.exists() else {"targets": {}}
    corpora = asked.build.resolve() / "corpora"
    corpora.mkdir(exist_ok=True)
    if asked.corpora.exists():
        with tarfile.open(asked.corpora) as archive:
            archive.extractall(corpora, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))
    with tempfile.TemporaryDirectory(dir=asked.build) as room:
        room = pathlib.Path(room)
        (room / "smallest").mkdir()
        for name, program in programs.items():
            subprocess.run([program, "--seeds", corpora / name], check=True, stderr=subprocess.DEVNULL)
            if name in names and asked.seconds > 0:
                figures = fuzzed(program, corpora / name, asked.seconds, asked.seed)
                before = known["targets"].get(name, {"executions": 0, "seconds": 0})
                known["targets"][name] = {**figures, "executions": figures["executions"] + before["executions"],
                                          "seconds": figures["seconds"] + before["seconds"], "found": figures["found"] or before.get("found", False)}
                print(f"{name}: {figures['executions']} executions, {'a find' if figures['found'] else 'no find'}", flush=True)
                if asked.report:
                    asked.report.write_text(json.dumps(known, indent=1) + "\n")
            kept = smallest(program, corpora / name, room / "smallest")
            shutil.rmtree(corpora / name)
            shutil.copytree(kept, corpora / name)
        packed(room / "smallest", room / "packed.tar.xz")
        shutil.copyfile(room / "packed.tar.xz", asked.corpora.with_suffix(".part"))
        os.replace(asked.corpora.with_suffix(".part"), asked.corpora)
        files = [file for files in PARSERS.values() for file in files]
        lines = reached_lines(programs, corpora, files, room)
    known["lines"], known["parsers"] = {name: lines[name] for name in files if name in lines}, PARSERS
    reached, of = (sum(counts[i] for counts in known["lines"].values()) for i in (0, 1))
    print(f"lines of the parsers: {reached} of {of}, {100 * reached / of:.1f} %")
    if asked.report:
        asked.report.write_text(json.dumps(known, indent=1) + "\n")
    return any(figures["found"] for figures in known["targets"].values())


if __name__ == "__main__":
    sys.exit(main())
