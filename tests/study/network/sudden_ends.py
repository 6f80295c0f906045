"""A server, a viewer and a line that end without a word, and ends that are of another version."""

import contextlib
import json
import socket
import subprocess
import time

from conditions import LIVE
from emulated import SERVER, Line, Network
from ends import Server, address, in_a_child, receive
from steps import Failed

RUNS = 3
FRAME_DATA = bytes.fromhex("69c4803651334784" "8093ec66a7475119")
"""docs/stream-format.md: a version of two bytes follows."""
CLUSTER = b"\x1f\x43\xb6\x75"
"""Of Matroska: of a live stream each sphere has one."""
TALKS_S = 5
PATIENCE_S = 60


def measured(programs, stream, scene):
    """`stream` is recorded. `scene` is served live."""
    from display import Display
    display = Display()
    found = {"server killed, back after 2 s": [], "viewer killed": [], "stream of a later version": []}
    later = of_later_version(stream)
    for _ in range(RUNS):
        back, noticed = killed(programs, display, stream)
        found["server killed, back after 2 s"].append(back)
        found["viewer killed"].append(noticed)
        found["stream of a later version"].append(refused(programs, display, later))
    display.close()
    found["line cut without a word"] = in_a_child(lambda: cut_off(programs, stream))
    found["messages of a later version"] = passed_over(programs, scene)
    return found


def viewed(programs, display, url, **out):
    return subprocess.Popen([programs / "equistream-view", url, "--size", "320x180", "--json"], env=display.environment, text=True,
                            **{"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, **out})


def killed(programs, display, stream):
    server = Server(programs, stream, "tcp://:0", "--loop")
    viewer = viewed(programs, display, server.url)
    server.wait("came")
    time.sleep(3)
    server.kill()
    time.sleep(2)
    server = Server(programs, stream, "tcp://:" + server.url.rsplit(":", 1)[1], "--loop")
    back = {"back_to_connected_s": round(server.wait("came")[0] - server.began, 3)}
    time.sleep(2)
    killed_at = time.monotonic()
    viewer.kill()
    viewer.wait()
    noticed = {"noticed_s": round(server.wait("left", killed_at)[0] - killed_at, 3)}
    server.kill()
    return back, noticed


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


def of_later_version(stream):
    """The same file, but all its frame data say the next version. A server does not read them."""
    known, later = (FRAME_DATA + version.to_bytes(2, "little") for version in (1, 2))
    data = stream.read_bytes()
    if known not in data:
        raise Failed(f"{stream.name}: expected frame data of version 1, found none")
    changed = stream.with_name("later.mkv")
    changed.write_bytes(data.replace(known, later))
    return changed


def refused(programs, display, stream):
    """From when the server lets the viewer in to when the viewer has ended."""
    server = Server(programs, stream, "tcp://:0")
    viewer = viewed(programs, display, server.url, stderr=subprocess.PIPE)
    came, _ = server.wait("came")
    try:
        _, said = viewer.communicate(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        viewer.kill()
        raise Failed(f"view: expected it to end at a later version, and it has not within {PATIENCE_S} s") from None
    result = {"ended_s": round(time.monotonic() - came, 3), "status": viewer.returncode, "it_says": said.strip().splitlines()[-1].split(f"{server.url}: ", 1)[-1]}
    server.kill()
    return result


def passed_over(programs, scene):
    """A viewer that says where its head is by messages of the next version, and once by one of today's."""
    from live_server import pose_message
    place = json.loads(scene.read_text())["camera"]["keys"][0]["position_m"]
    server = Server(programs, scene, "tcp://127.0.0.1:0", *LIVE)
    came, sent = b"", 0
    with socket.create_connection(("127.0.0.1", int(server.url.rsplit(":", 1)[1]))) as line:
        line.settimeout(0.1)
        until = time.monotonic() + TALKS_S
        while time.monotonic() < until:
            line.sendall(pose_message(place, version=2))
            sent += 1
            with contextlib.suppress(TimeoutError):
                came += line.recv(1 << 20)
        line.sendall(pose_message(place))
        time.sleep(1)
        report = server.end()
    return {"messages": sent + 1, "spheres": came.count(CLUSTER), "poses_heard": report["live"]["poses"]}
