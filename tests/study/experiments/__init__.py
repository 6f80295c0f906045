"""What the study measures of a scene: name -> a function of SceneWork that gives what its JSON holds."""

from . import parity, parsimony, sizes, systems

EXPERIMENTS = {"systems": systems.run, "parity": parity.run, "sizes": sizes.run, "parsimony": parsimony.run}
