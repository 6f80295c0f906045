"""What a lossy line does to the page of `serve --web`: Chromium on its other side shows the stream, and its head turns at every refresh."""

import json
import pathlib
import statistics
import sys

from emulated import SERVER, Line, Network

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "programs/web"))
from chromium import Chromium  # noqa: E402

LINES = {"nothing lost": Line(), "1 % lost": Line(loss=0.01), "5 % lost": Line(loss=0.05), "20 % lost": Line(loss=0.2), "silence of 1 s": Line(silent=(3, 4))}
PATIENCE_S = 180
WATCH = """(() => {
    const seen = [], refreshes = [];
    globalThis.watched = {seen, refreshes};
    let last = null;
    const look = now => {
        const frame = globalThis.equistream?.shownFrame?.frame ?? null;
        if (frame && frame !== last) {
            last = frame;
            seen.push([frame.info.time, now / 1000]);
        }
        if (frame) {
            refreshes.push(now);
            equistream.head.yaw = 0.5 * Math.sin(now / 1000);
        }
        requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
})()"""


def look_on(connection):
    """On the client's side: opens the address that it is told, and says what the page showed until the stream ended."""
    while url := connection.recv(1000).decode():
        browser, found = Chromium(), {"problem": None}
        try:
            browser.call("Security.setIgnoreCertificateErrors", ignore=True)
            browser.before_pages(WATCH)
            browser.call("Page.navigate", url=url)
            browser.wait_for("globalThis.equistream?.times?.firstPicture || document.getElementById('problem').textContent", PATIENCE_S)
            browser.wait_for("/ended/.test(document.getElementById('note').textContent) || document.getElementById('problem').textContent", PATIENCE_S)
            found.update(browser.evaluate("({...watched, passed: equistream.player.lateFrames, first_picture_ms: equistream.times.firstPicture - equistream.times.opened,"
                                          " problem: document.getElementById('problem').textContent})"))
        except Exception as error:  # what went wrong is a finding too
            found["problem"] = str(error)
        browser.close()
        connection.send(json.dumps(found).encode())


def shown(start_server, secret, certificate, line, seed):
    """`start_server(*words)` starts one that hands out the page on the server's side, to those who know the secret."""
    network = Network(line, seed, look_on)
    server = start_server("--web", f"https://{SERVER}:0", "--certificate", certificate, "--patience", PATIENCE_S)
    network.begin()
    network.connection.send(f"{server.said['web']}#{secret}".encode())
    found = json.loads(network.connection.recv(1 << 22))
    server.end()
    network.close()
    return {**found, "packets": network.carried + network.lost, "packets_lost": network.lost}


def figures(found):
    """How much later than the soonest pictures came, once the first second is over, and how long the page stood still between two refreshes."""
    seen, refreshes = found.get("seen", []), found.get("refreshes", [])
    if len(seen) < 2:
        return {}
    soonest = min(at - due for due, at in seen)
    later = sorted(1000 * (at - due - soonest) for due, at in seen if due >= seen[0][0] + 1)
    between = sorted(second - first for first, second in zip(refreshes, refreshes[1:]))
    return {"shown": len(seen), "passed": found["passed"], "first_picture_ms": round(found["first_picture_ms"]), "later_ms": ranks(later), "between_refreshes_ms": ranks(between)}


def ranks(ranked):
    return {"median": round(statistics.median(ranked), 1), "p95": round(ranked[int(0.95 * (len(ranked) - 1))], 1), "most": round(ranked[-1], 1)}
