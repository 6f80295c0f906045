#!/usr/bin/env python3
"""Words a sentence of the documentation's pages, and whether they keep to the limits.

    prose.py [--check] [--long] [PAGE ...]

A page's sentences have at most 18 words on average and at most 40 each; its lines, tables and links left
out, at most 100 columns. Code, tables, headings and pictures do not count. --check fails where a page
does not keep to that. --long prints the longest sentences.
"""

import argparse
import pathlib
import re
import sys

from markdown import LINK, ROOT, pages, sentences, without_code

AVERAGE, LONGEST, COLUMNS = 18, 40, 100
GENERATED = ("docs/results/study/tables.md", "docs/guide/reference/")


def figures(path):
    found = [len(words) for words in sentences((ROOT / path).read_text())]
    return found, sum(found) / max(1, len(found)), max(found, default=0)


def long_lines(path):
    text = LINK.sub(lambda match: match[1], without_code((ROOT / path).read_text()))
    return [line for line in text.splitlines() if len(line) > COLUMNS and not re.match(r" {4}| *\|| *`[^`]+`[.,;:]?$", line)]


def faults(path):
    _, average, longest = figures(path)
    if average > AVERAGE:
        yield f"{path}: expected at most {AVERAGE} words a sentence on average, found {average:.1f}"
    if longest > LONGEST:
        worst = max(sentences((ROOT / path).read_text()), key=len)
        yield f"{path}: expected at most {LONGEST} words in a sentence, found {longest}: {' '.join(worst)}"
    for line in long_lines(path):
        yield f"{path}: expected lines of at most {COLUMNS} columns, found {len(line)}: {line}"


def held():
    return [path for path in map(pathlib.Path.as_posix, pages()) if not path.startswith(GENERATED)]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail where a page does not keep to the limits")
    parser.add_argument("--long", action="store_true", help="print each page's sentences of more than 30 words")
    parser.add_argument("pages", nargs="*")
    options = parser.parse_args()
    if options.check:
        found = [fault for path in held() for fault in faults(path)]
        sys.exit("\n".join(found) if found else 0)
    for path in options.pages or held():
        lengths, average, longest = figures(path)
        print(f"{sum(lengths):7,} words {average:6.1f} a sentence, longest {longest:4}  {path}")
        for words in sentences((ROOT / path).read_text()) if options.long else []:
            if len(words) > 30:
                print(f"    {len(words)}: {' '.join(words)}")


if __name__ == "__main__":
    main()
