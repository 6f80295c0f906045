"""The site of docs/ builds without a warning; its links, anchors and pictures are there, nothing comes from elsewhere, every page can be reached.

Exit status 77 where MkDocs is not installed: docs/site/build.sh installs it.
"""

import html.parser
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import urllib.parse

from markdown import ROOT

MKDOCS = ROOT / "build/site-venv/bin/mkdocs"
LOADED = {"img": "src", "script": "src", "source": "src", "video": "src", "iframe": "src", "link": "href"}
"""What a browser fetches by itself, by tag."""
NOT_FETCHED = {"canonical", "prev", "next"}
"""Kinds of <link>."""
MARKDOWN_LEFT = re.compile(r"^\s*(?:[-*] \w|\d+\. \w|\|.*\|\s*$|#+ \w)", re.M)
"""In a paragraph: a list, a table or a heading that GitHub sees and MkDocs does not."""


class Page(html.parser.HTMLParser):
    """What a page refers to, what can be referred to in it, and its paragraphs."""

    def __init__(self, text):
        super().__init__()
        self.links, self.loads, self.names, self.paragraphs = [], [], set(), []
        self.in_article = self.in_paragraph = False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.names |= {values[key] for key in ("id", "name") if values.get(key)}
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        elif tag in LOADED and values.get(LOADED[tag]) and values.get("rel") not in NOT_FETCHED:
            self.loads.append(values[LOADED[tag]])
        self.in_article |= tag == "article"
        if self.in_article and tag in ("p", "li"):
            self.paragraphs.append("")
            self.in_paragraph = True
        elif tag in ("pre", "ul", "ol", "table"):
            self.in_paragraph = False

    def handle_endtag(self, tag):
        self.in_paragraph &= tag not in ("p", "li")

    def handle_data(self, data):
        if self.in_paragraph:
            self.paragraphs[-1] += data


def faults_of(site):
    """One line a fault, over all pages below a folder."""
    pages = {path: Page(path.read_text()) for path in sorted(site.rglob("*.html"))}
    reached, ahead, faults = set(), [site / "index.html"], []
    while ahead:
        path = ahead.pop()
        if path in reached:
            continue
        reached.add(path)
        for target in pages[path].links:
            file, fault = look_up(site, pages, path, target)
            if fault:
                faults.append(f"{path.relative_to(site)}: {target}: {fault}")
            elif file in pages:
                ahead.append(file)
    for path, page in pages.items():
        for target in page.loads:
            outside = re.match(r"(?:https?:)?//", target)
            fault = "comes from another host" if outside else look_up(site, pages, path, target)[1]
            faults += [f"{path.relative_to(site)}: {target}: {fault}"] if fault else []
        faults += [f"{path.relative_to(site)}: Markdown left as it is: {text[:80]}" for text in page.paragraphs if MARKDOWN_LEFT.search(text)]
    return faults + [f"{path.relative_to(site)}: no link leads here" for path in sorted(set(pages) - reached) if path.name != "404.html"]


def look_up(site, pages, path, target):
    """(file, None), or (None, what is wrong); what lies outside the site is right."""
    address = urllib.parse.urlsplit(target)
    if address.scheme or target.startswith("//"):
        return None, None
    name = urllib.parse.unquote(address.path)
    file = pathlib.Path(os.path.normpath(site / name.lstrip("/") if name.startswith("/") else path.parent / name)) if name else path
    if not file.is_file():
        return None, "no such file"
    anchor = urllib.parse.unquote(address.fragment)
    if anchor and file in pages and anchor not in pages[file].names and not anchor.startswith("__"):
        return None, "no such anchor"
    return file, None


class Site(unittest.TestCase):
    def build(self, folder, **environment):
        built = subprocess.run([MKDOCS, "build", "--strict", "--quiet", "--site-dir", folder], cwd=ROOT, text=True, capture_output=True,
                               env={**os.environ, "NO_MKDOCS_2_WARNING": "1", **environment})
        self.assertEqual((0, ""), (built.returncode, built.stdout + built.stderr))

    def test_site(self):
        with tempfile.TemporaryDirectory() as folder:
            self.build(folder)
            found = list(pathlib.Path(folder).rglob("*.html"))
            self.assertGreater(len(found), 60)
            self.assertTrue(any(path.match("results/study/kitchen.html") for path in found))
            faults = faults_of(pathlib.Path(folder))
            self.assertEqual([], faults, "\n" + "\n".join(faults))

    def test_a_gallery_is_part_of_the_site(self):
        with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as gallery:
            site = pathlib.Path(folder)
            for name, text in {"index.html": '<a href="web.html?src=room.mp4"><img src="room.png"></a>', "web.html": "", "room.mp4": "x", "room.png": "x"}.items():
                (pathlib.Path(gallery) / name).write_text(text)
            self.build(folder, EQUISTREAM_SITE_GALLERY=gallery)
            self.assertTrue((site / "gallery/room.mp4").is_file())
            self.assertEqual([], faults_of(site))  # so its pages can be reached, too
            for page, link in {"index.html": "gallery/index.html", "guide/gallery.html": "../gallery/index.html"}.items():
                self.assertIn(link, Page((site / page).read_text()).links, page)

    def test_faults_would_be_found(self):
        with tempfile.TemporaryDirectory() as folder:
            site = pathlib.Path(folder)
            (site / "index.html").write_text('<a href="a.html#x">a</a><a href="a.html#y">a</a><a href="b.html">b</a><img src="c.png">'
                                             '<script src="https://example.org/d.js"></script><article><p>List:\n- one</p><pre><code>\n- code</code></pre></article>')
            (site / "a.html").write_text('<h2 id="x">x</h2>')
            (site / "alone.html").write_text("alone")
            self.assertEqual({"index.html: b.html: no such file", "index.html: a.html#y: no such anchor", "index.html: c.png: no such file",
                              "index.html: https://example.org/d.js: comes from another host", "index.html: Markdown left as it is: List:\n- one",
                              "alone.html: no link leads here"}, set(faults_of(site)))


if __name__ == "__main__":
    if not MKDOCS.exists():
        print("left out: MkDocs is not installed; docs/site/build.sh installs it")
        sys.exit(77)
    unittest.main()
