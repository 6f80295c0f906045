"""`equistream serve SCENE` on a line that becomes narrow and wide again, and on one that loses packets."""

import json
import statistics
import time

from conditions import LIVE_S, LIVE_SHARES
from emulated import SERVER, Line, Network
from ends import Server, address, receive


def narrowed(programs, scene, words, way, seed):
    network = Network(Line(), seed, receive)
    server = Server(programs, scene, f"{way}://{SERVER}:9000", *words, "--patience", 60)
    network.begin()
    began = time.monotonic()
    network.connection.send(address(way))
    carried = []
    for (at_s, mbit_s), (until_s, _) in zip(LIVE_SHARES, [*LIVE_SHARES[1:], (LIVE_S, 0)]):
        network.line = Line(mbit_s=mbit_s or carried[-1]["mbit_s"] / 10)
        before = network.bytes
        time.sleep(max(0, began + until_s - time.monotonic()))
        carried.append({"from_s": at_s, "line_mbit_s": network.line.mbit_s, "mbit_s": (network.bytes - before) * 8e-6 / (until_s - at_s)})
    report = server.end()
    found = json.loads(network.connection.recv(1 << 22))
    network.close()
    spheres = [{"at_s": round(at - began, 3), "late_s": at - due, "crf": crf, **({"window_crf": window_crf, "window_pixels": pixels} if count else {})}
               for due, at, crf, window_crf, count, pixels in whole_spheres(found)]
    soonest = min(sphere["late_s"] for sphere in spheres)
    for sphere in spheres:
        sphere["later_s"] = round(sphere.pop("late_s") - soonest, 3)
    return {"line": carried, "report": report["live"], "spheres": spheres, "problem": found["problem"]}


def lossy(programs, source, words, line, way, seed, seconds=None):
    """`seconds`: of a scene, how long it is served. A recorded stream ends by itself."""
    network = Network(line, seed, receive)
    server = Server(programs, source, f"{way}://{SERVER}:9000", *words, "--patience", 60)
    network.begin()
    network.connection.send(address(way))
    if seconds:
        time.sleep(max(0, network.began + seconds - time.monotonic()))
        until, sent = time.monotonic(), sum(network.sent_bytes)
        network.line = Line()  # the stream's end is no part of it
        report = server.end()
        found = json.loads(network.connection.recv(1 << 22))
    else:
        found = json.loads(network.connection.recv(1 << 22))
        until, sent = time.monotonic(), sum(network.sent_bytes)
        report = server.end()
    network.close()
    return {**figures(found, until if seconds else None), "sent_mbit_s": round(sent * 8e-6 / (until - network.began), 4), "bytes": report["bytes_sent"],
            "sent_bytes": network.sent_bytes, "packets": network.carried + network.lost, "packets_lost": network.lost, "missed": report.get("live", {}).get("missed"),
            "problem": found["problem"]}


def whole_spheres(found):
    """Of each sphere: its time, when it was there with its window or tiles, its CRF, theirs, how many there were, and their pixels together."""
    windows = {time_s: last for time_s, *last in found["windows"]}
    for due, at, crf in found["came"]:
        window_at, *of_windows = windows.get(round(due, 4), (at, None, 0, 0))
        yield due, max(at, window_at), crf, *of_windows


def figures(found, until=None):
    """Of what came until then (None: of all), and how much later than the soonest sphere the others came, once the first second is over."""
    spheres = [sphere for sphere in whole_spheres(found) if until is None or sphere[1] <= until]
    if len(spheres) < 2:
        return {"spheres": len(spheres)}
    times = [at for _, at, *_ in spheres]
    end = until or times[-1]
    soonest = min(at - due for due, at, *_ in spheres)
    later = sorted(at - due - soonest for due, at, *_ in spheres if due >= spheres[0][0] + 1)
    window_crfs = [crf for *_, crf, count, _ in spheres if count]
    return {"spheres": len(spheres), "spheres_per_s": round((len(spheres) - 1) / (end - times[0]), 3),
            "later_s": {"median": round(statistics.median(later), 3), "p95": round(later[int(0.95 * (len(later) - 1))], 3), "most": round(later[-1], 3)} if later else None,
            "longest_gap_s": round(max(after - before for before, after in zip(times, [*times[1:], end])), 3), "crf": statistics.mean(sphere[2] for sphere in spheres),
            "window_crf": statistics.mean(window_crfs) if window_crfs else None, "windows_per_sphere": round(statistics.mean(count for *_, count, _ in spheres), 2)}
