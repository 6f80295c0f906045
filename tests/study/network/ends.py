"""The two ends of a line: `equistream serve` on this side, and on the other viewers by the Python package that note when each sphere is there, decoded."""

import json
import os
import signal
import subprocess
import sys
import threading
import time

from emulated import SERVER
from steps import Failed

SECRET = "a-secret-for-a-measurement"


def receive(connection):
    """On the other side: reads streams, and says when each sphere was decoded, by the clock that both sides have. Of windows and tiles it says the same for
    each sphere's last one, how many it had, and of how many pixels together.
    """
    import equistream

    while asked := connection.recv(1000).decode():
        *viewers, url = asked.split()
        others = [reading(url) for _ in range(int(viewers[0]) - 1)] if viewers else []
        came, windows, problem = [], {}, None
        try:
            stream = equistream.open_stream(url)
            for picture in stream:
                at = time.monotonic()
                if picture.role == "main":
                    came.append((picture.info.time_s, at, picture.info.crf))
                elif picture.role == "window" and picture.info:
                    time_s = round(picture.info.time_s, 4)
                    before = windows.get(time_s, (0, 0, 0, 0))
                    windows[time_s] = (at, picture.info.crf, before[2] + 1, before[3] + picture.info.camera.width * picture.info.camera.height)
            problem = stream.truncation or None
        except Exception as error:  # what went wrong is a finding too
            problem = str(error)
        others_came = [json.loads(other.stdout.read()) for other in others]
        found = {"came": came, "windows": [(time_s, *last) for time_s, last in windows.items()], "problem": problem, "others": others_came}
        connection.send(json.dumps(found).encode())


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
