"""The lines, ways and times of streaming.py, which its tables know too."""

from emulated import Line

LINES = {
    "nothing lost": Line(),
    "1 % lost": Line(loss=0.01),
    "5 % lost": Line(loss=0.05),
    "10 % lost": Line(loss=0.1),
    "20 % lost": Line(loss=0.2),
    "200 ms of jitter, packets overtake": Line(jitter_s=0.2),
    "5 % lost, 200 ms of jitter": Line(loss=0.05, jitter_s=0.2),
    "silence of 1 s": Line(silent=(3, 4)),
    "a tenth of the stream's rate": Line(mbit_s=0.74),  # of motion.mkv
}
WAYS = {"tcp": "tcp", "tls": "tls", "srt": "srt", "srt-parity-4": "srt", "reno": "tcp"}
"""Scheme of the address. reno: --other-bin's."""
QUERIES = {"srt-parity-4": "?parity=4"}
"""What else the address says."""
SEEDS = (1, 2)

LIVE = ("--size", "480x240", "--spp", "4", "--rate", "4")
LIVE_SHARES = ((0, 1e9), (8, None), (24, 1e9))
"""From that second on the line carries so many Mbit/s; None: a tenth of what it carried until then."""
LIVE_S, SETTLED_S = 40, 8
LIVE_WAYS = "tcp", "tls", "srt"

LOSSY_LINES = "nothing lost", "5 % lost", "20 % lost"
LOSSY_WAYS = "tcp", "srt"
LOSSY_S = 20
LIVE_KINDS = {"sphere": (), "window": ("--window", "120x90")}
TILES, TILED = "6x3", "recorded tiles"

AS_SOON_S, AS_FINE_CRF, IN_A_ROW = 0.05, 1, 5
"""Spheres come as before again where so many follow each other that are at most so much later, or coded so much coarser, than the median was before."""


def recovery_s(spheres, over_s, most):
    """`spheres`: when each came, and a figure of it. How long after `over_s` the figures are `most` at most again; None: not before the end."""
    after = [(at_s - over_s, figure <= most) for at_s, figure in spheres if at_s >= over_s]
    rows = zip(*(after[i:] for i in range(IN_A_ROW)))
    return next((row[0][0] for row in rows if all(is_well for _, is_well in row)), None)
