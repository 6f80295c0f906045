"""A headless Chromium, driven over a pipe by its DevTools protocol, and a web server of a folder for it."""

import functools
import http.server
import json
import os
import shutil
import subprocess
import tempfile
import threading


def find_chromium():
    return shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Folder:
    """A folder on a port of this machine."""

    def __init__(self, folder):
        class Quiet(http.server.SimpleHTTPRequestHandler):
            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=str(folder)))
        self.url = f"http://127.0.0.1:{self.server.server_port}/"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def close(self):
        self.server.shutdown()
        self.server.server_close()


class PageError(RuntimeError):
    """What a page's script threw."""


class Chromium:
    """One page. Messages are JSON, each ended by a zero byte, on the file descriptors 3 and 4 of the browser."""

    def __init__(self):
        self.profile = tempfile.TemporaryDirectory(prefix="equistream-web-", ignore_cleanup_errors=True)
        to_read, self.to_browser = os.pipe()
        self.from_browser, to_write = os.pipe()
        words = [find_chromium(), "--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--disable-dev-shm-usage",
                 "--use-gl=angle", "--use-angle=gles-egl", "--ignore-gpu-blocklist", "--mute-audio",
                 "--no-first-run", "--window-size=500,400", f"--user-data-dir={self.profile.name}", "about:blank"]
        # The shell puts the pipes where the browser looks for them.
        shell = ["sh", "-c", f'exec "$@" 3<&{to_read} 4>&{to_write}', "sh", *words]
        self.process = subprocess.Popen(shell, pass_fds=(to_read, to_write), stdout=subprocess.DEVNULL,
                                        stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(to_write)
        self.number = 0
        self.pending = b""
        self.console = []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = None
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call("Runtime.enable")
        self.call("Page.enable")

    def close(self):
        self.session = None
        try:
            self.call("Browser.close")  # by a signal its children go on for a moment, and leave files
            self.process.wait(30)
        except (RuntimeError, OSError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        os.close(self.to_browser)
        os.close(self.from_browser)
        self.profile.cleanup()

    def read(self):
        while b"\0" not in self.pending:
            piece = os.read(self.from_browser, 1 << 20)
            if not piece:
                raise RuntimeError("chromium ended")
            self.pending += piece
        message, self.pending = self.pending.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.number += 1
        message = {"id": self.number, "method": method, "params": parameters}
        if getattr(self, "session", None):
            message["sessionId"] = self.session
        os.write(self.to_browser, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.read()
            if answer.get("method") == "Runtime.consoleAPICalled":
                self.console.append(" ".join(str(each.get("value", each.get("description")))
                                             for each in answer["params"]["args"]))
            elif answer.get("method") == "Runtime.exceptionThrown":
                details = answer["params"]["exceptionDetails"]
                self.console.append(details.get("exception", {}).get("description", details["text"]))
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']['message']}")
                return answer["result"]

    def before_pages(self, script):
        """Runs it in every page that is opened from now on, before the page's own."""
        self.call("Page.addScriptToEvaluateOnNewDocument", source=script)

    def open(self, url):
        self.console.clear()
        self.call("Page.navigate", url=url)
        self.wait_for(f"document.readyState === 'complete' && location.href === {json.dumps(url)}")

    def evaluate(self, expression):
        """Its value; promises are awaited."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise PageError(details.get("exception", {}).get("description", details["text"]))
        return answer["result"].get("value")

    def wait_for(self, condition, seconds=60):
        """Until the expression is true; raises what the page says is wrong."""
        patient = f"""new Promise((resolve, reject) => {{
            const end = Date.now() + {1000 * seconds};
            const look = () => {{
                try {{
                    if ({condition}) return resolve(true);
                }} catch (error) {{}}
                if (Date.now() > end)
                    return reject(new Error("waited in vain for " + {json.dumps(condition)} + "; the page says: " +
                                            (document.body?.innerText ?? "")));
                setTimeout(look, 20);
            }};
            look();
        }})"""
        self.evaluate(patient)
