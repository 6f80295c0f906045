"""Every link between the checkout's pages leads to a file, and to a heading where it names one; so does every
docs/ page that a program's text or a comment names."""

import re
import subprocess
import unittest

from markdown import LINK, ROOT, headings, pages, without_code

SOURCES = re.compile(r"(?<![\w./-])(?:plugin|client|host-adapters|tests|docs|programs|cmake)/[\w./-]+\.(?:py|h|cpp|c|md|sh|json|cmake|txt|svg)\b")
NAMED = re.compile(r"\bdocs/[\w./-]+\.md\b")


def broken_links(page, text):
    for _, target in LINK.findall(without_code(text)):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, anchor = target.partition("#")
        file = (ROOT / page).parent / name if name else ROOT / page
        if name and not file.exists():
            yield f"{page}: {target}: no such file"
        elif anchor and file.suffix == ".md":
            there = headings(file.read_text() if name else text)
            if anchor not in there:
                yield f"{page}: {target}: no such heading; there are {', '.join(sorted(there))}"


class Links(unittest.TestCase):
    def test_links_lead_somewhere(self):
        broken = [line for page in pages() for line in broken_links(page, (ROOT / page).read_text())]
        self.assertEqual([], broken, "\n" + "\n".join(broken))

    def test_pages_named_in_code_are_there(self):
        found = subprocess.run(["git", "-C", ROOT, "grep", "-InoE", r"\bdocs/[[:alnum:]_./-]+\.md\b", "--", ":!*.md", ":!*.json", ":!*.html"],
                               text=True, capture_output=True)
        if found.returncode > 1:
            self.skipTest("not a git checkout")
        broken = [line for line in found.stdout.splitlines() if not (ROOT / NAMED.search(line.split(":", 2)[2])[0]).exists()]
        self.assertEqual([], broken, "\n" + "\n".join(broken))

    def test_files_named_in_pages_are_there(self):
        broken = [f"{page}: {name}" for page in pages() for name in SOURCES.findall((ROOT / page).read_text())
                  if not (ROOT / name).exists() and not re.search("[A-Z]{3}", name)]
        self.assertEqual([], broken, "\n" + "\n".join(broken))

    def test_a_broken_link_would_be_found(self):
        self.assertEqual({"a-b", "c", "c-1"}, headings("# A `b`\n## C\n```\n# no\n```\n## C\n"))
        self.assertEqual([("x", "y.md#z")], LINK.findall("see [x](y.md#z)."))
        page = "# Here\n[good](#here), [and](conventions.md), [bad](nowhere.md), [worse](#nowhere), [worst](conventions.md#nowhere)."
        self.assertEqual(["nowhere.md: no such file", "#nowhere: no such heading", "conventions.md#nowhere: no such heading"],
                         [re.match(r"docs/compare.md: ([^;]*)", line)[1] for line in broken_links("docs/compare.md", page)])


if __name__ == "__main__":
    unittest.main()
