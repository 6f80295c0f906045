#!/usr/bin/env python3
"""What networks do to a stream: docs/results/stream.json.

usage: streaming.py --bin BIN_DIR --work FOLDER [--other-bin BIN_DIR] [--parts lines,page,drawing,viewers,live,faults,pose]

Needs root: real sockets in two network namespaces, with a line between them that is emulated packet by packet (emulated.py).

lines: `equistream serve` sends a recorded stream of the bundled scene `motion` in time with its frames. The other side notes when each sphere is there,
decoded. `play --network trace=` then shows what a viewer sees at each refresh, for a head that moves on meanwhile, and `compare` scores it against a render
of that refresh's own time. The scene glows, so there is no noise, and nothing but lateness differs between lines.

drawing: how long the page takes to draw one eye and both, on one machine.

page: the same stream in Chromium, by `serve --web` over https, while its head turns (page_lines.py).

viewers: one and eight at a time, each with a decoder of its own.

faults: a server, a viewer and a line that end without a word.

live: `equistream serve SCENE` over a line that carries ever less, and then all again.

pose: how long a pose takes until both eyes' pictures of its sphere are there, by stage, on one machine.

--other-bin: programs whose server leaves congestion control to the system. That is set to Reno for them, which slows down where packets are lost.
"""

import argparse
import json
import math
import os
import pathlib
import signal
import statistics
import subprocess
import sys
import threading
import time

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS.parent / "programs/study"), str(TESTS / "stress"), str(TESTS / "programs"), str(TESTS / "programs/viewer"), str(pathlib.Path(__file__).resolve().parent)]
import page_lines  # noqa: E402
from emulated import SERVER, Line, Network  # noqa: E402
from kept import result_text  # noqa: E402
from pages import cell, place, table  # noqa: E402
from steps import Failed, Steps, provenance, run_as_program, write_whole  # noqa: E402

RESULT, PAGE = (TESTS.parent / "docs/results" / name for name in ("stream.json", "stream.md"))
SECRET = "a-secret-for-a-measurement"
SECONDS, SPHERE, EYES, FOV_DEG, REFRESH_HZ = 6, "960x480", "320x180", 90, 90
FIRST_S, LAST_S = 1.5, 5.5
"""Of what is scored: until then the clock learns the line, and in the end no sphere follows."""
LINES = {
    "nothing lost": Line(),
    "1 % lost": Line(loss=0.01),
    "5 % lost": Line(loss=0.05),
    "10 % lost": Line(loss=0.1),
    "20 % lost": Line(loss=0.2),
    "200 ms of jitter, packets overtake": Line(jitter_s=0.2),
    "5 % lost, 200 ms of jitter": Line(loss=0.05, jitter_s=0.2),
    "silence of 1 s": Line(silent=(3, 4)),
}
WAYS = {"tcp": "tcp", "tls": "tls", "srt": "srt", "reno": "tcp"}
"""Scheme of the address. reno: --other-bin's."""
SEEDS = (1, 2)
WORTH_SEEING_MS = 2000
"""Where half of the spheres come later, a viewer sees the past, and nothing is scored."""
LIVE = ("--size", "480x240", "--spp", "4", "--rate", "4")
LIVE_SHARES = ((0, 1e9), (8, None), (24, 1e9))
"""From that second on the line carries so many Mbit/s; None: a tenth of what it carried until then."""
LIVE_S, SETTLED_S = 40, 8
LIVE_WAYS = "tcp", "tls", "srt"
POSE_S = 60


def make_inputs(steps):
    from by_play import head_path
    steps.run("scene", "scene", "generate", "motion", "--option", f"seconds={SECONDS}", "--out", "scene")
    write_whole(steps.work / "head.csv", head_path(steps.work / "scene/motion.json"))
    scored = f"{round(FIRST_S * REFRESH_HZ)}-{round(LAST_S * REFRESH_HZ)}"
    quiet = ("--max-bounces", 0, "--progress", "none")
    steps.run("frames", "render", "scene/motion.json", "--frames", f"0-{30 * SECONDS}", "--size", SPHERE, "--spp", 4, "--aovs", "depth,motion,ids", *quiet, "--out", "frames")
    steps.run("truth", "render", "scene/motion.json", "--camera", "perspective", "--eye", "both", "--path", "head.csv", "--fps", REFRESH_HZ,
              "--frames", scored, "--size", EYES, "--fov", FOV_DEG, "--spp", 16, *quiet, "--out", "truth")
    # Of this preset no picture waits for a later one, as in live streams.
    steps.run("encode", "encode", "frames", "--out", "motion.mkv", "--crf", 16, "--preset", "ultrafast", "--depth", "w10", "--motion", "auto", "--progress", "none")
    return scored


def receive(connection):
    """On the other side: reads streams, and says when each sphere was decoded, by the clock that both sides have."""
    import equistream

    while asked := connection.recv(1000).decode():
        *viewers, url = asked.split()
        others = [reading(url) for _ in range(int(viewers[0]) - 1)] if viewers else []
        came, problem = [], None
        try:
            stream = equistream.open_stream(url)
            for picture in stream:
                if picture.role == "main":
                    came.append((picture.info.time_s, time.monotonic(), picture.info.crf))
            problem = stream.truncation or None
        except Exception as error:  # what went wrong is a finding too
            problem = str(error)
        others_came = [json.loads(other.stdout.read()) for other in others]
        connection.send(json.dumps({"came": came, "problem": problem, "others": others_came}).encode())


def reading(url):
    """A viewer in a process of its own, which says when each sphere was decoded."""
    program = ("import equistream, json, sys, time\n"
               "print(json.dumps([(p.info.time_s, time.monotonic(), p.info.crf) for p in equistream.open_stream(sys.argv[1]) if p.role == 'main']))")
    return subprocess.Popen([sys.executable, "-c", program, url], stdout=subprocess.PIPE, text=True)


class Server:
    """Whose lines are noted as they come."""

    def __init__(self, programs, source, listen, *words):
        self.process = subprocess.Popen([programs / "equistream-serve", *map(str, (source, "--listen", listen, "--progress", "json", "--json", "--open", *words))],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=dict(os.environ, EQUISTREAM_SECRET=SECRET))
        self.said = json.loads(self.process.stdout.readline())
        self.url = self.said["listening"]
        self.began, self.events = time.monotonic(), []
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        for line in self.process.stderr:
            self.events.append((time.monotonic(), json.loads(line)))

    def wait(self, what, after=0.0):
        """When the first such event came."""
        for _ in range(6000):
            for at, event in self.events:
                if at >= after and event["event"] == what:
                    return at, event["detail"]
            time.sleep(0.01)
        raise Failed(f"a server: expected the event '{what}' within a minute, found {[event for _, event in self.events]}")

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        return json.loads(self.process.stdout.read().splitlines()[-1])

    def kill(self):
        self.process.kill()
        self.process.wait()


def address(scheme):
    return f"{scheme}://{'' if scheme == 'tcp' else SECRET + '@'}{SERVER}:9000".encode()


def in_a_child(work):
    """In a process of its own: its network goes with it."""
    read, write = os.pipe()
    if (child := os.fork()) == 0:
        os.close(read)
        with os.fdopen(write, "w") as out:
            json.dump(work(), out)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as text:
        found = text.read()
    os.waitpid(child, 0)
    return json.loads(found)


def recorded(programs, stream, line, way, seed, viewers=1):
    network = Network(line, seed, receive)
    if way == "reno":
        pathlib.Path("/proc/sys/net/ipv4/tcp_congestion_control").write_text("reno")
    server = Server(programs, stream, f"{WAYS[way]}://{SERVER}:9000", "--patience", 60, "--per-address", viewers)
    network.begin()
    network.connection.send(f"{viewers} ".encode() + address(WAYS[way]))
    found = json.loads(network.connection.recv(1 << 22))
    server.wait("came")
    began, report = [at for at, event in server.events if event["event"] == "came"], server.end()
    network.close()
    return {**found, "began": began[0], "all_began": began, "bytes": report["bytes_sent"], "packets": network.carried + network.lost, "packets_lost": network.lost}


def write_trace(file, came, began):
    """The server sends the first sphere when a viewer has come, and each other one so much later as its time says. How late they came, in ms, once the
    first second is over."""
    write_whole(file, "time_s,arrival_s\n" + "".join(f"{due:.6f},{at - began + came[0][0]:.6f}\n" for due, at, _ in came))
    return lateness(came, began)


def lateness(came, began):
    late = sorted(1000 * ((at - began) - (due - came[0][0])) for due, at, _ in came if due >= came[0][0] + 1)
    return {"median": round(statistics.median(late), 1), "p95": round(late[int(0.95 * (len(late) - 1))], 1), "most": round(late[-1], 1)} if late else None


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
    rows, traces = [], {}
    for name, line in LINES.items():
        for way in options.ways.split(","):
            if way == "reno" and not options.other_bin:
                continue
            for seed in SEEDS:
                programs = options.other_bin if way == "reno" else options.bin
                found = in_a_child(lambda: recorded(programs, steps.work / "motion.mkv", line, way, seed))
                row = {"line": name, "way": way, "seed": seed, "spheres": len(found["came"]), "problem": found["problem"],
                       **{key: found[key] for key in ("bytes", "packets", "packets_lost")}}
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
    keep("lines", [*(row for row in kept if row["way"] not in options.ways.split(",")), *rows], f"lines by {options.ways}")


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
    steps.run("pavilion", "scene", "generate", "pavilion", "--out", "pavilion")
    rows = []
    for way in LIVE_WAYS:
        for seed in SEEDS:
            rows.append({"way": way, "seed": seed, **in_a_child(lambda: watched_live(options.bin, steps.work / "pavilion/pavilion.json", way, seed))})
            print({key: value for key, value in rows[-1].items() if key != "spheres"}, file=sys.stderr, flush=True)
    keep("live", rows)


def watched_live(programs, scene, way, seed):
    network = Network(Line(), seed, receive)
    server = Server(programs, scene, f"{way}://{SERVER}:9000", *LIVE, "--patience", 60)
    network.begin()
    began = time.monotonic()
    network.connection.send(address(way))
    carried = []
    for (at_s, mbit_s), (until_s, _) in zip(LIVE_SHARES, [*LIVE_SHARES[1:], (LIVE_S, 0)]):
        network.line = Line(mbit_s=mbit_s or carried[-1]["mbit_s"] / 10)
        before = network.bytes
        time.sleep(max(0, began + until_s - time.monotonic()))
        carried.append({"from_s": at_s, "line_mbit_s": network.line.mbit_s, "mbit_s": (network.bytes - before) * 8e-6 / (until_s - at_s)})
    report = server.end()
    found = json.loads(network.connection.recv(1 << 22))
    network.close()
    soonest = min(at - due for due, at, _ in found["came"])
    return {"line": carried, "report": report["live"], "spheres": [{"at_s": round(at - began, 3), "later_s": round(at - due - soonest, 3), "crf": crf} for due, at, crf in found["came"]],
            "problem": found["problem"]}


def viewed(programs, display, url):
    return subprocess.Popen([programs / "equistream-view", url, "--size", "320x180", "--json"], env=display.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def faults(options, steps, keep, kept):
    from display import Display
    make_inputs(steps)
    display, stream = Display(), steps.work / "motion.mkv"
    found = {"server killed, back after 2 s": [], "viewer killed": []}
    for _ in range(3):
        server = Server(options.bin, stream, "tcp://:0", "--loop")
        viewer = viewed(options.bin, display, server.url)
        server.wait("came")
        time.sleep(3)
        server.kill()
        time.sleep(2)
        server = Server(options.bin, stream, "tcp://:" + server.url.rsplit(":", 1)[1], "--loop")
        found["server killed, back after 2 s"].append({"back_to_connected_s": round(server.wait("came")[0] - server.began, 3)})
        time.sleep(2)
        killed = time.monotonic()
        viewer.kill()
        viewer.wait()
        found["viewer killed"].append({"noticed_s": round(server.wait("left", killed)[0] - killed, 3)})
        server.kill()
    display.close()
    found["line cut without a word"] = in_a_child(lambda: cut_off(options.bin, stream))
    keep("faults", found)


def cut_off(programs, stream):
    network = Network(Line(), 1, receive)
    server = Server(programs, stream, f"tcp://{SERVER}:9000", "--loop")
    network.begin()
    network.connection.send(address("tcp"))
    server.wait("came")
    time.sleep(3)
    network.line = Line(loss=1)
    cut = time.monotonic()
    dropped, why = server.wait("dropped")
    problem = json.loads(network.connection.recv(1 << 22))["problem"]
    result = {"viewer_gives_up_s": round(time.monotonic() - cut, 3), "it_says": problem.split(": ", 1)[-1], "server_gives_up_s": round(dropped - cut, 3), "server_says": why}
    server.kill()
    network.close()
    return result


def pose(options, steps, keep, kept):
    """The server's stages are its own report's; a viewer's head moves so that each picture tells when its pose was sent (live_viewer.cpp)."""
    steps.run("pavilion", "scene", "generate", "pavilion", "--out", "pavilion")
    server = Server(options.bin, steps.work / "pavilion/pavilion.json", "tcp://127.0.0.1:0", *LIVE)
    said = json.loads(subprocess.run([options.bin / "equistream_live_viewer", server.url, str(POSE_S)], check=True, capture_output=True, text=True).stdout)
    report = server.end()["live"]
    stages = {name: {key: round(times[key], 2) for key in ("p50", "p99")} | {"samples": times["samples"]} for name, times in report["stages_ms"].items()}
    shown = said["shown"]
    stages["pose to picture"] = spread([each["shown_s"] - each["sent_s"] for each in shown])
    keep("pose", {"stages_ms": stages, "decode_ms": said["decode_ms"], "render_ms": said["render_ms"], "playout_delay_ms": spread([each["playout_delay_s"] for each in shown]),
                  "spheres_per_s": report["spheres_per_s"], "spp": report["spp"]})


def spread(seconds):
    """Milliseconds, nearest ranks."""
    ranked = sorted(1000 * each for each in seconds)
    return {**{name: round(ranked[max(0, math.ceil(share * len(ranked)) - 1)], 2) for name, share in (("p50", 0.5), ("p99", 0.99))}, "samples": len(ranked)}


def decibels(mean_square):
    return -10 * math.log10(mean_square)


def span(values, digits=0):
    low, high = cell(min(values), digits), cell(max(values), digits)
    return low if low == high else f"{low} to {high}"


def line_rows(rows):
    """A line and a way each, of all seeds: how late spheres come, and what a viewer loses beside a line that loses nothing."""
    def of(line, way):
        return [row for row in rows if (row["line"], row["way"]) == (line, way) and row.get("late_ms")]

    def squares(found):
        return statistics.mean(row["mean_square"] for row in found)

    whole = squares(of("nothing lost", "tcp"))
    for line in LINES:
        for way in WAYS:
            if not (found := of(line, way)):
                continue
            is_scored = all("mean_square" in row for row in found)
            late = [span([row["late_ms"][key] for row in found]) for key in ("median", "p95", "most")]
            yield [line, way, cell(100 * sum(row["packets_lost"] for row in found) / sum(row["packets"] for row in found), 1), *late,
                   cell(round(decibels(whole) - decibels(squares(found)), 2) + 0.0) if is_scored else "-",
                   cell(statistics.mean(row["age_ms"]["mean"] for row in found), 0) if is_scored else "-"]


def page_rows(rows):
    for line in page_lines.LINES:
        found = [row for row in rows if row["line"] == line and "shown" in row]
        if found:
            yield [line, cell(100 * sum(row["packets_lost"] for row in found) / sum(row["packets"] for row in found), 1), span([row["first_picture_ms"] for row in found]),
                   span([row["shown"] for row in found]), *(span([row["later_ms"][key] for row in found]) for key in ("median", "p95", "most")),
                   *(span([row["between_refreshes_ms"][key] for row in found]) for key in ("median", "most"))]


def viewer_rows(rows):
    for row in rows:
        yield [row["way"], str(row["viewers"]), *(span([late[key] for late in row["late_ms"]]) for key in ("median", "p95", "most"))]


def live_rows(rows):
    """A way and a part of the line each, of all seeds."""
    ends_s = [*(from_s for from_s, _ in LIVE_SHARES[1:]), LIVE_S]
    for way in LIVE_WAYS:
        found = [row for row in rows if row["way"] == way]
        for i, ((from_s, _), end_s) in enumerate(zip(LIVE_SHARES, ends_s, strict=True)):
            parts = [[sphere for sphere in row["spheres"] if from_s <= sphere["at_s"] < end_s] for row in found]
            if not all(parts):
                yield [way, f"{from_s} s", *6 * ["-"]]
                continue
            settled = [[sphere for sphere in part if sphere["at_s"] >= from_s + SETTLED_S] or part[-1:] for part in parts]
            carried = [row["line"][i]["line_mbit_s"] for row in found]
            yield [way, f"{from_s} s", "no limit" if carried[0] > 1e6 else span(carried, 2), span([len(part) for part in parts]),
                   span([statistics.median(sphere["later_s"] for sphere in part) for part in parts], 2),
                   span([longest_gap(row["spheres"], from_s, end_s) for row in found], 1),
                   span([max(sphere["later_s"] for sphere in part) for part in settled], 2),
                   span([statistics.mean(sphere["crf"] for sphere in part) for part in settled])]


def longest_gap(spheres, from_s, end_s):
    """Without a new sphere, of that part of the time."""
    shown = [from_s, *(sphere["at_s"] for sphere in spheres if from_s <= sphere["at_s"] < end_s), end_s]
    return max(later - at for at, later in zip(shown, shown[1:]))


STAGES = {"pose": "at the server: a pose waits until a sphere is ordered", "render": "the sphere is rendered", "hand_over": "its file is written", "wait": "the encoder is not free yet",
          "encode": "it is coded", "all": "from a pose's coming to bytes that can be sent", "pose to picture": "from a pose's sending to both eyes' pictures"}


def pose_rows(found):
    rows = [[words, *(cell(found["stages_ms"][name][key], 1) for key in ("p50", "p99"))] for name, words in STAGES.items()]
    means = [[f"at the viewer, on average: {words}", cell(found[key], 1), "-"] for key, words in (("decode_ms", "decoding"), ("render_ms", "both eyes"))]
    return [*rows[:-1], *means, ["at the viewer: the play-out delay", *(cell(found["playout_delay_ms"][key], 1) for key in ("p50", "p99"))], rows[-1]]


def write_page(found, page):
    text = page.read_text()
    if "lines" in found:
        text = place(text, "lines", "stream", table(["line", "by", "packets lost, %", "spheres come late, median, ms", "95 %", "the latest", "lost to the viewer, dB", "age of what is seen, ms"],
                                                    line_rows(found["lines"])))
    if "page" in found:
        text = place(text, "page", "stream", table(["line", "packets lost, %", "first picture, ms", "spheres shown", "later, median, ms", "95 %", "the latest",
                                                    "between refreshes, median, ms", "at most"], page_rows(found["page"]), 1))
    if "drawing" in found:
        rows = [[row["size"], str(row["eyes"]), *(cell(row[key], 1) for key in ("median", "p95", "most"))] for row in found["drawing"]["times_ms"]]
        text = place(text, "drawing", "stream", table(["picture", "eyes", "milliseconds, median", "95 %", "the longest"], rows, 1))
    if "viewers" in found:
        text = place(text, "viewers", "stream", table(["by", "viewers", "spheres come late, median, ms", "95 %", "the latest"], viewer_rows(found["viewers"])))
    if "live" in found:
        text = place(text, "live", "stream", table(["by", "from", "the line carries, Mbit/s", "spheres", "later, median, s", "longest without one, s",
                                                    f"latest after {SETTLED_S} s", "CRF then"], live_rows(found["live"]), 2))
    if "pose" in found:
        text = place(text, "pose", "stream", table(["stage", "median, ms", "99 %, ms"], pose_rows(found["pose"]), 1))
    write_whole(page, text)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, help="folder of the built programs; without it only the tables are made again")
    parser.add_argument("--other-bin", type=pathlib.Path, help="the same, of a server that leaves congestion control to the system")
    parser.add_argument("--work", type=pathlib.Path, help="folder for renders and streams")
    parser.add_argument("--out", type=pathlib.Path, default=RESULT, help="JSON")
    parser.add_argument("--parts", default="lines,page,drawing,viewers,live,faults,pose", help="which of them")
    parser.add_argument("--ways", default=",".join(WAYS), help="of the lines; figures of others are kept")
    parser.add_argument("--page", type=pathlib.Path, default=PAGE, help="whose tables are made")
    options = parser.parse_args()
    if not options.bin:
        return write_page(json.loads(options.out.read_text()), options.page)
    options.bin = options.bin.resolve()
    options.work.mkdir(parents=True, exist_ok=True)
    steps = Steps(options.work.resolve(), options.bin, {}, {"sphere": SPHERE, "eyes": EYES, "seconds": SECONDS})
    kept = json.loads(options.out.read_text()) if options.out.exists() else {}

    def keep(part, found, made=None):
        kept.update({"command": "tests/study/network/streaming.py --bin BIN --work W --out docs/results/stream.json", part: found})
        kept.setdefault("provenance", {})[made or part] = provenance(options.bin, TESTS.parent)
        write_whole(options.out, result_text(kept))

    for part in options.parts.split(","):
        {"lines": lines, "page": page, "drawing": drawing, "viewers": viewers, "live": live, "faults": faults, "pose": pose}[part](options, steps, keep, kept.get(part, []))
    write_page(kept, options.page)


if __name__ == "__main__":
    run_as_program(main)
