"""Makes a site of docs/ as it lies in the repository. The README is the home page. Files outside docs/ that pages link to get pages of
their own. With EQUISTREAM_SITE_GALLERY=FOLDER the gallery that gallery.sh made there is in the site, and is linked (build.sh --gallery)."""

import json
import os
import posixpath
import re
import subprocess
from pathlib import Path

from mkdocs.structure.files import File, InclusionLevel
from mkdocs.structure.nav import Link

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"(\]\()([^)\s#:]+)(#[^)\s]*)?(?=\))")
PAGES = {"README.md": "index.md", "CHANGELOG.md": "changelog.md"}
LANGUAGES = {".h": "cpp", ".hpp": "cpp", ".cpp": "cpp", ".inc": "cpp", ".py": "python", ".sh": "sh", ".json": "json"}
GALLERY = os.environ.get("EQUISTREAM_SITE_GALLERY")
GALLERY_PAGE = "guide/gallery.md"
GROWN_FROM = {}
"""Of a page that does not lie in docs/: its path in the repository."""


def place(source, target):
    """Where a link of the page `source` leads, both as paths from the root; None outside the repository."""
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
    return None if path.startswith("..") else path


def site_path(path):
    """Of a path from the root: where the site has it."""
    if path in PAGES:
        return PAGES[path]
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    file = ROOT / path
    return f"source/{path}" if file.is_file() and not is_text(file) else f"source/{path}.md"


def is_text(file):
    return b"\0" not in file.read_bytes()[:4096]


def source_page(path):
    """A file as it is, or a folder's files by name."""
    file = ROOT / path
    if file.is_dir():
        listed = subprocess.run(["git", "-C", ROOT, "ls-files", path], text=True, capture_output=True)
        names = listed.stdout.split() or sorted(str(found.relative_to(ROOT)) for found in file.rglob("*") if found.is_file())
        return f"# {path}\n\n" + "".join(f"- `{name}`\n" for name in names)
    text = file.read_text()
    if file.suffix == ".ipynb":
        return notebook(json.loads(text))
    return text if file.suffix == ".md" else f"# {path}\n\n~~~~~~ {LANGUAGES.get(file.suffix, 'text')}\n{text}\n~~~~~~\n"


def notebook(of):
    """Its cells, with what they printed and drew."""
    parts = []
    for cell in of["cells"]:
        text = "".join(cell["source"])
        parts.append(text if cell["cell_type"] == "markdown" else f"~~~~~~ python\n{text}\n~~~~~~")
        for output in cell.get("outputs", []):
            if output["output_type"] == "stream":
                parts.append(f"~~~~~~ text\n{''.join(output['text'])}~~~~~~")
            elif "image/png" in output.get("data", {}):
                parts.append(f"![Figure of the cell above](data:image/png;base64,{output['data']['image/png']})")
    return "\n\n".join(parts) + "\n"


def links(source):
    """Paths from the root that the page at `source` links to."""
    found = (place(source, target) for _, target, _ in LINK.findall((ROOT / source).read_text()))
    return {path for path in found if path and (ROOT / path).exists()}


def on_files(files, config):
    ours = [f"docs/{file.src_uri}" for file in files.documentation_pages()]
    for source, uri in PAGES.items():
        GROWN_FROM[uri] = source
        files.append(File.generated(config, uri, content=(ROOT / source).read_text()))
    outside = {path for source in [*ours, *PAGES] for path in links(source) if not path.startswith("docs/")} - set(PAGES)
    for path in sorted(outside):
        uri = site_path(path)
        if uri.endswith(".md"):
            GROWN_FROM[uri] = path
            page = File.generated(config, uri, content=source_page(path))
            page.inclusion = InclusionLevel.NOT_IN_NAV
        else:
            page = File.generated(config, uri, abs_src_path=str(ROOT / path))
        files.append(page)
    for file in sorted(Path(GALLERY).iterdir()) if GALLERY else []:
        files.append(File.generated(config, f"gallery/{file.name}", abs_src_path=str(file)))
    return files


def on_nav(nav, files, **_):
    """The gallery stands behind the page that leads to it."""
    if GALLERY:
        page = files.get_file_from_path(GALLERY_PAGE).page
        link = Link("Look around", "gallery/index.html")
        link.parent = page.parent
        page.parent.children.insert(page.parent.children.index(page) + 1, link)
    return nav


def on_page_markdown(markdown, page, **_):
    """Links keep their targets: from where a page lies in the repository to where the site has what it names."""
    uri = page.file.src_uri
    source = GROWN_FROM.get(uri, f"docs/{uri}")

    def moved(match):
        path = place(source, match[2])
        if path is None or not (ROOT / path).exists():
            return match[0]
        return match[1] + posixpath.relpath(site_path(path), posixpath.dirname(uri) or ".") + (match[3] or "")

    if GALLERY and uri == GALLERY_PAGE:
        markdown = markdown.replace("\n", "\n\n**[Look around in three scenes](../gallery/index.html)**, in this browser.\n", 1)
    return LINK.sub(moved, markdown)
