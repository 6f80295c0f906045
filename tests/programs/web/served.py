"""`serve --web` and the page that it hands out."""

import contextlib
import hashlib
import http.client
import json
import math
import os
import pathlib
import re
import socket
import ssl
import struct
import subprocess
import time

import numpy as np

from page import FRAMES, PROGRAMS, Web, multiplied, rotated, share_alike, turned
from independent import wait_until


class Serve(Web):
    """`serve --web` hands out the page, streams to it, and hears where its head is."""

    def serve(self, *words, web="0", stderr=None):
        server = subprocess.Popen([PROGRAMS.folder / "equistream", "serve", *map(str, words), "--web", web, "--json",
                                   "--progress", "none"], stdout=subprocess.PIPE, stderr=stderr, text=True)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        self.said_first = json.loads(server.stdout.readline())
        return server, self.said_first["web"]

    def end(self, server):
        server.terminate()
        return json.loads(server.stdout.read().splitlines()[-1])

    def connected(self, url, **buffers):
        """To the server; the connection stays."""
        host, port = url.removeprefix("http://").rstrip("/").split(":")
        connection = socket.socket()
        self.addCleanup(connection.close)
        connection.settimeout(30)
        for name, size in buffers.items():
            connection.setsockopt(socket.SOL_SOCKET, getattr(socket, name), size)
        connection.connect((host, int(port)))
        return connection

    def asking(self, url, **buffers):
        """For an upgrade, as the server's page does."""
        connection = self.connected(url, **buffers)
        host = url.removeprefix("http://").rstrip("/")
        connection.sendall(f"GET /stream HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
                           "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode())
        return connection

    def test_a_recording(self):
        server, url = self.serve(self.w10())
        self.browser.open(url + "?live=stream")
        self.browser.wait_for("equistream.times.firstPicture")
        self.browser.wait_for("document.getElementById('note').textContent.includes('ended')")
        self.browser.wait_for(f"equistream.shownFrame.frame.index === {FRAMES - 1}")
        self.assertEqual(self.said(), "")
        self.assertEqual(self.end(server)["viewers"], 1)

    def test_a_recording_that_is_sent_over_and_over(self):
        _, url = self.serve(self.w10(), "--loop")
        self.browser.open(url + "?live=stream")
        self.browser.wait_for("(globalThis.turns ??= new Set()).add(equistream.player.maker.generation) && turns.size > 3")
        self.browser.wait_for(f"equistream.shownFrame.frame.index === {FRAMES - 1} && equistream.shownFrame.frame.main.distances")
        self.assertEqual(self.said("note"), "")
        self.assertEqual(self.said(), "")

    def test_a_server_that_was_lost_is_asked_again_until_it_is_there(self):
        """Meanwhile its last picture turns and moves with the head."""
        server, url = self.serve(self.w10(), "--loop")
        self.browser.open(url + "?live=stream")
        self.browser.wait_for("equistream.shownFrame.frame?.main.distances")
        server.kill()
        self.browser.wait_for("equistream.live.attempts > 1")
        self.assertRegex(self.said("state"), r"^(the connection was lost|no connection to the server): trying again \(\d+\)$")
        before = self.settled()
        self.browser.evaluate("equistream.head.yaw = 2; equistream.head.offset = [0.05, 0, 0]")
        seen = self.settled()
        self.assertLess(share_alike(before, seen), 0.9)
        index, head, view = (self.browser.evaluate("equistream." + what) for what in (
            "shownFrame.frame.index", "shownFrame.frame.info.head", "viewed()"))
        facing = np.array(head["orientation"])
        eye = head["position"] + rotated(facing, (0.05, 0, 0)), multiplied(facing, turned(math.degrees(2), 0))
        self.assertGreaterEqual(share_alike(seen, self.look(index, *eye, (view["width"], view["height"]), view)), 0.99)
        self.browser.evaluate("equistream.isExact = false")

        frames = self.root / "others"
        PROGRAMS.run("render", self.scene, "--frames", "0-2", "--size", "128x64", "--spp", 1, "--progress", "none",
                     "--out", frames)
        others = self.encode("others.mkv", "--depth", "pece420", "--depth-scale", 1, frames=frames)
        self.watch_taken()
        again, _ = self.serve(others, "--loop", web=url.split(":")[-1].rstrip("/"))
        self.browser.wait_for("taken.length > 5 && equistream.shownFrame.frame.info.camera.width === 128")
        self.browser.wait_for("equistream.shownFrame.frame.main.distances")
        self.browser.wait_for("document.getElementById('state').textContent === ''")
        self.assertEqual((self.said(), self.said("note")), ("", ""))
        self.assertEqual(self.browser.evaluate("equistream.live.attempts"), 0)
        again.terminate()
        self.browser.wait_for("document.getElementById('state').textContent.includes('trying again')")

    def test_a_server_that_wants_another_secret_now_is_asked_no_more(self):
        words = [self.w10(), "--loop", "--certificate", self.root / "again.pem"]
        server, url = self.serve(*words, web="https://127.0.0.1:0")
        self.browser.call("Security.setIgnoreCertificateErrors", ignore=True)
        self.browser.call("Page.navigate", url=url)
        self.browser.wait_for("globalThis.equistream?.shownFrame.frame")
        server.kill()
        server.wait()
        self.serve(*words, web="https://127.0.0.1:" + re.search(r":(\d+)/", url)[1])
        self.browser.wait_for("document.getElementById('problem').textContent.includes('found a refusal')")
        self.assertNotIn(url.split("#")[1], self.said())
        self.browser.wait_for("document.getElementById('state').textContent === ''")

    def test_who_reads_slowly_gets_the_whole_page(self):
        """The server has patience with each of its pieces."""
        _, url = self.serve(self.w10(), "--patience", 1)
        one = self.connected(url, SO_RCVBUF=16384)
        one.sendall(f"GET /?live=stream HTTP/1.1\r\nHost: {url.removeprefix('http://').rstrip('/')}\r\n\r\n".encode())
        start, answer = time.monotonic(), b""
        while piece := one.recv(4096):
            answer += piece
            time.sleep(0.06)
        self.assertGreater(time.monotonic() - start, 2)
        head, page = answer.split(b"\r\n\r\n", 1)
        self.assertEqual(len(page), int(re.search(rb"Content-Length: (\d+)", head)[1]))

    def test_those_that_find_no_room_count_until_they_have_gone(self):
        _, url = self.serve(self.w10(), "--loop", "--viewers", 1)

        def answer():
            try:
                return self.asking(url).recv(12)
            except ConnectionError:
                return b""

        self.assertEqual(answer(), b"HTTP/1.1 101")  # the one that there is room for
        with self.asking(url).makefile("rb") as refused:
            while refused.readline().strip():
                pass
            opcode, length, code = struct.unpack(">BBH", refused.read(4))
            self.assertEqual((opcode, code), (0x88, 1013))  # closed; "try again later"
            self.assertIn("no room", refused.read(length - 2).decode())
        for _ in range(63):
            self.assertEqual(answer(), b"HTTP/1.1 101")  # said "no room" then, and waited for
        self.assertEqual(answer(), b"")

    def test_those_that_find_no_room_keep_nobody_waiting(self):
        _, url = self.serve(self.w10())

        def is_turned_away():
            with self.connected(url) as one:
                return one.recv(1) == b""

        silent = [self.connected(url) for _ in range(64)]
        self.assertTrue(is_turned_away())
        start = time.monotonic()
        for _ in range(1000):
            self.connected(url).close()
        self.assertTrue(is_turned_away())  # after all that came before
        self.assertLess(time.monotonic() - start, 9)  # at 100 a second it would take ten
        for one in silent:
            one.close()

        def is_let_in():
            with contextlib.suppress(OSError, http.client.HTTPException):
                return self.status(url) == 302

        wait_until(is_let_in, "the page", 30)

    def test_a_hundred_a_second_may_ask(self):
        _, url = self.serve(self.w10())
        start = time.monotonic()
        asking = [self.connected(url) for _ in range(50)]
        for one in asking:
            one.sendall(f"GET / HTTP/1.1\r\nHost: {url.removeprefix('http://').rstrip('/')}\r\n\r\n".encode())
        for one in asking:
            self.assertEqual(one.recv(12), b"HTTP/1.1 302")
        self.assertGreater(time.monotonic() - start, 0.48)

    def test_who_has_become_a_viewer_asks_no_more(self):
        _, url = self.serve(self.w10(), "--loop", "--viewers", 100)
        for _ in range(70):
            with self.asking(url).makefile("rb") as viewer:
                self.assertEqual(viewer.read(12), b"HTTP/1.1 101")
                while viewer.readline().strip():
                    pass
                self.assertEqual(len(viewer.read(4)), 4)  # of the stream

    def test_one_that_was_dropped_keeps_nothing_open(self):
        server, url = self.serve(self.w10(), "--loop", "--patience", 3)

        def sockets():
            count = 0
            for file in pathlib.Path(f"/proc/{server.pid}/fd").iterdir():
                with contextlib.suppress(OSError):  # it has been closed meanwhile
                    count += os.readlink(file).startswith("socket:")
            return count

        before = sockets()
        one = self.asking(url, SO_RCVBUF=4096)
        self.assertEqual(one.recv(12), b"HTTP/1.1 101")

        def is_closed():
            with contextlib.suppress(OSError):
                one.sendall(b"\x8a\x80\0\0\0\0")  # a pong that nobody asked for: it is there
            return sockets() == before

        wait_until(lambda: sockets() > before, "it to come", 30)
        wait_until(is_closed, "its sockets to go", 60)
        self.assertEqual(self.end(server)["viewers"], 1)

    def test_what_a_browser_sends_is_read_slowly(self):
        """Also what the server never hears of."""
        _, url = self.serve(self.w10(), "--loop")
        one = self.asking(url, SO_SNDBUF=65536)
        self.assertEqual(one.recv(12), b"HTTP/1.1 101")
        one.setblocking(False)
        pongs, sent, end = 500 * (b"\x8a\xfd" + bytes(4 + 125)), 0, time.monotonic() + 3
        while time.monotonic() < end:
            try:
                sent += one.send(pongs[sent % len(pongs):])
            except BlockingIOError:
                time.sleep(0.001)
            self.assertLess(sent, 2 << 20)  # systems on the way keep some of it
        self.assertGreater(sent, 1 << 16)

    def test_what_is_too_large_is_refused(self):
        _, url = self.serve(self.w10(), "--loop")

        def answer(more):
            with contextlib.suppress(ConnectionError):
                one = self.connected(url)
                one.sendall(f"GET / HTTP/1.1\r\nHost: {url.removeprefix('http://').rstrip('/')}\r\n{more}".encode())
                return one.recv(12)
            return b""

        self.assertEqual(answer(f"A: {7000 * 'a'}\r\n\r\n"), b"HTTP/1.1 302")
        self.assertEqual(answer(f"A: {9000 * 'a'}\r\n\r\n"), b"")
        self.assertEqual(answer("Content-Length: 5\r\n\r\nhello"), b"")

        viewer = self.asking(url)
        self.assertEqual(viewer.recv(12), b"HTTP/1.1 101")
        viewer.sendall(struct.pack(">BBH", 0x82, 0x80 | 126, 4109) + bytes(4))  # the head of a message
        last, end = b"", time.monotonic() + 30
        while time.monotonic() < end and (block := viewer.recv(65536)):
            last = (last + block)[-4:]
        self.assertEqual(last, struct.pack(">BBH", 0x88, 2, 1009))  # closed; "message too big"

    def test_a_scene(self):
        server, url = self.serve(self.scene, "--size", "128x64", "--spp", 1)
        self.browser.open(url + "?live=stream")
        self.browser.wait_for("equistream.times.firstPicture", 120)
        self.browser.evaluate("equistream.head.yaw = 1")
        self.watch_taken()
        self.browser.wait_for("taken.length > 1", 120)
        self.assertEqual(self.browser.evaluate("equistream.live.sent"), 0)  # turning needs no new sphere
        # A headset's eyes see farther to one side than to the other.
        views = [{"width": 100, "height": 80, "focal": 50, "middle": middle} for middle in ([60, 40], [45, 50])]
        said = self.browser.evaluate(f"""(() => {{
            const {{live}} = equistream, {{socket}} = live, said = [];
            Object.defineProperty(live, "socket", {{value: {{readyState: 1, bufferedAmount: 0, send: bytes => said.push(new DataView(bytes))}}, configurable: true, writable: true}});
            live.sendHead(0, {{position: [0, 0, 0], orientation: [1, 0, 0, 0]}}, {json.dumps(views)}, false);
            live.socket = socket;
            live.sent = 0;
            return [76, 84].map(at => said[0].getFloat64(at, true));
        }})()""")
        self.assertEqual(said, [60 / 50, 50 / 50])
        self.browser.evaluate("equistream.head.offset = [0.05, 0, 0]")
        self.browser.wait_for("equistream.followed.isFollowed", 120)
        self.browser.evaluate("taken.length = 0")
        self.browser.wait_for("taken.length > 3", 120)  # spheres for the head that was sent move it no further
        place = "equistream.followed.around.position", "equistream.shownFrame.frame.info.head.position"
        around, found = (np.array(self.browser.evaluate(each)) for each in place)
        self.assertAlmostEqual(np.linalg.norm(found - around), 0.05, delta=1e-6)
        self.assertNotIn("no depth", self.said("figures"))
        self.assertEqual(self.said(), "")
        self.assertGreater(self.end(server)["live"]["poses"], 0)

    def status(self, url, **headers):
        connection = http.client.HTTPConnection(url.removeprefix("http://").rstrip("/"), timeout=30)
        self.addCleanup(connection.close)
        connection.request("GET", "/stream" if "Upgrade" in headers else "/", headers={
            name.replace("_", "-"): value for name, value in headers.items()})
        return connection.getresponse().status

    def test_other_pages_are_refused(self):
        _, url = self.serve(self.w10())
        host = url.removeprefix("http://").rstrip("/")
        upgrade = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13",
                   "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ=="}
        self.assertEqual(self.status(url), 302)
        self.assertEqual(self.status(url, Host="evil.example"), 403)
        self.assertEqual(self.status(url, **upgrade), 403)
        self.assertEqual(self.status(url, **upgrade, Origin="http://evil.example"), 403)
        self.assertEqual(self.status(url, **upgrade, Origin=f"http://{host}"), 101)
        _, other = self.serve(self.w10(), web="127.0.0.2:0")
        self.assertEqual(self.status(other), 302)  # by the address that it listens on
        self.assertEqual(self.status(other, Host="127.0.0.3"), 403)

    def test_it_says_who_can_come(self):
        server, _ = self.serve(self.w10(), "--open", web="0.0.0.0:0", stderr=subprocess.PIPE)
        self.end(server)
        said = server.stderr.read().splitlines()
        self.assertEqual(["the page of --web 0.0.0.0:0" in line for line in said], [True])

    def test_https_for_those_who_know_the_secret(self):
        """The certificate is checked as a client checks one that it trusts, and in Chromium as its user does who goes on."""
        stream = self.w10()
        pem = self.root / "server.pem"
        server, url = self.serve(stream, "--certificate", pem, web="https://127.0.0.1:0")
        self.assertEqual(pem.stat().st_mode & 0o077, 0)
        address, secret = url.split("/#")
        host = address.removeprefix("https://")
        trusted = ssl.create_default_context(cafile=pem)
        certificate = ssl.PEM_cert_to_DER_cert("-----BEGIN CERT" + pem.read_text().split("-----BEGIN CERT")[1])
        digest = hashlib.sha256(certificate).hexdigest().upper()
        self.assertEqual(self.said_first["certificate"].replace(":", ""), digest)

        def status(target, **headers):
            connection = http.client.HTTPSConnection(host, timeout=30, context=trusted)
            self.addCleanup(connection.close)
            connection.request("GET", target, headers={
                "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13",
                "Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Origin": address, **headers})
            return connection.getresponse().status

        self.assertEqual(status("/stream"), 403)
        self.assertEqual(status("/stream?key=" + secret[:-1]), 403)
        self.assertEqual(status("/stream?key=" + secret, Origin="https://evil.example"), 403)
        self.assertEqual(status("/stream?key=%" + secret[0].encode().hex() + secret[1:]), 101)
        with self.assertRaises((OSError, http.client.HTTPException)):
            self.status("http://" + host)

        self.browser.call("Security.setIgnoreCertificateErrors", ignore=True)
        self.browser.call("Page.navigate", url=url)  # which leads on to the page, with what stands behind #
        self.browser.wait_for("globalThis.equistream?.times.firstPicture")
        self.browser.wait_for(f"equistream.shownFrame.frame.index === {FRAMES - 1}")
        self.assertEqual(self.said(), "")
        self.browser.call("Page.navigate", url=address + "/#another-secret-than-the-server-has")
        self.browser.wait_for("document.getElementById('problem')?.textContent.includes('no connection to the server')")
        self.assertNotIn("another-secret", self.said())
        self.assertGreaterEqual(self.end(server)["viewers"], 2)

        _, again = self.serve(stream, "--certificate", pem, web="https://127.0.0.1:0")
        self.assertEqual(self.said_first["certificate"].replace(":", ""), digest)
        self.assertNotEqual(again.split("#")[1], secret)

    def test_certificates_that_are_none(self):
        file = self.root / "none.pem"
        file.write_text("nothing")
        file.chmod(0o600)

        def refusal(*words):
            done = subprocess.run([PROGRAMS.folder / "equistream", "serve", self.w10(),
                                   *map(str, words)], capture_output=True, text=True)
            self.assertEqual(done.returncode, 2, done.stderr)
            return done.stderr.strip()

        where = f"equistream serve: {file}: expected "
        self.assertEqual(refusal("--web", "https://:0", "--certificate", file),
                         where + "a private key and its certificate, as PEM without a password, found something else")
        file.chmod(0o644)
        self.assertEqual(refusal("--web", "https://:0", "--certificate", file),
                         where + "a file that only its owner can access (chmod 600), found one that others can access")
        self.assertEqual(refusal("--web", "0", "--certificate", file),
                         "equistream serve: --certificate: expected --web https://HOST:PORT as well, found 0")
        self.assertIn("https:// before it, or --open", refusal("--web", "0.0.0.0:0"))
