"""Prints version;folder of each installed package named (NAME or NAME==VERSION), ready for a CMake list.

Nothing is imported.
"""

import importlib.metadata
import sys

found = []
for word in sys.argv[1:]:
    name, _, version = word.partition("==")
    try:
        wheel = importlib.metadata.distribution(name)
    except importlib.metadata.PackageNotFoundError:
        sys.exit(f"expected the package {name}, found none")
    if version and wheel.version != version:
        sys.exit(f"expected {name} {version}, found {wheel.version}")
    found += [wheel.version, str(wheel.locate_file(name))]
print(";".join(found))
