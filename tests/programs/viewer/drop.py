"""Drags a file onto a window and drops it, as a file manager does (the XDND protocol, version 5)."""

import ctypes
import pathlib
import time

CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31
VERSION = 5
Event = ctypes.c_long * 24
"""Of all kinds: type, serial number, whether it was sent, display; then what is the kind's own."""


class Dragging:
    def __init__(self, display_name, window, patience_s):
        self.x11 = ctypes.CDLL("libX11.so.6")
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        for name in ("XDefaultRootWindow", "XCreateSimpleWindow", "XInternAtom"):
            getattr(self.x11, name).restype = ctypes.c_ulong
        self.connection = ctypes.c_void_p(self.x11.XOpenDisplay(display_name.encode()))
        root = ctypes.c_ulong(self.x11.XDefaultRootWindow(self.connection))
        self.own = self.x11.XCreateSimpleWindow(self.connection, root, 0, 0, 1, 1, 0, ctypes.c_ulong(0), ctypes.c_ulong(0))
        self.window, self.until = int(window), time.monotonic() + patience_s

    def atom(self, name):
        return self.x11.XInternAtom(self.connection, name.encode(), False)

    def send(self, to, event):
        self.x11.XSendEvent(self.connection, ctypes.c_ulong(to), False, ctypes.c_long(0), ctypes.byref(event))
        self.x11.XFlush(self.connection)

    def tell(self, name, *data):
        self.send(self.window, Event(CLIENT_MESSAGE, 0, 1, 0, self.window, self.atom(name), 32, self.own, *data))

    def next(self, what):
        """The next event that is sent to us."""
        event = Event()
        while not self.x11.XPending(self.connection):
            assert time.monotonic() < self.until, f"{what} did not come"
            time.sleep(0.01)
        self.x11.XNextEvent(self.connection, ctypes.byref(event))
        return event[0] & 0xffffffff, event

    def told(self, name):
        """The data of a message of this name; others are passed over, and who asks for the file's name gets it."""
        while True:
            kind, event = self.next(name)
            if kind == SELECTION_REQUEST:
                self.answer(event)
            elif kind == CLIENT_MESSAGE and event[5] == self.atom(name):
                return event[7:12]

    def answer(self, request):
        _, requestor, selection, target, named, at = request[4:10]
        self.x11.XChangeProperty(self.connection, ctypes.c_ulong(requestor), ctypes.c_ulong(named), ctypes.c_ulong(target), 8, 0, self.names, len(self.names))
        self.send(requestor, Event(SELECTION_NOTIFY, 0, 1, 0, requestor, selection, target, named, at))

    def drop(self, file, x, y):
        """Whether the window took it."""
        self.names = f"{pathlib.Path(file).as_uri()}\r\n".encode()
        self.x11.XSetSelectionOwner(self.connection, ctypes.c_ulong(self.atom("XdndSelection")), ctypes.c_ulong(self.own), ctypes.c_ulong(0))
        self.tell("XdndEnter", VERSION << 24, self.atom("text/uri-list"), 0, 0)
        self.tell("XdndPosition", 0, x << 16 | y, 0, self.atom("XdndActionCopy"))
        if not self.told("XdndStatus")[1] & 1:
            return False
        self.tell("XdndDrop", 0, 0, 0, 0)
        return bool(self.told("XdndFinished")[1] & 1)

    def close(self):
        self.x11.XCloseDisplay(self.connection)
