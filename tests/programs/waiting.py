"""Waiting for what another process does."""

import time

import numpy as np


def wait_for(found, what, patience_s):
    """The first thing that found() gives which is not None or False."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        result = found()
        if isinstance(result, np.bool_):
            result = bool(result)  # which is not False itself
        if result is not None and result is not False:
            return result
        time.sleep(0.02)
    raise AssertionError(f"waited {patience_s} s for {what}")
