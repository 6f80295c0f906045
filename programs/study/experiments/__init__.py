"""What the study measures: name -> a function of SceneWork that gives what its JSON holds."""

import importlib

import presets

EXPERIMENTS = {name: importlib.import_module(f".{name}", __name__).run for name in presets.EXPERIMENTS}
