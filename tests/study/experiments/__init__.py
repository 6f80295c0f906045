"""What the study measures: name -> a function of SceneWork that gives what its JSON holds; of each scene, or once, of scenes of its own."""

from . import latency, moved, parity, parsimony, related, sizes, stability, systems, where

OF_SCENES = {"systems": systems.run, "parity": parity.run, "sizes": sizes.run, "parsimony": parsimony.run, "where": where.run, "moved": moved.run, "related": related.run}
OF_THEIR_OWN = {"stability": stability.run, "latency": latency.run}
EXPERIMENTS = {**OF_SCENES, **OF_THEIR_OWN}
