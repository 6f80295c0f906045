"""Names of unfinished files and folders that no other process has, on whatever machine or in whatever container it runs."""

import functools
import glob
import os
import pathlib
import re
import secrets
import socket


@functools.cache
def place():
    """Where numbers of processes mean the same. Machines may share a name, and containers their machine's: so it has the machine's boot and the container's
    namespace, too. Without /proc this process is a place by itself.
    """
    try:
        boot = pathlib.Path("/proc/sys/kernel/random/boot_id").read_text()[:8]
        return f"{socket.gethostname()}-{boot}-{os.stat('/proc/self/ns/pid').st_ino}"
    except OSError:
        return f"{socket.gethostname()}-{secrets.token_hex(8)}"


def own_name(folder, begin, end, remove):
    """BEGIN, the place and this process. What ended processes of this place have left in the folder is removed: such names, with the regular expression END
    after them.
    """
    here = f"{begin}{place()}-"
    for left in folder.glob(f"{glob.escape(here)}*"):
        found = re.fullmatch(rf"(\d+){end}", left.name[len(here):])
        if found and not pathlib.Path(f"/proc/{found[1]}").exists():
            remove(left)
    return f"{here}{os.getpid()}"
