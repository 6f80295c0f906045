"""Runs the demo's chain on small pictures, twice, and reads the page that it leaves.

usage: demo_test.py BIN_DIR DEMO_DIR
"""

import base64
import html.parser
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

PNG = b"\x89PNG"
SMALL = {"EQUISTREAM_DEMO_FRAMES": "60-61", "EQUISTREAM_DEMO_SPHERE": "512x256", "EQUISTREAM_DEMO_EYE": "128x72", "EQUISTREAM_DEMO_SPP": "2"}


class Page(html.parser.HTMLParser):
    """What a page shows and refers to."""

    def __init__(self, text):
        super().__init__()
        self.sources, self.links, self.alts, self.text = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.sources += [values["src"]] if "src" in values else []
        self.links += [values["href"]] if "href" in values else []
        self.alts += [values.get("alt")] if tag == "img" else []

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
        assert head == "data:image/png" and data, f"expected data inside the page, found {source[:80]}"
        assert base64.b64decode(data, validate=True).startswith(PNG), head


def check_heads(written):
    """Nine places, each with a picture of its own."""
    heads = json.loads(re.search(r"const heads = (\[[^]]*\])", written)[1])
    assert len(heads) == len(set(heads)) == 9, len(set(heads))


def check_commands(out, text):
    run = (out / "commands.txt").read_text()
    for command in ("scene generate", "render", "encode", "play", "compare"):
        assert f"equistream {command} " in run, run
    assert run.strip() in text, "expected the commands on the page"


def check_figures(out, text):
    scores = json.loads((out / "eyes/compare.json").read_text())["eyes"]
    ceiling = json.loads((out / "ceiling.json").read_text())["eyes"]
    for eye, score in scores.items():
        for level in (score["psnr_db"], score["whole"]["display"]["db"], ceiling[eye]["psnr_db"]):
            assert f"{level:.2f} dB" in text, f"{eye}: expected {level:.2f} dB on the page, found {text}"
    played = json.loads((out / "eyes/report.json").read_text())
    total = sum(figures["bytes"] for figures in played["bytes"]["input"].values())
    assert total > 0 and any("kB a frame" in words for words in text), text
    rotated = json.loads((out / "rotated/compare.json").read_text())["eyes"]
    assert all(scores[eye]["whole"]["display"]["db"] > rotated[eye]["whole"]["display"]["db"] for eye in scores), (scores, rotated)


def check_that_another_build_renders_anew(programs, demo, out):
    """Another build has another identity in its frames, and another checksum in settings.txt."""
    manifest, settings = out / "sphere/centre/manifest.json", out / "settings.txt"
    written = json.loads(manifest.read_text())
    mine = written["host"]
    scene = out / "scene/pavilion.json"
    as_generated = scene.read_bytes()
    scene.write_bytes(as_generated + b"\n")
    manifest.write_text(manifest.read_text().replace(mine, "another build"))
    settings.write_text(settings.read_text().replace(" ", "  ", 1))
    run_chain(programs, demo, out)
    assert json.loads(manifest.read_text())["host"] == mine
    assert scene.read_bytes() == as_generated


def main():
    programs, demo = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        run_chain(programs, demo, out)
        written = (out / "index.html").read_text()
        page = Page(written)
        check_sources(page.sources)
        assert all(page.alts), page.alts
        assert page.links and all((out / link).resolve().exists() for link in page.links), page.links
        check_heads(written)
        check_commands(out, page.text)
        check_figures(out, page.text)
        renders = (out / "sphere/centre/manifest.json").stat().st_mtime_ns
        run_chain(programs, demo, out)
        assert (out / "sphere/centre/manifest.json").stat().st_mtime_ns == renders, "a second run rendered anew"
        check_that_another_build_renders_anew(programs, demo, out)


if __name__ == "__main__":
    main()
