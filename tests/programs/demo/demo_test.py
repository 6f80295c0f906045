"""Runs the demo's chain on small pictures, twice, and reads the page that it leaves.

usage: demo_test.py BIN_DIR DEMO_DIR
"""

import base64
import html.parser
import json
import os
import pathlib
import subprocess
import sys
import tempfile

KINDS = {"image/png": b"\x89PNG", "video/mp4": b"ftyp"}
SMALL = {"EQUISTREAM_DEMO_FRAMES": "60-61", "EQUISTREAM_DEMO_SPHERE": "512x256", "EQUISTREAM_DEMO_EYE": "128x72", "EQUISTREAM_DEMO_SPP": "2"}


class Page(html.parser.HTMLParser):
    """What a page shows and refers to."""

    def __init__(self, text):
        super().__init__()
        self.sources, self.text = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.sources += [value for name, value in attributes if name in ("src", "href")]

    def handle_data(self, data):
        self.text.append(data.strip())


def run_chain(programs, demo, out):
    paths = {"PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run([demo / "chain.sh", out], env={**os.environ, **SMALL, **paths}, text=True, capture_output=True)
    assert done.returncode == 0, f"chain.sh: {done.returncode}\n{done.stdout}{done.stderr}"
    assert f"open {out}/index.html" in done.stdout, done.stdout


def check_sources(sources):
    """All inside the page, and what they say they are."""
    assert len(sources) > 12, sources
    for source in sources:
        head, _, data = source.partition(";base64,")
        assert head.startswith("data:") and data, f"expected data inside the page, found {source[:80]}"
        found = base64.b64decode(data, validate=True)
        assert KINDS[head.removeprefix("data:")] in found[:16], head


def check_figures(out, text):
    scores = json.loads((out / "eyes/compare.json").read_text())["eyes"]
    for eye, score in scores.items():
        assert f'{score["psnr_db"]:.2f} dB' in text, f"{eye}: expected {score['psnr_db']:.2f} dB on the page, found {text}"
    played = json.loads((out / "eyes/report.json").read_text())
    total = sum(figures["bytes"] for figures in played["bytes"]["input"].values())
    assert total > 0 and any("kB a frame" in words for words in text), text
    rotated = json.loads((out / "rotated/compare.json").read_text())["eyes"]
    assert all(scores[eye]["psnr_db"] > rotated[eye]["psnr_db"] for eye in scores), (scores, rotated)


def main():
    programs, demo = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        run_chain(programs, demo, out)
        written = (out / "index.html").read_text()
        page = Page(written)
        check_sources(page.sources)
        check_figures(out, page.text)
        renders = (out / "sphere/centre/manifest.json").stat().st_mtime_ns
        run_chain(programs, demo, out)
        assert (out / "sphere/centre/manifest.json").stat().st_mtime_ns == renders, "a second run rendered anew"


if __name__ == "__main__":
    main()
