"""Waiting for what another process does."""

import time


def wait_for(found, what, patience_s):
    """The first thing that found() gives which is not None or False."""
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        result = found()
        if result is not None and result is not False:
            return result
        time.sleep(0.02)
    raise AssertionError(f"waited {patience_s} s for {what}")
