#!/usr/bin/env python3
"""How late pictures come through a network that loses packets, by each transport.

usage: loss.py --bin BIN_DIR --work FOLDER --out FILE [--seeds 1 2] [--only NAMES]

`equistream serve` sends a recorded walk of the pavilion in time with its frames. On the other side of an emulated line (emulated.py) Python's client
reads and decodes it. A picture is late by how much later it is decoded than its time says, both counted from the first picture. The first picture's own
time is counted from when the client began.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import time

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS.parent / "programs/study"), str(pathlib.Path(__file__).resolve().parent)]
from emulated import SERVER, Line, Network  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

SECRET = "a-secret-for-a-measurement"
TRANSPORTS = ("tcp", "tls", "srt")
LINES = {
    "no loss": Line(),
    "1 % lost": Line(loss=0.01),
    "5 % lost": Line(loss=0.05),
    "10 % lost": Line(loss=0.1),
    "20 % lost": Line(loss=0.2),
    "200 ms of jitter": Line(jitter_s=0.2),
    "5 % lost, 200 ms of jitter": Line(loss=0.05, jitter_s=0.2),
}
FRAMES = 149  # of the walk, 30 a second
COMMAND = "tests/study/network/loss.py --bin BIN --work FOLDER --out docs/results/loss.json"


def make_walk(work):
    stream = work / "walk.mkv"
    if not stream.exists():
        subprocess.run(["equistream", "scene", "generate", "pavilion", "--out", work / "scene"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["equistream", "render", work / "scene/pavilion.json", "--size", "640x320", "--spp", "4", "--frames", f"0-{FRAMES - 1}", "--out", work / "frames",
                        "--progress", "none"], check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["equistream", "encode", work / "frames", "--out", stream, "--crf", "20", "--depth", "w10", "--progress", "none"], check=True,
                       stdout=subprocess.DEVNULL)
    return stream


def client(connection):
    """Reads what it is told to, and says when each picture of main came."""
    import equistream

    while url := connection.recv(1000).decode():
        start, came = time.monotonic(), []
        try:
            for picture in equistream.Stream(url):
                if picture.role == "main":
                    came.append((picture.info.time_s, time.monotonic() - start))
            connection.send(json.dumps({"came": came}).encode())
        except Exception as error:  # what went wrong is a figure too
            connection.send(json.dumps({"came": came, "problem": str(error)}).encode())


def figures(found):
    came = found["came"]
    if not came:
        return {"pictures": 0, "problem": found.get("problem")}
    late = sorted((at - came[0][1]) - (due - came[0][0]) for due, at in came)
    return {"pictures": len(came), "of": FRAMES, "first_s": round(came[0][1], 3),
            "late_ms": {name: round(1e3 * value, 1) for name, value in
                        (("median", statistics.median(late)), ("p99", late[int(0.99 * (len(late) - 1))]), ("most", late[-1]))},
            **({"problem": found["problem"]} if "problem" in found else {})}


def measured(bin_dir, stream, line, transport, seed):
    """In a process of its own: its network goes with it."""
    network = Network(line, seed, client)
    server = subprocess.Popen([bin_dir / "equistream-serve", stream, "--listen", f"{transport}://{SERVER}:9000", "--open", "--progress", "none",
                               "--patience", "60"],
                              stdout=subprocess.PIPE, text=True, env=dict(os.environ, EQUISTREAM_SECRET=SECRET))
    server.stdout.readline()
    secret = "" if transport == "tcp" else SECRET + "@"
    network.connection.send(f"{transport}://{secret}{SERVER}:9000".encode())
    found = json.loads(network.connection.recv(1 << 20))
    server.terminate()
    server.wait()
    result = {**figures(found), "packets": network.carried + network.lost, "packets_lost": network.lost}
    network.close()
    return result


def in_a_child(work):
    read, write = os.pipe()
    if (child := os.fork()) == 0:
        os.close(read)
        with os.fdopen(write, "w") as out:
            json.dump(work(), out)
        os._exit(0)
    os.close(write)
    with os.fdopen(read) as text:
        result = json.load(text)
    os.waitpid(child, 0)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--only", nargs="+", choices=LINES, default=list(LINES))
    a = parser.parse_args()
    os.environ["PATH"] = f"{a.bin.resolve()}:{os.environ['PATH']}"
    a.work.mkdir(parents=True, exist_ok=True)
    stream = make_walk(a.work)
    rows = []
    for name in a.only:
        for transport in TRANSPORTS:
            for seed in a.seeds:
                rows.append({"line": name, "transport": transport, "seed": seed,
                             **in_a_child(lambda: measured(a.bin, stream, LINES[name], transport, seed))})
                print(rows[-1], file=sys.stderr, flush=True)
                write_whole(a.out, json.dumps({"command": COMMAND, **provenance(a.bin.resolve(), TESTS.parent), "stream_bytes": stream.stat().st_size, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
