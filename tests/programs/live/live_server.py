"""A live server and its viewers, with messages and depth read and written as docs/stream-format.md has them."""

import json
import math
import os
import pathlib
import signal
import socket
import struct
import subprocess
import threading

import numpy as np

from independent import wait_until

PATIENCE_S = 240


def wait_for(found, what):
    return wait_until(found, what, PATIENCE_S)


def still_scene(programs, folder):
    """A bundled scene whose own path stands still, and where."""
    scene = programs.scene("pavilion", folder)
    description = json.loads(scene.read_text())
    description["camera"]["keys"] = description["camera"]["keys"][:1]
    scene.write_text(json.dumps(description))
    return scene, np.array(description["camera"]["keys"][0]["position_m"])


def pose_message(position, orientation=(1, 0, 0, 0), version=1, kind=1, length=64):
    return b"EQVM" + struct.pack("<HHI8d", version, kind, length, 0.0, *position, *orientation)


class LiveServer:
    def __init__(self, program, scene, folder, *words, port=0, stderr=None):
        folder = pathlib.Path(folder)
        self.log = folder / "server.log"
        with self.log.open("w") as log:
            self.process = subprocess.Popen([str(w) for w in [program, "serve", scene, "--listen", f"tcp://:{port}", *words]], stdout=subprocess.PIPE,
                                            stderr=stderr or log, text=True, env={**os.environ, "TMPDIR": str(folder)})
        first = self.process.stdout.readline()
        if "tcp://127.0.0.1:" not in first:
            self.close()
            raise AssertionError(f"found '{first}' and: {self.log.read_text()}")
        self.url = json.loads(first)["listening"] if first.startswith("{") else first.removeprefix("listening on ").strip()
        self.port = int(self.url.rsplit(":", 1)[1])

    def renderer(self):
        """Its process id."""
        children = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        assert len(children) == 1, children
        return int(children[0])

    def end(self, number=signal.SIGTERM):
        """Exit status and what it printed."""
        self.process.send_signal(number)
        printed, _ = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, printed

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()


class Viewer:
    """Reads all that comes, in a thread."""

    def __init__(self, server):
        self.socket = socket.create_connection(("127.0.0.1", server.port))
        self.bytes = b""
        self.ended = False
        self.thread = threading.Thread(target=self.read, daemon=True)
        self.thread.start()

    def read(self):
        try:
            while block := self.socket.recv(65536):
                self.bytes += block
        except OSError:
            pass
        self.ended = True

    def send(self, message):
        self.socket.sendall(message)

    def clusters(self):
        return self.bytes.count(b"\x1f\x43\xb6\x75")

    def wait_for_more(self, clusters):
        wanted = self.clusters() + clusters
        wait_for(lambda: self.clusters() >= wanted or self.ended, f"{wanted} clusters")
        if self.clusters() < wanted:
            raise AssertionError(f"the stream ended after {self.clusters()} clusters, expected {wanted}")

    def leave(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()
        self.thread.join()

    def wait_for_end(self):
        wait_for(lambda: self.ended, "the stream's end")
        self.socket.close()


class Received:
    """What equistream info and FFmpeg say of a viewer's bytes."""

    def __init__(self, programs, data, folder):
        self.file = pathlib.Path(folder) / "received.mkv"
        self.file.write_bytes(data)
        said = json.loads(programs.run("info", "--frames", "--json", self.file))
        self.whole, self.truncation = said["whole"], said["truncation"]
        self.tracks = {track["name"]: track for track in said["tracks"]}
        self.frames = self.tracks["main"]["frames"]

    def heads(self):
        return np.array([frame["head"]["position_m"] for frame in self.frames])

    def hashes(self, track):
        """Of each decoded picture."""
        lines = self.decoded(track, "-f", "framemd5").decode().splitlines()
        return [line.split(",")[-1].strip() for line in lines if not line.startswith("#")]

    def decoded(self, track, *words):
        return subprocess.run(["ffmpeg", "-v", "error", "-i", self.file, "-map", f"0:{track}", "-fps_mode", "passthrough", *words, "-"], capture_output=True,
                              check=True).stdout

    def depths_m(self):
        """Of each frame, from w10 samples: x = (near - B) / (r - B)."""
        track = self.tracks["depth"]
        samples = np.frombuffer(self.decoded(1, "-pix_fmt", "gray10le", "-f", "rawvideo"), "<u2").reshape(-1, track["height"], track["width"])
        depths = []
        for picture, frame in zip(samples, track["frames"], strict=True):
            code = frame["depth_code"]
            with np.errstate(divide="ignore"):
                depths.append(code["box_radius_m"] + (code["near_m"] - code["box_radius_m"]) / (picture / 1023))
        return depths


def is_alive(process):
    try:
        return "Z" not in pathlib.Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return False


def turned(yaw_rad):
    return (math.cos(yaw_rad / 2), 0, math.sin(yaw_rad / 2), 0)
