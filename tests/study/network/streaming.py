#!/usr/bin/env python3
"""What networks do to a stream: docs/results/stream.json.

usage: streaming.py --bin BIN_DIR --work FOLDER [--other-bin BIN_DIR] [--parts lines,page,drawing,viewers,live,live_lines,faults,pose]

Needs root: real sockets in two network namespaces, with a line between them that is emulated packet by packet (emulated.py).

lines: `equistream serve` sends a recorded stream of the bundled scene `motion` in time with its frames. The other side notes when each sphere is there,
decoded. `play --network trace=` then shows what a viewer sees at each refresh, for a head that moves on meanwhile, and `compare` scores it against a render
of that refresh's own time. The scene glows, so there is no noise, and nothing but lateness differs between lines.

drawing: how long the page takes to draw one eye and both, on one machine.

page: the same stream in Chromium, by `serve --web` over https, while its head turns (page_lines.py).

viewers: one and eight at a time, each with a decoder of its own.

live: `equistream serve SCENE` over a line that carries ever less, and then all again (live_streams.py).

live_lines: the same over lines that lose packets, with and without a window; and a recorded stream of tiles.

faults: a server, a viewer and a line that end without a word, and ends of another version (sudden_ends.py).

pose: how long a pose takes until both eyes' pictures of its sphere are there, by stage, on one machine (live_viewer.cpp).

Without --bin only the tables are made again (stream_page.py).

--other-bin: programs whose server leaves congestion control to the system. That is set to Reno for them, which slows down where packets are lost.
"""

import argparse
import itertools
import json
import math
import pathlib
import statistics
import subprocess
import sys

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS.parent / "programs/study"), *(str(TESTS / folder) for folder in ("stress", "programs", "programs/viewer", "programs/live")),
                str(pathlib.Path(__file__).resolve().parent)]
import live_streams  # noqa: E402
import page_lines  # noqa: E402
import sudden_ends  # noqa: E402
from conditions import AS_SOON_S, LINES, LIVE, LIVE_KINDS, LIVE_WAYS, LOSSY_LINES, LOSSY_S, LOSSY_WAYS, QUERIES, SEEDS, TILED, TILES, WAYS, recovery_s  # noqa: E402
from emulated import SERVER, Line, Network  # noqa: E402
from ends import SECRET, Server, address, in_a_child, receive  # noqa: E402
from kept import result_text  # noqa: E402
from steps import Steps, provenance, run_as_program, write_whole  # noqa: E402
from stream_page import write_page  # noqa: E402

RESULT, PAGE = (TESTS.parent / "docs/results" / name for name in ("stream.json", "stream.md"))
SECONDS, SPHERE, EYES, FOV_DEG, REFRESH_HZ = 6, "960x480", "320x180", 90, 90
QUIET = ("--max-bounces", 0, "--progress", "none")
CODING = ("--crf", 16, "--preset", "ultrafast", "--depth", "w10")
"""Of this preset no picture waits for a later one, as in live streams."""
FIRST_S, LAST_S = 1.5, 5.5
"""Of what is scored: until then the clock learns the line, and in the end no sphere follows."""
WORTH_SEEING_MS = 2000
"""Where half of the spheres come later, a viewer sees the past, and nothing is scored."""
POSE_S = 60


def make_frames(steps):
    steps.run("scene", "scene", "generate", "motion", "--option", f"seconds={SECONDS}", "--out", "scene")
    steps.run("frames", "render", "scene/motion.json", "--frames", f"0-{30 * SECONDS}", "--size", SPHERE, "--spp", 4, "--aovs", "depth,motion,ids", *QUIET, "--out", "frames")


def make_inputs(steps):
    from by_play import head_path
    make_frames(steps)
    write_whole(steps.work / "head.csv", head_path(steps.work / "scene/motion.json"))
    scored = f"{round(FIRST_S * REFRESH_HZ)}-{round(LAST_S * REFRESH_HZ)}"
    steps.run("truth", "render", "scene/motion.json", "--camera", "perspective", "--eye", "both", "--path", "head.csv", "--fps", REFRESH_HZ,
              "--frames", scored, "--size", EYES, "--fov", FOV_DEG, "--spp", 16, *QUIET, "--out", "truth")
    steps.run("encode", "encode", "frames", "--out", "motion.mkv", *CODING, "--motion", "auto", "--progress", "none")
    return scored


def make_pavilion(steps):
    steps.run("pavilion", "scene", "generate", "pavilion", "--out", "pavilion")
    return steps.work / "pavilion/pavilion.json"


def recorded(programs, stream, line, way, seed, viewers=1):
    network = Network(line, seed, receive)
    if way == "reno":
        pathlib.Path("/proc/sys/net/ipv4/tcp_congestion_control").write_text("reno")
    server = Server(programs, stream, f"{WAYS[way]}://{SERVER}:9000{QUERIES.get(way, '')}", "--patience", 60, "--per-address", viewers)
    network.begin()
    network.connection.send(f"{viewers} ".encode() + address(WAYS[way]) + QUERIES.get(way, "").encode())
    found = json.loads(network.connection.recv(1 << 22))
    server.wait("came")
    began, report = [at for at, event in server.events if event["event"] == "came"], server.end()
    network.close()
    return {**found, "began": began[0], "all_began": began, "bytes": report["bytes_sent"], "sent_bytes": network.sent_bytes, "packets": network.carried + network.lost,
            "packets_lost": network.lost, "silence": [network.began + at_s for at_s in line.silent]}


def write_trace(file, came, began):
    """The server sends the first sphere when a viewer has come, and each other one so much later as its time says. How late they came, in ms, once the
    first second is over."""
    write_whole(file, "time_s,arrival_s\n" + "".join(f"{due:.6f},{at - began + came[0][0]:.6f}\n" for due, at, _ in came))
    return lateness(came, began)


def lateness(came, began):
    late = sorted(1000 * ((at - began) - (due - came[0][0])) for due, at, _ in came if due >= came[0][0] + 1)
    return {"median": round(statistics.median(late), 1), "p95": round(late[int(0.95 * (len(late) - 1))], 1), "most": round(late[-1], 1)} if late else None


def recovered_s(found):
    """How long after the line's silence spheres come as soon as before it."""
    came, (silent, over) = found["came"], found["silence"]
    late = [(at, (at - found["began"]) - (due - came[0][0])) for due, at, _ in came]
    before = [late_s for at, late_s in late if at < silent]
    again = recovery_s(late, over, statistics.median(before) + AS_SOON_S) if before else None
    return again and round(again, 3)


def seen(steps, name, network, scored):
    """What an eye saw by way of `network`."""
    steps.run(f"play-{name}", "play", "motion.mkv", "--method", "mesh", "--depth", "stream", "--fill", "pushpull", "--head", "head.csv", "--refresh", REFRESH_HZ,
              "--network", network, "--size", EYES, "--fov", FOV_DEG, "--progress", "none", "--out", f"views/{name}", fresh=f"views/{name}")
    steps.run(f"compare-{name}", "compare", f"views/{name}", "truth", "--frames", scored, "--metrics", "psnr", "--progress", "none", "--out", f"{name}.json")
    eyes = json.loads((steps.work / f"{name}.json").read_text())["eyes"].values()
    report = json.loads((steps.work / f"views/{name}/report.json").read_text())["viewing"]
    return {"mean_square": statistics.mean(eye["mean_square"] for eye in eyes), "worst_db": min(frame["psnr_db"] for eye in eyes for frame in eye["per_frame"]),
            "age_ms": report["age_ms"], "cuts": report["cuts"], "blank": report["blank"]}


def lines(options, steps, keep, kept):
    """First all that takes its own time, then what takes a processor's."""
    scored = make_inputs(steps)
    ways = [way for way in options.ways.split(",") if way != "reno" or options.other_bin]
    rows, traces = [], {}
    for name, line in LINES.items():
        for way in ways:
            for seed in SEEDS:
                programs = options.other_bin if way == "reno" else options.bin
                found = in_a_child(lambda: recorded(programs, steps.work / "motion.mkv", line, way, seed))
                row = {"line": name, "way": way, "seed": seed, "spheres": len(found["came"]), "problem": found["problem"],
                       **{key: found[key] for key in ("bytes", "sent_bytes", "packets", "packets_lost")}}
                if found["silence"]:
                    row["recovered_s"] = recovered_s(found)
                rows.append(row)
                print(row, file=sys.stderr, flush=True)
                if found["came"]:
                    key = f"{list(LINES).index(name)}-{way}-{seed}"
                    row["late_ms"] = write_trace(steps.work / f"{key}.csv", found["came"], found["began"])
                    sees_all = found["came"][0][1] - found["began"] < FIRST_S
                    if sees_all and row["late_ms"] and row["late_ms"]["median"] < WORTH_SEEING_MS:
                        traces[key] = row
    for key, row in traces.items():
        row.update(seen(steps, key, f"trace={key}.csv", scored))
    keep("lines", [*(row for row in kept if row["way"] not in ways), *rows], *(f"lines by {way}" for way in ways))


def page(options, steps, keep, kept):
    make_inputs(steps)
    rows = []
    for name, line in page_lines.LINES.items():
        for seed in SEEDS:
            found = in_a_child(lambda: page_lines.shown(lambda *words: Server(options.bin, steps.work / "motion.mkv", f"tcp://{SERVER}:9000", *words),
                                                        SECRET, steps.work / "page.pem", line, seed))
            rows.append({"line": name, "seed": seed, "problem": found["problem"], "packets": found["packets"], "packets_lost": found["packets_lost"], **page_lines.figures(found)})
            print(rows[-1], file=sys.stderr, flush=True)
    keep("page", rows)


def drawing(options, steps, keep, kept):
    make_inputs(steps)
    server = Server(options.bin, steps.work / "motion.mkv", "tcp://127.0.0.1:0", "--web", 0, "--loop")
    keep("drawing", page_lines.drawn(server.said["web"] + "?live=stream", [(640, 360), (1280, 720)]))
    server.kill()


def viewers(options, steps, keep, kept):
    """One viewer, and eight at a time, of a stream that leaves the processors room for as many decoders."""
    make_inputs(steps)
    steps.run("encode-small", "encode", "frames", "--out", "small.mkv", "--crf", 24, "--preset", "ultrafast", "--progress", "none")
    rows = []
    for way in ("tcp", "tls", "srt"):
        for count in (1, 8):
            found = in_a_child(lambda: recorded(options.bin, steps.work / "small.mkv", Line(), way, 1, count))
            came = sorted([found["came"], *found["others"]], key=lambda spheres: spheres[0][1])
            rows.append({"way": way, "viewers": count, "spheres": [len(spheres) for spheres in came], "bytes": found["bytes"],
                         "late_ms": [lateness(spheres, began) for spheres, began in zip(came, found["all_began"], strict=True)]})
            print(rows[-1], file=sys.stderr, flush=True)
    keep("viewers", rows)


def live(options, steps, keep, kept):
    kinds = options.sent.split(",")
    if not set(kinds) <= set(LIVE_KINDS):
        raise Failed(f"--sent: expected some of {', '.join(LIVE_KINDS)}, found {options.sent}")
    scene, rows = make_pavilion(steps), [row for row in kept if row["sent"] not in kinds]
    for kind, way, seed in itertools.product(kinds, LIVE_WAYS, SEEDS):
        found = in_a_child(lambda: live_streams.narrowed(options.bin, scene, (*LIVE, *LIVE_KINDS[kind]), way, seed))
        rows.append({"sent": kind, "way": way, "seed": seed, **found})
        print({key: value for key, value in rows[-1].items() if key != "spheres"}, file=sys.stderr, flush=True)
    keep("live", rows)


def live_lines(options, steps, keep, kept):
    make_frames(steps)
    steps.run("encode-tiles", "encode", "frames", "--out", "tiles.mkv", *CODING, "--tiles", TILES, "--progress", "none")
    scene, rows = make_pavilion(steps), []
    served = {**{kind: (scene, (*LIVE, *words), LOSSY_S) for kind, words in LIVE_KINDS.items()}, TILED: (steps.work / "tiles.mkv", (), None)}
    for kind, (source, words, seconds) in served.items():
        for line in LOSSY_LINES:
            for way in LOSSY_WAYS:
                for seed in SEEDS:
                    found = in_a_child(lambda: live_streams.lossy(options.bin, source, words, LINES[line], way, seed, seconds))
                    rows.append({"sent": kind, "line": line, "way": way, "seed": seed, **found})
                    print(rows[-1], file=sys.stderr, flush=True)
    keep("live_lines", rows)


def faults(options, steps, keep, kept):
    make_inputs(steps)
    keep("faults", sudden_ends.measured(options.bin, steps.work / "motion.mkv", make_pavilion(steps)))


def pose(options, steps, keep, kept):
    """The server's stages are its own report's; a viewer's head moves so that each picture tells when its pose was sent."""
    server = Server(options.bin, make_pavilion(steps), "tcp://127.0.0.1:0", *LIVE)
    said = json.loads(subprocess.run([options.bin / "equistream_live_viewer", server.url, str(POSE_S)], check=True, capture_output=True, text=True).stdout)
    report = server.end()["live"]
    stages = {name: {key: round(times[key], 2) for key in ("p50", "p99")} | {"samples": times["samples"]} for name, times in report["stages_ms"].items()}
    shown = said["shown"]
    stages["pose to picture"] = spread([each["shown_s"] - each["sent_s"] for each in shown])
    own = {f"{stage}_ms": spread([each[f"{stage}_s"] for each in shown]) for stage in ("decode", "render", "playout_delay")}
    keep("pose", {"stages_ms": stages, **own, "spheres_per_s": report["spheres_per_s"], "spp": report["spp"]})


def spread(seconds):
    """Milliseconds, nearest ranks."""
    ranked = sorted(1000 * each for each in seconds)
    return {**{name: round(ranked[max(0, math.ceil(share * len(ranked)) - 1)], 2) for name, share in (("p50", 0.5), ("p99", 0.99))}, "samples": len(ranked)}


PARTS = {part.__name__: part for part in (lines, page, drawing, viewers, live, live_lines, faults, pose)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, help="folder of the built programs; without it only the tables are made again")
    parser.add_argument("--other-bin", type=pathlib.Path, help="the same, of a server that leaves congestion control to the system")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders and streams")
    parser.add_argument("--out", type=pathlib.Path, default=RESULT, help="JSON")
    parser.add_argument("--parts", default=",".join(PARTS), help="which of them (default: %(default)s)")
    parser.add_argument("--ways", default=",".join(WAYS), help="of the lines; figures of others are kept")
    parser.add_argument("--sent", default=",".join(LIVE_KINDS), help="of the live scene's narrow line; figures of others are kept (default: %(default)s)")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="whose tables are made")
    options = parser.parse_args()
    if not options.bin:
        return write_page(json.loads(options.out.read_text()), options.page)
    options.bin = options.bin.resolve()
    options.work.mkdir(parents=True, exist_ok=True)
    steps = Steps(options.work.resolve(), options.bin, {}, {"sphere": SPHERE, "eyes": EYES, "seconds": SECONDS})
    kept = json.loads(options.out.read_text()) if options.out.exists() else {}

    def keep(part, found, *made):
        kept.update({"command": "tests/study/network/streaming.py --bin BIN --work W --out docs/results/stream.json", part: found})
        kept.setdefault("provenance", {}).update(dict.fromkeys(made or [part], provenance(options.bin, TESTS.parent)))
        write_whole(options.out, result_text(kept))

    for part in options.parts.split(","):
        PARTS[part](options, steps, keep, kept.get(part, []))
    write_page(kept, options.page)


if __name__ == "__main__":
    run_as_program(main)
