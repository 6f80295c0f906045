"""A network between two network namespaces: packets are lost, late, out of order or too many for it, all by a seed.

Linux's own (tc netem) is not in every kernel. Here each namespace has a TUN device, and a thread carries packets from one to the other, so TCP, UDP
and what is built on them behave as they do on a real line. It needs root.
"""

import ctypes
import dataclasses
import fcntl
import heapq
import os
import random
import select
import socket
import struct
import subprocess
import threading
import time

CLONE_NEWNET = 0x40000000
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 1, 0x1000
SERVER, CLIENT = "10.77.0.1", "10.77.0.2"
MTU = 1500


@dataclasses.dataclass(frozen=True)
class Line:
    """One way and the other alike."""
    loss: float = 0  # of packets, each for itself
    delay_s: float = 0.02
    jitter_s: float = 0  # up to so much more, so that packets overtake each other
    mbit_s: float = 100
    queue_s: float = 0.2  # of packets that wait; more are lost
    silent: tuple = ()  # from and to: nothing is carried then, in seconds since begin()


def new_network():
    if ctypes.CDLL(None, use_errno=True).unshare(CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), "a network namespace cannot be made (root is needed)")


def open_tun(own, other):
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, TUNSETIFF, struct.pack("16sH22x", b"line", IFF_TUN | IFF_NO_PI))
    for command in (f"ip link set lo up", f"ip addr add {own} peer {other} dev line", f"ip link set line mtu {MTU} up"):
        subprocess.run(command.split(), check=True)
    return tun


class Network:
    """This process and its children are the server's side. `client` is a process on the other side that runs what it is told."""

    def __init__(self, line, seed, run_client):
        """`run_client(connection)` runs in a process of its own, on the client's side; `connection` is a socket to here."""
        new_network()
        self.line, self.random = line, random.Random(seed)
        self.carried, self.lost, self.bytes, self.began = 0, 0, 0, 0.0
        self.sent_bytes = [0, 0]  # by the server and by the client; packets that are lost too
        self.ends = [open_tun(SERVER, CLIENT), None]
        self.connection, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.client = os.fork()
        if self.client == 0:
            self.connection.close()
            new_network()
            tun = open_tun(CLIENT, SERVER)
            socket.send_fds(theirs, [b"tun"], [tun])
            os.close(tun)
            run_client(theirs)
            os._exit(0)
        theirs.close()
        _, fds, _, _ = socket.recv_fds(self.connection, 16, 1)
        self.ends[1] = fds[0]
        self.free_at = [0.0, 0.0]
        threading.Thread(target=self.carry, daemon=True).start()

    def begin(self):
        """From now on the line's times count."""
        self.began = time.monotonic()

    def carry(self):
        waiting, number = [], 0
        while True:
            now = time.monotonic()
            while waiting and waiting[0][0] <= now:
                _, _, end, packet = heapq.heappop(waiting)
                try:
                    os.write(end, packet)
                except OSError:
                    pass
            timeout = min(1.0, waiting[0][0] - now) if waiting else 1.0
            for end in select.select(self.ends, [], [], timeout)[0]:
                way = self.ends.index(end)
                for _ in range(64):
                    try:
                        packet = os.read(end, MTU + 100)
                    except BlockingIOError:
                        break
                    number += 1
                    if (due := self.due(way, len(packet))) is not None:
                        heapq.heappush(waiting, (due, number, self.ends[1 - way], packet))

    def due(self, way, size):
        """When the packet is at the other end; None: it is lost."""
        line, now = self.line, time.monotonic()
        self.sent_bytes[way] += size
        starts = max(now, self.free_at[way])
        if line.silent and line.silent[0] <= now - self.began < line.silent[1]:
            self.lost += 1
            return None
        if starts - now > line.queue_s or self.random.random() < line.loss:
            self.lost += 1
            return None
        self.carried += 1
        self.bytes += size
        self.free_at[way] = starts + size * 8 / (line.mbit_s * 1e6)
        return self.free_at[way] + line.delay_s + line.jitter_s * self.random.random()

    def close(self):
        self.connection.close()
        os.waitpid(self.client, 0)
