"""Makes the demo's page from what the chain left in a folder: one file, pictures inside, that works from disk.

usage: page.py OUT   (OUT holds sphere/, truth/, eyes/, rotated/, pictures/, pavilion.mp4 and the JSON reports)
"""

import base64
import html
import json
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
STAGES = ["decode", "convert", "depth", "reproject", "fill"]


def data_uri(file):
    kind = {".png": "image/png", ".jpg": "image/jpeg", ".mp4": "video/mp4"}[file.suffix]
    return f"data:{kind};base64,{base64.b64encode(file.read_bytes()).decode()}"


def read_json(file):
    return json.loads(file.read_text())


def figure(source, caption):
    return f'<figure><img src="{source}" alt=""><figcaption>{html.escape(caption)}</figcaption></figure>'


def table(head, rows):
    cells = lambda row, tag: "<tr>" + "".join(f"<{tag}>{html.escape(str(cell))}</{tag}>" for cell in row) + "</tr>"
    return "<table>" + cells(head, "th") + "".join(cells(row, "td") for row in rows) + "</table>"


def decibels(value):
    return "identical" if value is None else f"{value:.2f} dB"


class Results:
    """The reports of one run of the chain, and the frame that the page shows: the middle one."""

    def __init__(self, out):
        self.out = out
        self.play = {name: read_json(out / name / "report.json") for name in ("eyes", "rotated")}
        self.scores = {name: read_json(out / name / "compare.json") for name in ("eyes", "rotated")}
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
                rows.append([title, eye, decibels(score["psnr_db"]), f'{score["ssim"]:.4f}', f"{100 * gaps:.2f} %"])
        return table(["method", "eye", "PSNR to the truth", "SSIM", "not seen by the sphere"], rows)

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
            f'<figure><div class="wipe"><img src="{self.view("eyes", eye)}" alt=""><img src="{self.picture(eye, "colour")}" alt="">'
            f'<input type="range" min="0" max="100" value="50" aria-label="wipe"></div>'
            f"<figcaption>{eye.capitalize()} eye: reprojected | truth</figcaption></figure>"
            for eye in ("left", "right"))

    def gaps(self):
        figures = [figure(self.view("eyes", "gaps", eye), f"{eye.capitalize()} eye, white marks what the sphere could not see.")
                   for eye in ("left", "right")]
        figures += [figure(self.view("eyes", "difference", eye), f"{eye.capitalize()} eye, difference to the truth, amplified; the truth's own noise included.")
                    for eye in ("left", "right")]
        return "".join(figures)

    def commands(self):
        reports = [read_json(self.out / "sphere" / "centre" / "manifest.json"), read_json(self.out / "truth" / "left" / "manifest.json"),
                   *self.play.values(), *self.scores.values()]
        return html.escape("\n".join(report["command"] for report in reports))


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
        "VIDEO": data_uri(out / "pavilion.mp4"),
        "SPHERE": results.picture("sphere", "colour"),
        "YAW": "0",
        "TABLES": "<h3>Quality</h3>" + results.quality_table() + "<h3>Time and bytes</h3>" + results.cost_table(),
        "COMMANDS": results.commands(),
    }.items():
        page = page.replace(f"@{mark}@", text)
    (out / "index.html").write_text(page)


if __name__ == "__main__":
    main()
