"""Prints version;folder of each installed package named, ready for a CMake list. Nothing is imported."""

import importlib.metadata
import sys

found = []
for name in sys.argv[1:]:
    try:
        wheel = importlib.metadata.distribution(name)
    except importlib.metadata.PackageNotFoundError:
        sys.exit(f"expected the package {name}, found none")
    found += [wheel.version, str(wheel.locate_file(name))]
print(";".join(found))
