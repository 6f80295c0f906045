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


DRAW = """(async sizes => {
    const {renderer, shownFrame} = equistream, {gl} = renderer, {frame} = shownFrame, {position} = frame.info.pose, pixel = new Uint8Array(4), found = [];
    equistream.isExact = true;
    const eyesOf = turn => [-1, 1].map(side => ({position: [position[0] + 0.0315 * side, position[1], position[2]], orientation: [Math.cos(turn), 0, Math.sin(turn), 0]}));
    for (const [width, height] of sizes) {
        const view = {width, height, focal: 0.5 * width, middle: [0.5 * width, 0.5 * height]}, times = [[], []];
        while (shownFrame.isMaking)
            await new Promise(resolve => setTimeout(resolve, 5));
        await shownFrame.show(frame, view, eyesOf(0), true);
        if (!renderer.main.hasMesh)
            throw new Error("expected a mesh, found none");
        for (let i = 0; i < 50; ++i) {
            const eyes = eyesOf(0.05 * Math.sin(i));
            times.forEach((spent, one) => {
                const began = performance.now(), shown = eyes.slice(one);
                const drawn = shown.map((eye, number) => renderer.drawEye(view, eye, number, shown.length));
                renderer.show(null, {left: 0, bottom: 0, width, height}, drawn[0], drawn.at(-1), shown.length > 1, 0);
                gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
                spent.push(performance.now() - began);
            });
        }
        found.push(times.map(spent => spent.slice(10)));
    }
    return found;
})"""


def drawn(url, sizes):
    """Milliseconds for both eyes and for one, of each size; and what the browser draws with. Without a network between."""
    browser = Chromium()
    browser.call("Page.navigate", url=url)
    browser.wait_for("globalThis.equistream?.times?.firstPicture && equistream.shownFrame.frame.main.distances || document.getElementById('problem').textContent", PATIENCE_S)
    times = browser.evaluate(f"{DRAW}({json.dumps(sizes)})")
    by = browser.evaluate("(gl => gl.getParameter(gl.getExtension('WEBGL_debug_renderer_info').UNMASKED_RENDERER_WEBGL))(equistream.renderer.gl)")
    browser.close()
    rows = [{"size": f"{width}x{height}", "eyes": 2 - one, **ranks(sorted(spent))} for (width, height), both in zip(sizes, times, strict=True) for one, spent in enumerate(both)]
    return {"by": by, "times_ms": rows}


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
