"""Runs a notebook's cells in order with plain Python, and keeps what a kernel would: what they print, and their figures.

    notebook.py NOTEBOOK     (writes its outputs into it, with PYTHONPATH as the notebook needs it)
"""

import base64
import contextlib
import io
import json
import os
import pathlib
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402


def picture():
    """Of the figure that is open, as a notebook keeps it; 96 colours take a third of the bytes."""
    from PIL import Image

    drawn, small = io.BytesIO(), io.BytesIO()
    plt.savefig(drawn, format="png")
    Image.open(drawn).convert("RGB").quantize(96).save(small, "png", optimize=True)
    return {"output_type": "display_data", "metadata": {}, "data": {"image/png": base64.b64encode(small.getvalue()).decode(), "text/plain": ["<Figure>"]}}


def run(notebook):
    """The outputs of each code cell, and the names that they leave."""
    names, found = {"__name__": "__main__"}, []
    for i, cell in enumerate(cell for cell in notebook["cells"] if cell["cell_type"] == "code"):
        outputs, printed = [], io.StringIO()
        plt.show = lambda: (outputs.append(picture()), plt.close("all"))
        with contextlib.redirect_stdout(printed):
            exec(compile("".join(cell["source"]), f"cell {i + 1}", "exec"), names)
        if printed.getvalue():
            outputs.append({"output_type": "stream", "name": "stdout", "text": printed.getvalue().splitlines(True)})
        found.append(outputs)
    return found, names


def main():
    file = pathlib.Path(sys.argv[1]).resolve()
    notebook = json.loads(file.read_text())
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        found, _ = run(notebook)
    for i, (cell, outputs) in enumerate(zip((cell for cell in notebook["cells"] if cell["cell_type"] == "code"), found)):
        cell["outputs"], cell["execution_count"] = outputs, i + 1
    file.write_text(json.dumps(notebook, indent=1) + "\n")


if __name__ == "__main__":
    main()
