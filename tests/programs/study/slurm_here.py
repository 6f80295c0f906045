"""A Slurm for tests, on this machine alone: munged, slurmctld and slurmd, started and ended here, with all their files in one folder.

It needs root, since slurmd starts jobs as their users, and Debian's packages slurmctld, slurmd and munge; no systemd, cgroups or accounting.
"""

import os
import pathlib
import secrets
import shutil
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo")
CONFIGURATION = """ClusterName=here
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge/socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=2
MpiDefault=none
ReturnToService=2
KillWait=10
MaxArraySize=1001
NodeName={host} NodeAddr=127.0.0.1 CPUs={processors} State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP OverSubscribe=FORCE:4
"""
PATIENCE_S = 60


def missing():
    """Why there can be none here, in a line; nothing where there can."""
    if absent := [name for name in PROGRAMS if not shutil.which(name)]:
        return f"no {', '.join(absent)} here (apt-get install slurmctld slurmd munge)"
    return None if os.geteuid() == 0 else "slurmd needs root, which this is not"


def free_ports(count):
    sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [each.getsockname()[1] for each in sockets]
    for each in sockets:
        each.close()
    return ports


class Slurm:
    """with Slurm(folder) as slurm: slurm.run("sbatch", ...). `folder` must be writable by its owner alone, as munged asks."""

    def __init__(self, folder):
        self.folder, self.started = pathlib.Path(folder), []
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf")}

    def start(self, *words):
        """A daemon, which ends with this program."""
        log = open(self.folder / f"{words[0]}.said", "wb")
        self.started.append((subprocess.Popen(["setpriv", "--pdeathsig", "TERM", *words], env=self.environment, stdout=log, stderr=log), log))

    def __enter__(self):
        for name in ("munge", "state", "spool"):
            (self.folder / name).mkdir(parents=True)
        munge, host = self.folder / "munge", socket.gethostname().split(".")[0]
        (munge / "key").write_bytes(secrets.token_bytes(128))
        (munge / "key").chmod(0o400)
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(host=host, folder=self.folder, ports=free_ports(2), processors=os.cpu_count()))
        try:
            self.start("munged", "--foreground", "--force", f"--socket={munge}/socket", f"--key-file={munge}/key", f"--log-file={munge}/log", f"--pid-file={munge}/pid",
                       f"--seed-file={munge}/seed")
            self.until(lambda: (munge / "socket").exists(), "munged's socket")
            self.start("slurmctld", "-D", "-c")
            self.start("slurmd", "-D", "-N", host)
            self.until(lambda: "idle" in self.run("sinfo", "--noheader", "--format=%T", check=False), "an idle node")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for process, log in reversed(self.started):
            process.terminate()
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            log.close()

    def run(self, *words, check=True, **more):
        done = subprocess.run([str(word) for word in words], env={**self.environment, **more}, capture_output=True, text=True)
        if check and done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, words))}: {done.stdout}{done.stderr}{self.logs()}")
        return done.stdout

    def logs(self):
        return "".join(f"\n{file.name}:\n{file.read_text(errors='replace')[-2000:]}" for file in sorted(self.folder.glob("*.log")))

    def until(self, is_so, what, patience_s=PATIENCE_S):
        end = time.monotonic() + patience_s
        while not is_so():
            if time.monotonic() > end:
                raise RuntimeError(f"expected {what} within {patience_s} s{self.logs()}")
            time.sleep(0.2)

    def jobs(self):
        """Lines of the queue: job, state."""
        return [line.split("|") for line in self.run("squeue", "--noheader", "--array", "--format=%i|%j|%T|%r").splitlines()]
