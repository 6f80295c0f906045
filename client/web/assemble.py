#!/usr/bin/env python3
"""Makes the page: one HTML file of page.html, the modules, the shaders, and what both share with C++.

assemble.py PAGE_FOLDER NUMBERS_JSON OUT.html SHADER_FOLDER...
"""

import json
import pathlib
import re
import sys

IMPORT = re.compile(r'^import \{([^}]*)\} from "\./(\w+)\.js";\n', re.M)
TYPES = r"(?:Number|Truth|float|int|bool|Wrapping)"


def formulas_in_javascript(text):
    """The formulas of a .glsl.h file as functions of JavaScript (scalars.h says what such a text may use)."""
    text = re.sub(r"^///?.*\n", "", text, flags=re.M)
    text = re.sub(r"^struct \w+ \{.*?^\};\n", "", text, flags=re.M | re.S)
    text = re.sub(r"\b(\d[\d.]*(?:e-?\d+)?)f\b", r"\1", text)
    text = re.sub(r"^CONSTANT \w+ (\w+)", r"const \1", text, flags=re.M)

    def heading(found):
        names = re.findall(r"(\w+)(?:\[\d+\])?\s*(?:,|$)", found[2])
        return f"function {found[1]}({', '.join(names)}) {{"

    text = re.sub(rf"^FORMULA {TYPES} (\w+)\(([^)]*)\) \{{", heading, text, flags=re.M)
    text = re.sub(rf"^(\s+){TYPES} (\w+) =", r"\1let \2 =", text, flags=re.M)
    text = text.replace("grid.width / 2", "Math.trunc(grid.width / 2)")
    left = re.search(rf"\b(?:FORMULA|CONSTANT|struct|{TYPES} \w+)\b", text)
    if left:
        sys.exit(f"assemble.py: expected formulas that JavaScript can read, found '{left[0]}'")
    return text


def script(folder, main, find_text):
    """A module and those that it imports, each once and in a scope of its own, as one script."""
    parts, seen = ['"use strict";'], set()

    def add(name):
        if name in seen:
            return
        seen.add(name)
        text = (folder / f"{name}.js").read_text()
        for _, imported in IMPORT.findall(text):
            add(imported)
        text = IMPORT.sub(r"const {\1} = module_\2;\n", text)
        text = re.sub(r"^//#formulas (.*)$",
                      lambda found: "\n".join(formulas_in_javascript(find_text(name)) for name in found[1].split()), text,
                      flags=re.M)
        exported = re.findall(r"^export (?:async )?(?:class|const|function)\*? (\w+)", text, flags=re.M)
        for names in re.findall(r"^export \{(.*)\};\n", text, flags=re.M):
            exported += names.split(", ")
        text = re.sub(r"^export \{.*\};\n", "", text, flags=re.M)
        text = re.sub(r"^export ", "", text, flags=re.M)
        parts.append(f"const module_{name} = (() => {{\n{text}\nreturn {{{', '.join(exported)}}};\n}})();")

    add(main)
    return "\n".join(parts) + "\n"


def shader(name, find_text, included):
    """A shader's text for OpenGL ES: what it includes in its place, once, and without what ES does not know."""
    lines = []
    for line in find_text(name).splitlines():
        found = re.match(r'#include "(.*)"', line)
        if found:
            if found[1] not in included:
                included.add(found[1])
                lines.append(shader(found[1], find_text, included))
        elif not line.startswith("#extension"):
            line = re.sub(r"layout\((std140, )?binding = \d+\)", lambda m: "layout(std140)" if m[1] else "", line)
            lines.append(line.split("//")[0].rstrip())
    return "\n".join(line for line in lines if line)


def main():
    folder, numbers_file, out = (pathlib.Path(word) for word in sys.argv[1:4])
    files = {}
    for place in sys.argv[4:] + [str(folder / "shaders")]:
        for file in sorted(pathlib.Path(place).glob("*.glsl*")):
            if file.name in files and place == str(folder / "shaders"):
                sys.exit(f"assemble.py: {file}: expected a name of its own, found that of {files[file.name]}")
            files[file.name] = file

    def find_text(name):
        if name not in files:
            sys.exit(f"assemble.py: expected a shader file {name} in {', '.join(sys.argv[4:])}, found none")
        return files[name].read_text()

    numbers = json.loads(numbers_file.read_text())
    shaders = {"reading": numbers.pop("constants") + shader("shaders.glsl", find_text, set())}
    for file in sorted((folder / "shaders").glob("*.glsl")):
        shaders[file.stem] = shader(file.name, find_text, set())
    for name in ("mesh_vertex", "mesh_fragment"):
        shaders[name] = shader(f"{name}.glsl", find_text, set())

    def quoted(value):
        return json.dumps(value).replace("</", "<\\/")

    text = (folder / "page.html").read_text()
    for place, content in (("numbers", quoted(numbers)), ("shaders", quoted(shaders)),
                           ("worker", quoted(script(folder, "worker", find_text))),
                           ("main", script(folder, "main", find_text).replace("</", "<\\/"))):
        text = text.replace(f"/*{place}*/", content)
    out.write_text(text)


main()
