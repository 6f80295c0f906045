"""What ./bench prints, as a result with the machine and the version."""

import subprocess

from steps import Failed, provenance


def bench_result(programs, repository, figures_regex):
    """Every figure whose name matches, each beside its peers. To be run on a machine that does nothing else."""
    command = [programs.resolve() / "equistream_bench", f"--benchmark_filter={figures_regex}"]
    made = provenance(programs, repository)
    done = subprocess.run(command, cwd=repository, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        raise Failed(f"equistream_bench: exit {done.returncode}: {done.stderr.strip()}")
    figures = []
    for line in done.stdout.splitlines():
        name, value, unit, ratio, peer = line.split()
        figures.append({"name": name, unit: float(value), "ratio": None if ratio == "-" else float(ratio), "peer": peer})
    peers_alone = sorted({figure["name"] for figure in figures if "/" in figure["name"]})
    if peers_alone:
        raise Failed(f"equistream_bench: expected ours beside every peer, found alone: {', '.join(peers_alone)}")
    notes = [line[2:] for line in done.stderr.splitlines() if line.startswith("# ")]
    return {"command": f"./bench '{figures_regex}'", "notes": notes, "figures": figures, **made}
