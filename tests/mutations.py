#!/usr/bin/env python3
"""One-line changes at random, and whether the changed folder's own tests notice.

usage: mutations.py BUILD --report FILE [--changes N] [--seed N] [--folders NAMES] [--again]

BUILD is a build folder of this checkout, without changes of its own: each change is made in place, built, tested and taken back. A folder's own
tests are the unit tests whose sources lie in the folder of the same name; where it has none, all of its parent's. Code that is a program or a plugin
has the tests that run it beside (RUN_BY). A change is *found* where a test fails, crashes or runs for ten times as long as before. It *survived* where
all pass, and *in no test* where none of them compiles the file. *no program* does not compile and does not count. Changes that are in the report
already are not made again. Read the survivors: set "equivalent" of one that cannot matter to the reason. --again makes the other ones once more,
with the tests that there are now.
"""

import argparse
import contextlib
import json
import pathlib
import random
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "programs/study"))
from steps import provenance, write_whole  # noqa: E402

FOLDERS = "plugin", "client", "host-adapters"
# Folders whose code other tests run too: targets to build, and those tests.
PIPELINE_TESTS = "client_plan_test", "client_choice_test", "client_views_test", "client_frame_player_test"
RUN_BY = {
    "host-adapters/mitsuba3": (("equistream-render-mitsuba", "equirect", "equirect_aov"),
                               ("golden.mitsuba_bad_input", "mitsuba.sensor", "mitsuba.modes", "mitsuba.geometry", "mitsuba.motion", "mitsuba.virtual",
                                "golden.mitsuba_own_xml", "golden.mitsuba_plain_xml")),
    "plugin/film": (("abi_test", "cryptomatte_test"), ("abi_test", "cryptomatte_test")),
    "host-adapters/import": (("equistream-import",), ("golden.import",)),
    "client/python": (("equistream_python",), ("python.frames", "python.reprojection")),
    "client/pipeline": (PIPELINE_TESTS, PIPELINE_TESTS),
    "client/view": (("equistream-view",), ("golden.viewer", "golden.viewer_program", "golden.viewer_face", "golden.hdr", "golden.unshown", "golden.headset",
                                           "golden.headset_session", "golden.live_view")),
    "client/web": (("equistream_web_page",), ("web.accuracy", "web.streams", "web.headset", "web.serve")),
}
FEWEST_TEST_S = 60
NUMBER = r"(?<![\w.])(\d+)(?![\w.'])"

# What is changed in a line of code: a pattern with spaces around operators, which templates and pointers have not; and what takes its place.
OPERATORS = [
    (r" < ", " <= "), (r" <= ", " < "), (r" > ", " >= "), (r" >= ", " > "), (r" == ", " != "), (r" != ", " == "),
    (r" \+ ", " - "), (r" - ", " + "), (r" \* ", " / "), (r" / ", " * "), (r" \+= ", " -= "), (r" -= ", " += "),
    (r" && ", " || "), (r" \|\| ", " && "), (r"!(?=[a-z_(])", ""), (r"\btrue\b", "false"), (r"\bfalse\b", "true"),
    (r"std::min\b", "std::max"), (r"std::max\b", "std::min"), (r"\+\+(?=\w)", "--"), (r"\bcontinue;", "break;"),
    (NUMBER, lambda found: str(int(found[1]) + 1)), (r"(?<![\w.])(\d+\.\d+)(?=f?\b)", lambda found: f"{2 * float(found[1]) + 1}"),
    (r"^(\s+)[a-z_][\w.>\-]*\(.*\);$", lambda found: f"{found[1]};"),
]
# Words of the language and of the build, not of what the code does.
NO_CODE = re.compile(r"^\s*(//|/?\*|#|using |template|static_assert|namespace|friend |typedef |assert|\[\[)|\blayout\(|ES_API")


def run(*words, timeout=None):
    return subprocess.run([str(word) for word in words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", timeout=timeout)


def code_lines(folders):
    """(file, line number) of all that may be changed."""
    for file in run("git", "ls-files", *folders).stdout.split():
        if file.endswith((".cpp", ".h", ".c", ".glsl")) and "/include/" not in file and "/example/" not in file:
            for number, line in enumerate((ROOT / file).read_text().splitlines()):
                if not NO_CODE.search(line) and '"' not in line and choices(line):
                    yield file, number


def choices(line):
    """What the line may become."""
    code = line.split("//")[0]
    changed = []
    for pattern, by in OPERATORS:
        for found in re.finditer(pattern, code):
            other = by(found) if callable(by) else by
            changed.append(line[:found.start()] + other + line[found.end():])
    return [each for each in changed if each != line]


def own_tests(build):
    """{folder: tests}, of every folder in tests/unit and of those above it."""
    tests = {}
    for lists in (ROOT / "tests/unit").glob("*/CMakeLists.txt"):
        for name, sources in re.findall(r"equistream_test\((\w+)\s+SOURCES\s+([^)]*?)(?:LIBRARIES|DEFINITIONS|LABELS|\))", lists.read_text()):
            for source in re.findall(r"(?<![\w}/-])[\w/]+\.cpp", sources):
                folder = pathlib.Path(lists.parent.name) / pathlib.Path(source).parent
                for place in (folder, *list(folder.parents)[:-1]):
                    tests.setdefault(str(place), set()).add(name)
    built = set(re.findall(r"Test +#\d+: (\w+)", run("ctest", "--test-dir", build, "-N").stdout))
    return {folder: names & built for folder, names in tests.items() if names & built}


def of_place(file, table):
    """What the table says of the file's folder, or of the nearest above it; None where it says nothing."""
    return next((table[str(place)] for place in pathlib.Path(file).parents if str(place) in table), None)


def subject_of(file, tests):
    """(targets, tests) that tell whether the file is right."""
    names = of_place(file, tests) or set()
    if "gl" in pathlib.Path(file).parts:
        names = names | tests["client/gl"]
    targets, others = of_place(file, RUN_BY) or ((), ())
    return (*sorted(names), *targets), (*sorted(names), *others)


@contextlib.contextmanager
def changed(file, number, line):
    before = (ROOT / file).read_text()
    lines = before.splitlines(keepends=True)
    lines[number] = line + "\n"
    (ROOT / file).write_text("".join(lines))
    try:
        yield
    finally:
        (ROOT / file).write_text(before)


def built(build, targets):
    """Whether they build; None where there was nothing to do."""
    done = run("cmake", "--build", build, "--target", *targets, "--", "-k", "1")
    return None if "ninja: no work to do" in done.stdout else done.returncode == 0


def outcome(build, name, seconds):
    """"passed", "failed" or "skipped"."""
    try:
        done = run("ctest", "--test-dir", build, "-R", f"^{re.escape(name)}$", "--no-tests=error", "--timeout", int(seconds), timeout=2 * seconds)
    except subprocess.TimeoutExpired:
        return "failed"
    return "failed" if done.returncode != 0 else "skipped" if "***Skipped" in done.stdout else "passed"


class Tests:
    """Each is timed without a change once, when it is first wanted."""

    def __init__(self, build):
        self.build, self.seconds = build, {}

    def time(self, names):
        for name in (name for name in names if name not in self.seconds):
            begun = time.monotonic()
            without_change = outcome(self.build, name, 600)
            if without_change != "passed":
                sys.exit(f"mutations.py: expected tests that pass without a change, found {name} {without_change}")
            self.seconds[name] = time.monotonic() - begun

    def noticing(self, names):
        """The first test that fails, the quickest first; None where none does."""
        for name in sorted(names, key=self.seconds.get):
            if outcome(self.build, name, max(FEWEST_TEST_S, 10 * self.seconds[name])) == "failed":
                return name
        return None

    def verdict(self, targets, names):
        is_built = built(self.build, targets)
        if not is_built:
            return {"verdict": "no program" if is_built is False else "in no test"}
        noticed = self.noticing(names)
        return {"verdict": "found", "by": noticed} if noticed else {"verdict": "survived"}


def nearest(file, line, before):
    """The number of the line that the change was made in, wherever it is by now; None where it is gone."""
    lines = (ROOT / file).read_text().splitlines() if (ROOT / file).exists() else []
    return min((number for number, text in enumerate(lines) if text.strip() == before), key=lambda number: abs(number + 1 - line), default=None)


def survivors(changes, folders):
    """(change, line number, what the line becomes) of those in these folders that survived and are there still."""
    for each in changes:
        if each["verdict"] in ("survived", "in no test") and "equivalent" not in each and each["file"].startswith(folders):
            number = nearest(each["file"], each["line"], each["before"])
            if number is None:
                print(f"{each['file']}:{each['line']}: {each['before']}: gone", flush=True)
                continue
            text = (ROOT / each["file"]).read_text().splitlines()[number]
            yield each, number, text.replace(each["before"], each["after"])


def summary(changes):
    found, equivalent = (sum(each["verdict"] == "found" for each in changes), sum("equivalent" in each for each in changes))
    survived = sum(each["verdict"] in ("survived", "in no test") for each in changes) - equivalent
    share = f"{100 * found / (found + survived):.0f} %" if found + survived else "none"
    return f"{found} found, {survived} survived, {equivalent} equivalent: {share}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--changes", type=int, default=200, help="that compile, in all (200)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folders", default=",".join(FOLDERS))
    parser.add_argument("--again", action="store_true", help="make the changes in --folders that survived once more, and no others")
    parser.add_argument("--report", type=pathlib.Path, required=True)
    asked = parser.parse_args()
    build = asked.build.resolve()
    if run("git", "status", "--porcelain", "--untracked-files=no", "--", *FOLDERS).stdout:
        sys.exit("mutations.py: expected a checkout without changes, found some")
    report = json.loads(asked.report.read_text()) if asked.report.exists() else {"seed": asked.seed, **provenance(build / "bin", ROOT), "changes": []}
    known = {(each["file"], each["line"]) for each in report["changes"]}
    folder_tests, tests = own_tests(build), Tests(build)

    def made(file, number, become):
        """The verdict."""
        targets, names = subject_of(file, folder_tests)
        if not names or built(build, targets) is False:
            sys.exit(f"mutations.py: expected tests of {file} that build, found {', '.join(names) or 'none'}")
        tests.time(names)
        with changed(file, number, become):
            said = tests.verdict(targets, names)
        built(build, targets)  # as they were: tests run other programs too
        print(f"{file}:{number + 1}: {become.strip()}: {said['verdict']} {said.get('by', '')}", flush=True)
        return said

    for each, number, become in list(survivors(report["changes"], tuple(asked.folders.split(",")))) if asked.again else ():
        each.update(made(each["file"], number, become))
        write_whole(asked.report, json.dumps(report, indent=1) + "\n")
    if asked.again:
        return print(summary(report["changes"]))
    chance = random.Random(asked.seed)
    lines = list(code_lines(asked.folders.split(",")))
    chance.shuffle(lines)
    for file, number in lines:
        text = (ROOT / file).read_text().splitlines()[number]
        become = chance.choice(choices(text))
        if sum(each["verdict"] != "no program" for each in report["changes"]) >= asked.changes:
            break
        if (file, number + 1) in known:
            continue
        said = made(file, number, become)
        report["changes"].append({"file": file, "line": number + 1, "before": text.strip(), "after": become.strip(), **said})
        write_whole(asked.report, json.dumps(report, indent=1) + "\n")
    print(summary(report["changes"]))


if __name__ == "__main__":
    main()
