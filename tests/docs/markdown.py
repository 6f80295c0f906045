"""What the tests of the documentation read of a Markdown page: prose, links, headings, commands."""

import pathlib
import re
import shlex

ROOT = pathlib.Path(__file__).resolve().parents[2]
LINK = re.compile(r"!?\[([^\]]*)\]\(([^)\s]+)\)")
OUTSIDE = {"build", ".git", "demo-out", "node_modules"}


def pages():
    """Every page of the checkout, as paths from its root."""
    found = (path.relative_to(ROOT) for path in ROOT.rglob("*.md"))
    return sorted(path for path in found if not any(part in OUTSIDE or part.startswith("build") for part in path.parts))


def blocks(text):
    """Pairs of a fenced block's language and its lines."""
    return [(match[1], match[2]) for match in re.finditer(r"^```(\w*)[^\n]*\n(.*?)^```", text, re.M | re.S)]


def without_code(text):
    text = re.sub(r"^```.*?^```[^\n]*$", "", text, flags=re.M | re.S)
    text = re.sub(r"<!-- table .*?<!-- end -->", "", text, flags=re.S)  # what programs write between their markers
    return re.sub(r"<!--.*?-->", "", text, flags=re.S)


def headings(text):
    """The anchors that GitHub gives to a page's headings."""
    found = {}
    for line in without_code(text).splitlines():
        if match := re.match(r"#+\s+(.*)", line):
            words = LINK.sub(r"\1", match[1]).replace("`", "").strip().lower()
            slug = re.sub(r"[^\w\- ]", "", words).replace(" ", "-")
            found[slug] = found.get(slug, -1) + 1
    return {slug if i == 0 else f"{slug}-{i}" for slug, count in found.items() for i in range(count + 1)}


def paragraphs(text):
    """The page's prose, one text a paragraph or list item: no code, tables, headings, pictures."""
    found, now = [], []

    def end():
        if now:
            found.append(" ".join(now))
        now.clear()

    for line in without_code(text).splitlines():
        indented_code = line.startswith("    ") and not now
        if not line.strip() or indented_code or re.match(r"\s*(\||#|!\[|<)", line):
            end()
            continue
        if re.match(r"\s*([-*+]|\d+\.)\s", line):
            end()
            line = re.sub(r"^\s*([-*+]|\d+\.)\s+", "", line)
        now.append(line.strip().removeprefix("> "))
    end()
    return found


def sentences(text):
    """The words of each sentence; what stands in backticks is one word."""
    found = []
    for paragraph in paragraphs(text):
        plain = re.sub(r"`[^`]+`", "code", LINK.sub(r"\1", paragraph))
        plain = re.sub(r"\b(e\.g|i\.e|vs|et al|J|K|A|Fig)\. ", r"\1 ", plain)
        for part in re.split(r"(?<=[.!?])[)*_\"]*\s+", plain):
            words = [word for word in part.split() if re.search(r"\w", word)]
            if words:
                found.append(words)
    return found


def commands(text):
    """The words of each `equistream` command in a page's shell blocks."""
    found = []
    for language, block in blocks(text):
        if language == "sh":
            for line in block.replace("\\\n", " ").splitlines():
                found += commands_of(line)
    return found


def commands_of(line):
    words = shlex.split(line, comments=True)
    found, now = [], []
    for word in [*words, "&&"]:
        if word in ("&&", "|", ";", "&"):
            while now and re.match(r"\w+=", now[0]):
                now.pop(0)
            if now and now[0] == "equistream":
                found.append(now)
            now = []
        else:
            now.append(word)
    return found
