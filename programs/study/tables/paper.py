"""The paper's Table 2, MB per 150 frames at 1080p in H.264 at CRF 16 and 24, main and small right-eye stream; as its text gives it."""

STANDS_FOR = {"voxel-city": "Rungholt", "sponza-crytek": "Sponza", "san-miguel": "San Miguel", "kitchen": "Kitchen", "sibenik": "Sibenik"}
CRFS = (16, 24)
MEGABYTES = {
    "Rungholt": {"perspective": ((28.3, 9.83), (2.97, 1.28)), "equirect": ((27.9, 10.5), (2.85, 1.33))},
    "Sponza": {"perspective": ((27.7, 4.61), (1.77, 0.487)), "equirect": ((22.9, 3.88), (1.69, 0.502))},
    "San Miguel": {"perspective": ((37.1, 10.3), (2.94, 1.00)), "equirect": ((37.4, 10.9), (2.97, 1.08))},
    "Kitchen": {"perspective": ((16.3, 1.22), (0.567, 0.208)), "equirect": ((14.7, 1.05), (0.438, 0.151))},
    "Sibenik": {"perspective": ((21.1, 4.40), (1.79, 0.458)), "equirect": ((19.2, 4.05), (1.95, 0.492))},
}
"""Scene -> stream -> (main at each CRF, small at each CRF)."""


def streams(scene, crf):
    """MB of the perspective main and small stream, and of the equirect ones; None where the paper has no such scene or CRF."""
    name = STANDS_FOR.get(scene)
    if name is None or crf not in CRFS:
        return None
    at = CRFS.index(crf)
    return [MEGABYTES[name][source][track][at] for source in ("perspective", "equirect") for track in (0, 1)]
