"""A display without a screen, and a viewer on it that a program steers and looks at."""

import ctypes
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

import numpy as np
from PIL import Image

from independent import psnr_db, wait_until

PATIENCE_S = 120


def psnr(a, b):
    """Of pictures of bytes, as whatever numbers."""
    return psnr_db(a / 255, b / 255)


def wait_for(found, what):
    return wait_until(found, what, PATIENCE_S)


class Display:
    """Xvfb on a number that it finds itself; without the reset after its last client, when it turns away the next one."""

    def __init__(self):
        reading, writing = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", "800x600x24", "-nolisten", "tcp", "-noreset"], pass_fds=[writing],
                                       stderr=subprocess.DEVNULL)
        os.close(writing)
        with os.fdopen(reading) as number:
            self.name = ":" + number.readline().strip()
        self.config = tempfile.mkdtemp(prefix="equistream_config_")
        self.environment = {**os.environ, "DISPLAY": self.name, "WAYLAND_DISPLAY": "", "LIBGL_ALWAYS_SOFTWARE": "1", "XDG_CONFIG_HOME": self.config}

    def close(self):
        self.server.terminate()
        self.server.wait()
        shutil.rmtree(self.config, ignore_errors=True)

    def tool(self, *words):
        return subprocess.run(["xdotool", *map(str, words)], env=self.environment, capture_output=True, text=True, check=False).stdout.split()

    def set_property(self, window, name, kind, bits, content, count):
        """Of a window, or of the root where there is none."""
        x11 = ctypes.CDLL("libX11.so.6")
        x11.XOpenDisplay.restype = ctypes.c_void_p
        x11.XDefaultRootWindow.restype = ctypes.c_ulong
        connection = ctypes.c_void_p(x11.XOpenDisplay(self.name.encode()))
        window = ctypes.c_ulong(int(window) if window else x11.XDefaultRootWindow(connection))
        name, kind = (ctypes.c_ulong(x11.XInternAtom(connection, word, False)) for word in (name, kind))
        x11.XChangeProperty(connection, window, name, kind, bits, 0, content, count)
        x11.XCloseDisplay(connection)

    def set_iconic(self, window, is_iconic):
        """Says of a window that it is minimised, or shown, as a window manager does."""
        self.set_property(window, b"WM_STATE", b"WM_STATE", 32, (ctypes.c_long * 2)(3 if is_iconic else 1, 0), 2)

    def set_scale(self, scale):
        """Says what desktops say of a display whose pixels are so small."""
        resources = f"Xft.dpi:\t{round(96 * scale)}\n".encode()
        self.set_property(None, b"RESOURCE_MANAGER", b"STRING", 8, resources, len(resources))


class ViewerProcess:
    """`equistream view` with pictures going to `out`; what it keeps from one run to the next is in the folder `config`, none: it keeps nothing."""

    def __init__(self, display, program, out, *words, config=None):
        self.display, self.out, self.pictures = display, pathlib.Path(out), 0
        kept, environment = (["--no-config"], display.environment) if config is None else ([], {**display.environment, "XDG_CONFIG_HOME": str(config)})
        self.process = subprocess.Popen([str(word) for word in [program, "view", *words, *kept, "--out", out]], env=environment,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.window = wait_for(self.find_window, "the viewer's window")
        # Without a window manager the keyboard is whose the pointer is over. Between menu bar and timeline.
        display.tool("mousemove", 20, 40)
        display.tool("windowfocus", self.window)

    def find_window(self):
        if self.process.poll() is not None:
            raise AssertionError(f"the viewer ended: {self.process.stderr.read()}")
        found = self.display.tool("search", "--pid", self.process.pid, "--onlyvisible", "--name", "equistream")
        return found[0] if found else None

    def press(self, *keys):
        for key in keys:
            self.display.tool("key", key)

    def hold(self, key, seconds):
        self.display.tool("keydown", key)
        time.sleep(seconds)
        self.display.tool("keyup", key)

    def picture(self):
        """What the window shows, without what is written over it, as the key for it keeps it."""
        self.pictures += 1
        file = self.out / f"view.{self.pictures:04}.png"
        self.press("p")
        wait_for(file.exists, file)
        return np.asarray(Image.open(file).convert("RGB")).astype(float)

    def resting_picture(self):
        """Once the head, which is foretold to go on for a moment, stays where it is."""
        seen = [self.picture()]

        def same_again():
            seen.append(self.picture())
            return seen[-1] if seen[-1].shape == seen[-2].shape and (seen[-1] == seen[-2]).all() else None

        return wait_for(same_again, "a view that rests")

    def screen(self):
        """What is on the display."""
        width, height = (int(n) for n in self.display.tool("getdisplaygeometry"))
        raw = subprocess.run(["ffmpeg", "-v", "error", "-f", "x11grab", "-draw_mouse", "0", "-video_size", f"{width}x{height}", "-i", self.display.name,
                              "-frames:v", "1", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], env=self.display.environment, capture_output=True, check=True)
        return np.frombuffer(raw.stdout, np.uint8).reshape(height, width, 3).astype(float)

    def end(self):
        """Exit status and what was said on stderr; what was printed is in `printed`."""
        self.printed, said = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, said

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()
