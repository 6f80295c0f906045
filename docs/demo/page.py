"""Makes the demo's page from what the chain left in a folder: one file, pictures inside, that works from disk.

usage: page.py OUT   (OUT holds sphere/, eyes/, rotated/, moved/, pictures/, commands.txt and the JSON reports)
"""

import base64
import html
import json
import os
import pathlib
import sys

AOV_CAPTIONS = {
    "colour": "Colour: what the path tracer saw, all round.",
    "depth": "Depth: metres to the nearest surface, never filtered; near is red, far is blue, sky is black.",
    "backward": "Motion: where each pixel was one frame ago; hue is direction, brightness is length.",
    "normal": "Normals, in world space.",
    "albedo": "Albedo.",
    "object_id": "Object ids.",
}
DOCS = pathlib.Path(__file__).resolve().parents[1]
LINKS = {"guide/tutorial.md": "Tutorial", "guide/concepts.md": "Concepts", "guide/gallery.md": "Gallery", "compare.md": "What the figures mean", "guide/README.md": "All pages"}
STAGES = ["decode", "convert", "depth", "reproject", "fill"]


def data_uri(file):
    return f"data:image/png;base64,{base64.b64encode(file.read_bytes()).decode()}"


def read_json(file):
    return json.loads(file.read_text())


def figure(source, caption):
    return f'<figure><img src="{source}" alt="{html.escape(caption)}"><figcaption>{html.escape(caption)}</figcaption></figure>'


def table(head, rows):
    cells = lambda row, tag: "<tr>" + "".join(f"<{tag}>{html.escape(str(cell))}</{tag}>" for cell in row) + "</tr>"
    return "<table>" + cells(head, "th") + "".join(cells(row, "td") for row in rows) + "</table>"


def decibels(value):
    return "identical" if value is None else f"{value:.2f} dB"


def whole(score):
    """Where the truths' noise hides the error, its bound."""
    error = score["whole"]["display"]
    return f'more than {error["db_low"]:.1f} dB' if error["only_bounded"] else decibels(error["db"])


class Results:
    """The reports of one run of the chain, and the frame that the page shows: the middle one."""

    def __init__(self, out):
        self.out = out
        self.play = {name: read_json(out / name / "report.json") for name in ("eyes", "rotated")}
        self.scores = {name: read_json(out / name / "compare.json") for name in ("eyes", "rotated")}
        self.ceiling = read_json(out / "ceiling.json")
        frames = sorted((out / "eyes" / "left").glob("frame.*.png"))
        self.frame = frames[len(frames) // 2].name

    def view(self, *parts):
        return data_uri(self.out.joinpath(*parts) / self.frame)

    def picture(self, folder, plane):
        """What `equistream info --pictures` made of a plane of the shown frame."""
        return data_uri(self.out / "pictures" / folder / f"{pathlib.Path(self.frame).stem}.{plane}.png")

    def quality_table(self):
        rows = []
        for name, title in (("eyes", "eye-depth: by depth, gaps filled"), ("rotated", "rotation: turned only")):
            for eye, score in self.scores[name]["eyes"].items():
                gaps = self.play[name]["eyes"][eye]["gap_fraction"]
                rows.append([title, eye, whole(score), decibels(score["psnr_db"]), f'{score["ssim"]:.4f}', f"{100 * gaps:.2f} %"])
        for eye, score in self.ceiling["eyes"].items():
            rows.append(["ceiling: one truth beside the other", eye, "", decibels(score["psnr_db"]), f'{score["ssim"]:.4f}', ""])
        return table(["method", "eye", "whole error", "PSNR to a truth, its noise included", "SSIM", "not seen by the sphere"], rows)

    def cost_table(self):
        times = self.play["eyes"]["milliseconds"]
        rows = [[f"{stage}, both eyes", f'{times[stage]["mean"]:.2f} ms'] for stage in STAGES if stage in times]
        frames = len(self.play["eyes"]["frames"])
        for track, figures in self.play["eyes"]["bytes"]["input"].items():
            rows.append([f"{track} track", f'{figures["bytes"] / frames / 1000:.1f} kB a frame'])
        return table(["stage or track", "mean"], rows)

    def aovs(self):
        return "".join(figure(self.picture("sphere", plane), text) for plane, text in AOV_CAPTIONS.items())

    def wipes(self):
        return "".join(
            f'<figure><div class="wipe"><img src="{self.view("eyes", eye)}" alt="{eye.capitalize()} eye, reprojected">'
            f'<img src="{self.picture(eye, "colour")}" alt="{eye.capitalize()} eye, path traced">'
            f'<input type="range" min="0" max="100" value="50" aria-label="wipe"></div>'
            f"<figcaption>{eye.capitalize()} eye: reprojected | truth</figcaption></figure>"
            for eye in ("left", "right"))

    def gaps(self):
        figures = [figure(self.view("eyes", "gaps", eye), f"{eye.capitalize()} eye, white marks what the sphere could not see.")
                   for eye in ("left", "right")]
        figures += [figure(self.view("eyes", "difference", eye), f"{eye.capitalize()} eye, difference to the truth, amplified; the truth's own noise included.")
                    for eye in ("left", "right")]
        return "".join(figures)

    def heads(self):
        """As a list in JSON: what is seen with depth at each place of the head."""
        return json.dumps([data_uri(next((self.out / "moved" / place.stem / "left").glob("*.png"))) for place in sorted((self.out / "heads").glob("*.csv"))])

    def turned(self):
        """The first frame, as the head's places are of it; turned only it is the same wherever the head is."""
        return data_uri(min((self.out / "rotated" / "left").glob("*.png")))

    def reach_cm(self):
        return f'{100 * read_json(self.out / "sphere" / "centre" / "manifest.json")["lean_m"]:g}'

    def commands(self):
        return html.escape((self.out / "commands.txt").read_text())

    def links(self):
        return " &middot; ".join(f'<a href="{os.path.relpath(DOCS / page, self.out.resolve())}">{text}</a>' for page, text in LINKS.items())


def main():
    out = pathlib.Path(sys.argv[1])
    results = Results(out)
    page = (pathlib.Path(__file__).parent / "page.html").read_text()
    for mark, text in {
        "AOVS": results.aovs(),
        "WIPES": results.wipes(),
        "GAPS": results.gaps(),
        "LEFT": results.view("eyes", "left"),
        "RIGHT": results.view("eyes", "right"),
        "HEADS": results.heads(),
        "TURNED": results.turned(),
        "REACH": results.reach_cm(),
        "FRAMES": str(len(results.play["eyes"]["frames"])),
        "LINKS": results.links(),
        "SPHERE": results.picture("sphere", "colour"),
        "YAW": "0",
        "TABLES": "<h3>Quality</h3>" + results.quality_table() + "<h3>Time and bytes</h3>" + results.cost_table(),
        "COMMANDS": results.commands(),
    }.items():
        page = page.replace(f"@{mark}@", text)
    (out / "index.html").write_text(page)


if __name__ == "__main__":
    main()
