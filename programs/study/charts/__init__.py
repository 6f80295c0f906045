"""The study's charts, each drawn from its JSON results and nothing else."""
