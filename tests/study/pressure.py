#!/usr/bin/env python3
"""What others may do to a server, and how much later a viewer's pictures come for it.

usage: pressure.py BIN_DIR --report FILE [--seconds 15]

A recorded stream is served over and over. One viewer notes when each block of bytes comes: alone, beside one kind of pressure, alone again, beside the
next. *Slower* is the time that the same bytes took, beside the mean of the runs alone before and after, which are *alone_apart* from each other. *Latest*
is how much later than in both of them the latest block came, counted from the first byte. Those who press run in a process of their own, on the same machine: they have one half of its cores, and
the server has the other.

Then a scene is rendered while it is watched, and the viewer, who steers, notes when each sphere comes. *Slower* is the time of as many spheres.

One pressure is none: those who press do the same to a server of their own. What is slower beside that is the machine's doing. So is what a renderer takes
longer for a sphere in processor time, its own; what the server's process takes is noted too.
"""

import argparse
import contextlib
import json
import multiprocessing
import os
import pathlib
import selectors
import socket
import subprocess
import sys
import tempfile
import threading
import time

TESTS = pathlib.Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "programs"), str(TESTS / "programs/live"), str(TESTS.parent / "programs/study")]
from live_server import LiveServer, pose_message  # noqa: E402
from steps import provenance, write_whole  # noqa: E402

VIEWERS, BLOCK = 8, 1 << 15
LIVE = ("--size", "256x128", "--spp", 1)
CORES = sorted(os.sched_getaffinity(0))
HALVES = set(CORES[:max(1, len(CORES) // 2)]), set(CORES[len(CORES) // 2:])
CLUSTER = bytes.fromhex("1f43b675")  # of Matroska: a sphere, live
POSES = pose_message((0, 0, 0)) * 64
GIANT = b"EQVM" + b"\x01\x00\x01\x00" + (0xFFFFFFFF).to_bytes(4, "little") + b"\xff" * 4096


# What those who press have done: connections, bytes sent. Theirs is another process.
done = multiprocessing.Array("q", 2)


def connected(port):
    with contextlib.suppress(OSError):
        one = socket.create_connection(("127.0.0.1", port), timeout=5)
        done[0] += 1
        return one
    return None


def keep(port, number, step):
    """So many connections; whoever was dropped comes again. `step` is what each does in turn."""
    here = []
    while True:
        here += filter(None, (connected(port) for _ in range(number - len(here))))
        for one in list(here):
            one.setblocking(False)
            try:
                gone = step(one)
            except (BlockingIOError, InterruptedError):
                gone = False
            except OSError:
                gone = True
            if gone:
                one.close()
                here.remove(one)
        time.sleep(0.05)


def closed(one, wanted):
    return len(one.recv(wanted)) == 0


def silent(port):
    """500 that neither read nor send. Those that are refused or dropped come again."""
    def step(one):
        return len(one.recv(1, socket.MSG_PEEK)) == 0

    keep(port, 500, step)


def elsewhere(port):
    """The same to a server of their own, which closes whatever comes: nobody comes to the one that is measured."""
    own = socket.create_server(("127.0.0.1", 0), backlog=500)

    def close_all():
        while True:
            own.accept()[0].close()

    threading.Thread(target=close_all, daemon=True).start()
    silent(own.getsockname()[1])


def slow(port):
    """As many as there are places, which read 20 kB a second."""
    keep(port, VIEWERS - 1, lambda one: closed(one, 1000))


def come_and_go(port):
    """One after another, as fast as they can."""
    while True:
        one = connected(port)
        if one is not None:
            one.close()


def talk(port, message):
    """As many as there are places, which read all and send all that goes through."""
    selector = selectors.DefaultSelector()
    here, unsent = 0, {}
    while True:
        while here < VIEWERS - 1 and (one := connected(port)) is not None:
            one.setblocking(False)
            selector.register(one, selectors.EVENT_READ | selectors.EVENT_WRITE)
            here += 1
        for key, events in selector.select(1):
            try:
                if events & selectors.EVENT_READ and closed(key.fileobj, 1 << 18):
                    raise ConnectionResetError
                if events & selectors.EVENT_WRITE:
                    left = unsent.get(key.fd) or message
                    sent = key.fileobj.send(left)
                    unsent[key.fd] = left[sent:]
                    done[1] += sent
            except BlockingIOError:
                pass
            except OSError:
                selector.unregister(key.fileobj)
                unsent.pop(key.fd, None)
                key.fileobj.close()
                here -= 1


def poses(port):
    talk(port, POSES)


def giants(port):
    talk(port, GIANT)


def pressed(pressure, port):
    os.sched_setaffinity(0, HALVES[1])
    pressure(port)


PRESSURES = {"500 connections to another server": elsewhere, "500 connections that say and read nothing": silent, "7 that read slowly": slow, "connections that come and go": come_and_go,
             "7 that send heads without end": poses, "7 that send giant messages": giants}


def processor_s(process):
    """That it has used so far, with those of its children that have ended."""
    return sum(map(int, pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[11:15])) / os.sysconf("SC_CLK_TCK")


def used(server, is_live):
    return {"server_s": processor_s(server.process.pid)} | ({"renderer_s": processor_s(server.renderer())} if is_live else {})


def arrivals(server, seconds, is_live, pressure=None):
    """(seconds since the first byte, bytes) of each read, and the processor time that went by. Pressure begins once the viewer has its place and steers."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=30) as viewer:
        viewer.sendall(pose_message((0, 0, 0)))
        viewer.recv(1, socket.MSG_PEEK)
        found, first, before = [], time.monotonic(), used(server, is_live)
        done[:] = 0, 0
        others = multiprocessing.Process(target=pressed, args=(pressure, server.port), daemon=True) if pressure else None
        if others:
            others.start()
        try:
            while not found or found[-1][0] < seconds:
                got = viewer.recv(BLOCK)
                if not got:
                    raise RuntimeError("the server closed the connection of the viewer that is measured")
                found.append((time.monotonic() - first, got))
            after = used(server, is_live)
            if others and not others.is_alive():
                raise RuntimeError(f"{pressure.__name__}: those who press have ended")
        finally:
            if others:
                others.kill()
                others.join()
    return found, {name: after[name] - before[name] for name in after}


def block_times(found):
    """When each block was there."""
    size, at = 0, []
    for seconds, got in found:
        size += len(got)
        at += [seconds] * (size // BLOCK - len(at))
    return at


def sphere_times(found):
    """When each began to come."""
    before, at = b"", []
    for seconds, got in found:
        at += [seconds] * (before + got).count(CLUSTER)
        before = (before + got)[1 - len(CLUSTER):]
    return at


def beside(before, other, after):
    both = min(map(len, (before, other, after))) - 1
    alone_s = (before[both] + after[both]) / 2
    return {"blocks": both, "slower": round(other[both] / alone_s - 1, 5), "alone_apart": round(abs(after[both] - before[both]) / alone_s, 5),
            "latest_ms": round(1000 * max(b - max(a, c) for a, b, c in zip(before, other, after)), 1)}


def measured(server, seconds, times, is_live):
    """Each pressure between two runs without any, by which a machine or a scene that changes does not pass for one."""
    def run(pressure=None):
        """When blocks or spheres came, and processor time of each of them."""
        found, taken = arrivals(server, seconds, is_live, pressure)
        at = times(found)
        return at, {name: value / len(at) for name, value in taken.items()}

    before, taken_before = run()
    found = {}
    for name, pressure in PRESSURES.items():
        (at, taken), counts = run(pressure), {"connections": done[0], "sent_mb": round(done[1] / 1e6, 1)}
        time.sleep(2)  # all have gone
        after, taken_after = run()
        alone = {key: (taken_before[key] + taken_after[key]) / 2 for key in taken}
        found[name] = beside(before, at, after) | counts | {f"{key.removesuffix('_s')}_ms_each": [round(1000 * alone[key], 3), round(1000 * taken[key], 3)] for key in taken}
        print(name, found[name], flush=True)
        before, taken_before = after, taken_after
    return found


@contextlib.contextmanager
def served(*words):
    os.sched_setaffinity(0, HALVES[0])  # the server has what we have when it begins
    server = LiveServer(*words)
    os.sched_setaffinity(0, CORES)
    try:
        yield server
    finally:
        server.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bin", type=pathlib.Path, help="folder of the built programs")
    parser.add_argument("--report", required=True, type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=15, help="of each run")
    options = parser.parse_args()
    program = options.bin.resolve() / "equistream"
    with tempfile.TemporaryDirectory() as work:
        def run(*words):
            subprocess.run([program, *map(str, words)], cwd=work, check=True, stdout=subprocess.DEVNULL)

        run("scene", "generate", "pavilion", "--out", "scenes")
        run("render", "scenes/pavilion.json", "--frames", "0-29", "--size", "1024x512", "--spp", 1, "--aovs", "depth", "--progress", "none", "--out", "frames")
        run("encode", "frames", "--out", "served.mkv", "--crf", 20, "--progress", "none")
        with served(program, pathlib.Path(work) / "served.mkv", work, "--loop", "--viewers", VIEWERS) as server:
            found = measured(server, options.seconds, block_times, False)
        with served(program, pathlib.Path(work) / "scenes/pavilion.json", work, *LIVE, "--viewers", VIEWERS) as server:
            live = measured(server, options.seconds, sphere_times, True)
    write_whole(options.report, json.dumps({"command": f"tests/study/pressure.py BIN --seconds {options.seconds:g}", **provenance(options.bin.resolve(), TESTS.parent), "pressures": found, "live": live}, indent=1) + "\n")


if __name__ == "__main__":
    main()
