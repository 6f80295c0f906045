"""Steps that run a program once: done steps are skipped, and each leaves a record of command, time and memory.

A record is steps/NAME.json in the work folder. A step whose command or input is another by now runs again; so does one that is asked how long it takes and ran
beside others.
"""

import concurrent.futures
import contextlib
import hashlib
import importlib.util
import json
import os
import pathlib
import platform
import signal
import stat
import subprocess
import sys
import time

from options import Progress
from own_names import own_name


HERE = pathlib.Path(__file__).resolve().parent
REPOSITORY = next(folder for folder in (HERE.parents[1], HERE.parent) if (folder / "scenes/descriptions").is_dir() or folder == HERE.parent)
"""The checkout; of an installation the folder with its scenes' descriptions."""
RESULTS = REPOSITORY / "docs/results/study"
USAGE = 2
"""The exit status of every command that was given wrong words or input: trying again would not help."""


class Failed(Exception):
    pass


class Refused(Failed):
    """What was asked for is wrong: the exit status is that of bad usage or input."""


REQUIREMENTS = pathlib.Path(__file__).with_name("requirements.txt")
MODULES = {"pillow": "PIL", "flip-evaluator": "flip_evaluator"}
"""Of PyPI's names, where a module is called otherwise."""


def packages():
    """{PyPI's name: with its version}."""
    lines = [line.strip() for line in REQUIREMENTS.read_text().splitlines()]
    return {line.split("==")[0]: line for line in lines if line and not line.startswith("#")}


def is_missing(module):
    return importlib.util.find_spec(module) is None


def expect_packages(command):
    """Failed, and how to get them, where some are missing."""
    if missing := [pinned for name, pinned in packages().items() if is_missing(MODULES.get(name, name))]:
        raise Failed(f"{sys.executable}: expected the Python packages {', '.join(packages())}, found no {', '.join(name.split('==')[0] for name in missing)}; to get them: "
                     f"python3 -m venv ~/equistream-python && ~/equistream-python/bin/pip install {' '.join(packages().values())}, "
                     f"then EQUISTREAM_PYTHON=~/equistream-python/bin/python3 equistream {command} ...")
    try:
        import equistream  # noqa: F401
    except ImportError as error:
        raise Failed(f"{sys.executable}: expected the package equistream of this build, which is for one version of Python, found: {error}; "
                     f"EQUISTREAM_PYTHON names another Python; to build it: cmake --build --preset release --target programs") from None


def aside_of(file):
    """A name of this process's own: several may make the same file at once. What processes that ended have left goes."""
    own = own_name(file.parent, f"{file.name}.", r"\.unfinished", lambda left: left.unlink(missing_ok=True))
    return file.with_name(f"{own}.unfinished")


@contextlib.contextmanager
def made_whole(file):
    """Yields a temporary name. On success it becomes `file`; on failure it is removed, and the error names `file`."""
    aside = aside_of(file)
    try:
        yield aside
        os.replace(aside, file)
    except BaseException as error:
        with contextlib.suppress(OSError):
            aside.unlink()
        names = {str(name) for name in (error.filename, error.filename2) if name is not None} if isinstance(error, OSError) else set()
        if isinstance(error, OSError) and error.errno and (not names or str(aside) in names):
            raise OSError(error.errno, error.strerror, str(file)) from None
        raise


def write_whole(file, content):
    """Text or bytes; appears whole or not at all."""
    file = pathlib.Path(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    with made_whole(file) as aside:
        aside.write_bytes(content if isinstance(content, bytes) else content.encode())


def read_json(file):
    try:
        return json.loads(pathlib.Path(file).read_text(encoding="utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise Failed(f"{file}: expected JSON, found something else: {error}") from None


def write_if_other(file, text):
    """Leaves a file that says the same as it is, so that what was made of it stays as good as it was."""
    if not pathlib.Path(file).exists() or pathlib.Path(file).read_text() != text:
        write_whole(file, text)


def changed_at(path):
    """When a file, or the newest in a folder or of a scene, was last written; 0 where there is nothing."""
    return max((file.stat().st_mtime for file in files_in(path) if file.is_file()), default=0)


def scene_files(description):
    """What a scene's description names, where docs/scenes.md says that it is looked for: itself, the model, the sky's image and the paths. What the model names
    is in the scene's fingerprint (scene_work.py).
    """
    scene = read_json(description)
    folder, shared = description.parent, pathlib.Path(os.environ.get("EQUISTREAM_SCENES") or description.parent)
    sky = scene.get("sky")
    large = [scene["model"], *([sky["image"]] if isinstance(sky, dict) and "image" in sky else [])]
    places = [[folder / name, shared / name, shared / pathlib.Path(name).stem / name] for name in large]
    paths = [folder / each["path"] for each in (scene["camera"], *scene.get("moving", ())) if "path" in each]
    return [description, *(file for found in places for file in [place for place in found if place.is_file()][:1]), *(path for path in paths if path.is_file())]


def files_in(path):
    """Of a file or a folder, also behind links, and of a scene by its description."""
    if path.is_dir():
        return (pathlib.Path(folder, name) for folder, _, names in os.walk(path, followlinks=True) for name in names)
    if path.suffix == ".json" and path.is_file():
        with contextlib.suppress(Failed, KeyError, TypeError, AttributeError):
            return scene_files(path)
    return [path]


def state_of(named):
    """How many of these (name, file) there are, their bytes, and a digest of names, sizes and times, as `state`. A file that was written anew or replaced
    changes it, be it newer or older.
    """
    found = []
    for name, file in named:
        with contextlib.suppress(OSError):
            status = file.stat()
            if stat.S_ISREG(status.st_mode):
                found.append((str(name), status.st_size, status.st_mtime_ns // 10 ** 6))
    return {"files": len(found), "bytes": sum(size for _, size, _ in found), "state": hashlib.sha256(repr(sorted(found)).encode()).hexdigest()[:16]}


def digest(folder, pattern="equistream*"):
    """Of the bytes of programs, or of other files, so that a step is done again when they change."""
    sums = hashlib.sha256()
    for file in sorted(folder.glob(pattern)):
        sums.update(file.read_bytes())
    return sums.hexdigest()


# In front of a program that is started (util-linux): it ends when what started it is killed, or the next run would find its folder in use.
ENDS_WITH_PARENT = "setpriv", "--pdeathsig", "TERM", "--"


OUTPUTS = "--out", "--pictures", "--difference"
"""Options of programs that name what is made."""


class Steps:
    """Runs `equistream` in a work folder; commands name files relative to it, so records do not depend on the machine."""

    def __init__(self, work, programs, aliases, settings, progress=None):
        self.work = pathlib.Path(work)
        self.program = pathlib.Path(programs).resolve() / "equistream"
        self.aliases = aliases  # path prefixes of this machine -> what records say instead
        self.context = {**settings, "programs": digest(self.program.parent)}  # with "scene": its fingerprint, where that is known
        self.progress = progress or Progress("steps")
        self.running, self.beside, self.stopped = set(), 0, False
        self.since = 0  # what was recorded before is done again, but for renders: a time.time()
        if not self.program.is_file():
            raise Failed(f"{self.program}: expected the built program, found nothing (give --bin)")

    def recorded(self, words):
        text = " ".join(["equistream", *words])
        for prefix, alias in self.aliases.items():
            text = text.replace(str(prefix), alias)
        return text

    def inputs_changed_at(self, words):
        """Of all words that name a file or folder, in the work folder or elsewhere, but for the output."""
        inputs = [word for word, before in zip(words, ["", *words]) if before != "--out"]
        return max((changed_at(self.work / word) for word in inputs if word), default=0)

    def inputs_state(self, words):
        """state_of() the same, but for the command's name, and for outputs by whatever word."""
        made = {word for word, before in zip(words, ["", *words]) if before in OUTPUTS}
        given = [self.work / word for word in words[1:] if word and word not in made]
        return state_of((f"{number} {file.relative_to(path) if path in file.parents else file.name}", file)
                        for number, path in enumerate(given) for file in files_in(path))

    def has_inputs(self, record, file, words, inputs):
        """Whether they are as they were when the step began. Records of before say nothing of them: none may be newer."""
        return record["inputs"] == inputs if "inputs" in record else self.inputs_changed_at(words) <= file.stat().st_mtime

    def is_of_here(self, record, is_render):
        """Frames of a render are kept or refused by their own manifest; everything made of them is as old as programs and settings. Both are of one scene: of
        this one, where the record does not say.
        """
        before, now = record.get("context") or {}, self.context
        if "scene" in before and before["scene"] != now.get("scene", before["scene"]):
            return False
        return is_render or {**before, "scene": None} == {**now, "scene": None}

    def is_made(self, words):
        """Whether what was made still lies there."""
        return all((self.work / word).exists() for word, before in zip(words, ["", *words]) if before == "--out")

    def side_by_side(self, function, *arguments):
        """[function(...) of the first of each of `arguments`, of the second, ...], as many at once as there are cores. What fails or interrupts one ends all."""
        self.beside += 1
        try:
            with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
                try:
                    results = [pool.submit(function, *each) for each in zip(*arguments, strict=True)]
                    for done in concurrent.futures.as_completed(results):
                        done.result()
                except BaseException:
                    self.stop()
                    pool.shutdown(wait=False, cancel_futures=True)
                    raise
            return [done.result() for done in results]
        finally:
            self.beside -= 1

    def stop(self):
        """What runs, and whatever would be started from now on."""
        self.stopped = True
        for pid in list(self.running):
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)

    @staticmethod
    def json_in(file):
        """Nothing where there is no file, or where a crash has left half of one."""
        try:
            return json.loads(file.read_text())
        except (FileNotFoundError, ValueError, RecursionError):
            return None

    @staticmethod
    def record_in(file):
        """What a step has left; nothing where that is not there, or not whole: the step runs again."""
        record = Steps.json_in(file)
        return record if isinstance(record, dict) and "command" in record else None

    def has_said(self, name, words):
        """Whether what the step printed is there, and whole."""
        output = self.work / "steps" / f"{name}.out"
        return self.json_in(output) is not None if "--json" in words else output.exists()

    def run(self, name, *words, fresh=None, timed=False):
        """`fresh` is the output that must not exist for the time taken to be that of the whole step; `timed`: it must have run alone."""
        words = [str(word) for word in words]
        file = self.work / "steps" / f"{name}.json"
        command, inputs, is_render = self.recorded(words), self.inputs_state(words), fresh is not None
        if record := self.record_in(file):
            is_there = self.is_made(words) and self.has_said(name, words) and (is_render or file.stat().st_mtime >= self.since)
            is_as_it_was = record["command"] == command and self.is_of_here(record, is_render) and self.has_inputs(record, file, words, inputs)
            if is_there and is_as_it_was and not (timed and record.get("beside")):
                return self.told_of(record)
        resumed = is_render and (self.work / fresh).exists()
        self.progress.begin(name, command)
        errors = self.work / "steps" / f"{name}.log"
        errors.parent.mkdir(parents=True, exist_ok=True)
        start = time.monotonic()
        beside = self.beside > 0
        output = errors.with_suffix(".out")
        aside = aside_of(output)
        try:
            with open(errors, "wb") as log, open(aside, "wb") as out:
                code, usage = self.waited_for(words, out, log)
        except BaseException:
            aside.unlink(missing_ok=True)
            raise
        wall_s = time.monotonic() - start
        if code != 0:
            aside.unlink(missing_ok=True)
            lines = errors.read_text(errors="replace").strip().splitlines()
            raise (Refused if code == USAGE else Failed)(f"{command}: exit {code}: {lines[-1] if lines else 'no message'}")
        os.replace(aside, output)
        record = {"command": command, "context": self.context, "inputs": inputs, "wall_s": round(wall_s, 3), "resumed": resumed,
                  **({"beside": True} if beside else {}), "cpu_s": round(usage.ru_utime + usage.ru_stime, 3),
                  "peak_memory_mib": round(usage.ru_maxrss / 1024, 1)}
        write_whole(file, json.dumps(record, indent=1) + "\n")
        return self.told_of(record)

    @staticmethod
    def told_of(record):
        """What results may hold of it: times of files are this folder's own."""
        return {key: value for key, value in record.items() if key != "inputs"}

    def waited_for(self, words, out, log):
        """Its exit code and what it used."""
        if self.stopped:
            raise Failed("stopped")
        # A step's views are its own: those of other settings, or of an earlier preset, make way.
        own = ["--overwrite"] if words[0] == "play" else []
        process = subprocess.Popen([*ENDS_WITH_PARENT, self.program, *words, *own], cwd=self.work, stdout=out, stderr=log)
        self.running.add(process.pid)
        try:
            if self.stopped:
                os.kill(process.pid, signal.SIGTERM)
            _, status, usage = os.wait4(process.pid, 0)
        except KeyboardInterrupt:
            process.terminate()
            process.wait()
            raise
        finally:
            self.running.discard(process.pid)
        process.returncode = os.waitstatus_to_exitcode(status)
        return process.returncode, usage

    @contextlib.contextmanager
    def keeping(self, name, made_something):
        """What was recorded of a step that prints JSON stays, where running it again makes nothing: made_something(its output) says so."""
        file = self.work / "steps" / f"{name}.json"
        before = (self.record_in(file), self.output_of(name)) if self.record_in(file) and self.has_said(name, ["--json"]) else None
        yield
        after = self.record_in(file)
        if before and before[0] != after and not made_something(self.output_of(name)):
            write_whole(file.with_suffix(".out"), before[1])
            # Of the inputs as they are: else it would run again every time.
            write_whole(file, json.dumps({**before[0], "inputs": after["inputs"]}, indent=1) + "\n")

    def output_of(self, name):
        return (self.work / "steps" / f"{name}.out").read_text()


def measured_json(program, words, folder):
    """What a built program prints as JSON, run in `folder`."""
    program, words = pathlib.Path(program).resolve(), [str(word) for word in words]
    if not program.is_file():
        raise Failed(f"{program}: expected the built program, found nothing (give --bin)")
    done = subprocess.run([*ENDS_WITH_PARENT, program, *words], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        raise Failed(f"{' '.join([program.name, *words])}: exit {done.returncode}: {done.stderr.strip()}")
    return json.loads(done.stdout)


def run_as_program(main, name=None):
    """One clear line for what failed, under the command's name or the script's."""
    name = name or pathlib.Path(sys.argv[0]).name
    try:
        main()
        if sys.stdout:  # none where it was closed
            sys.stdout.flush()
    except Refused as refusal:
        print(f"{name}: {refusal}", file=sys.stderr)
        sys.exit(USAGE)
    except Failed as failure:
        sys.exit(f"{name}: {failure}")
    except BrokenPipeError:  # nobody reads on
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        sys.exit(f"{name}: {where}{error.strerror or error}")
    except KeyboardInterrupt:
        for stream, line in ((sys.stderr, f"{name}: interrupted; run it again to go on\n"), (sys.stdout, "")):
            with contextlib.suppress(OSError, AttributeError):  # it may be closed, or nobody reads
                stream.write(line)
                stream.flush()
        # By the signal itself, so that a shell's loop around it ends too.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        os.kill(os.getpid(), signal.SIGINT)


def machine():
    """What ran the programs, without saying whose it is."""
    cpu = {}
    for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines():
        key, _, value = line.partition(":")
        cpu.setdefault(key.strip(), value.strip())
    memory_kib = int(pathlib.Path("/proc/meminfo").read_text().split()[1])
    system = "unknown"
    with contextlib.suppress(OSError):  # containers may have no such file
        system = platform.freedesktop_os_release()["PRETTY_NAME"]
    vectors = next((name for flag, name in (("avx512f", "AVX-512"), ("avx2", "AVX2")) if flag in cpu.get("flags", "").split()), "none told")
    return {"cpu": cpu.get("model name", "unknown"), "vectors": vectors, "cores": len(os.sched_getaffinity(0)),
            "memory_gib": round(memory_kib / 1024 ** 2, 1), "system": system,
            "gpu": "none used", "load_average_at_start": round(os.getloadavg()[0], 2)}


def provenance(programs, repository):
    """When, of which versions and on what machine a result is made: keys that every result has."""
    return {"made": time.strftime("%Y-%m-%d", time.gmtime()), "versions": versions(pathlib.Path(programs) / "equistream", repository),
            "machine": machine()}


def versions(program, repository):
    def first_line(*command):
        try:
            return subprocess.run(command, capture_output=True, text=True).stdout.splitlines()[0]
        except (OSError, IndexError):
            return "unknown"

    return {"equistream": first_line(str(program), "--version"),
            "commit": first_line("git", "-C", str(repository), "rev-parse", "--short=12", "HEAD"),
            "ffmpeg": " ".join(first_line("ffmpeg", "-version").split()[:3]), "python": sys.version.split()[0]}
