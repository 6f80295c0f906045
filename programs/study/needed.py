"""Which Python packages `study` and `fit` need, and how to get those that are missing."""

import importlib.util
import pathlib
import sys

from steps import Failed

REQUIREMENTS = pathlib.Path(__file__).with_name("requirements.txt")
MODULES = {"pillow": "PIL", "flip-evaluator": "flip_evaluator"}
"""Of PyPI's names, where a module is called otherwise."""


def packages():
    """{PyPI's name: with its version}."""
    lines = [line.strip() for line in REQUIREMENTS.read_text().splitlines()]
    return {line.split("==")[0]: line for line in lines if line and not line.startswith("#")}


def is_missing(module):
    return importlib.util.find_spec(module) is None


def expect_packages(command):
    """Failed, and how to get them, where some are missing."""
    if missing := [pinned for name, pinned in packages().items() if is_missing(MODULES.get(name, name))]:
        raise Failed(f"{sys.executable}: expected the Python packages {', '.join(packages())}, found no {', '.join(name.split('==')[0] for name in missing)}; to get them: "
                     f"python3 -m venv ~/equistream-python && ~/equistream-python/bin/pip install {' '.join(packages().values())}, "
                     f"then EQUISTREAM_PYTHON=~/equistream-python/bin/python3 equistream {command} ...")
    try:
        import equistream  # noqa: F401
    except ImportError as error:
        raise Failed(f"{sys.executable}: expected the package equistream of this build, which is for one version of Python, found: {error}; "
                     f"EQUISTREAM_PYTHON names another Python") from None
