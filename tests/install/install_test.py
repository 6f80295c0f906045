"""Installs a build into a folder, moves the folder, and uses it as its users would: runs the programs, compiles each
header alone, builds the example host and the example clients both by pkg-config and by find_package, and runs them.

usage: install_test.py CMAKE BUILD_DIR SOURCE_DIR      (CC, CXX, CFLAGS and CXXFLAGS from the environment)
"""
import contextlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parents[1] / folder) for folder in ("programs", "programs/viewer")]
import display  # noqa: E402

HEADERS = {  # each with the languages it promises to be
    "abi_types.h": ["c11", "c++17"],
    "equistream.h": ["c11", "c++17"],
    "conventions.h": ["c++17"],
    "camera.h": ["c++17"],
    "image_motion.h": ["c++17"],
    "bound.h": ["c++17"],
    "aov.h": ["c++17", "c++20"],
    "client.h": ["c11", "c++17"],
    "client.hpp": ["c++17", "c++20"],
}
USES_THE_CATALOGUE = '''
#include <equistream/aov.h>
static_assert(equistream::find_aov("depth")->unit == "m");
int main() { return equistream::aov_catalogue().size() > 0 ? 0 : 1; }
'''


def run(*command, env=None, cwd=None):
    done = subprocess.run([str(word) for word in command], env=env, cwd=cwd, text=True, capture_output=True)
    assert done.returncode == 0, f"{shlex.join(map(str, command))}: {done.returncode}\n{done.stdout}{done.stderr}"
    return done.stdout


def compiler(language):
    name, flags = ("CC", "CFLAGS") if language.startswith("c1") else ("CXX", "CXXFLAGS")
    return [os.environ[name], *shlex.split(os.environ.get(flags, "")), f"-std={language}", "-Wall", "-Wextra",
            "-pedantic", "-Werror"]


def install_and_move(cmake, build, scratch):
    run(cmake, "--install", build, "--prefix", scratch / "first")
    (scratch / "first").rename(scratch / "moved")
    return scratch / "moved"


def check_programs(prefix):
    dispatcher = prefix / "bin" / "equistream"
    assert run(dispatcher, "--version").startswith("equistream ")
    commands = re.findall(r"^  ([a-z]+) ", run(dispatcher, "--help"), re.MULTILINE)
    assert {"render", "serve", "view", "import", "export", "model", "study", "doctor"} <= set(commands), commands
    assert (prefix / "share/equistream/web.html").exists()
    for command in commands:
        assert "--help" in run(dispatcher, command, "--help"), command
        assert (prefix / f"share/man/man1/equistream-{command}.1").exists(), command
    assert "complete " in (prefix / "share/bash-completion/completions/equistream").read_text()
    libraries = run("ldd", prefix / "bin" / "equistream-render-embree").splitlines()
    ours = [line.split()[2] for line in libraries if "libequistream" in line]
    assert len(ours) == 1 and Path(ours[0]).resolve().is_relative_to(prefix.resolve()), libraries


def check_study(prefix, scratch):
    """Python in share/, which says what it needs and, where it has it, runs; left out where the build has no Python package."""
    dispatcher = prefix / "bin/equistream"
    bare = {**os.environ, "EQUISTREAM_PYTHON": scratch / "bare/bin/python3"}
    run(sys.executable, "-m", "venv", "--without-pip", scratch / "bare")
    for words in (["study", "--preset", "smoke", "--out", scratch / "study"], ["fit", scratch / "fit/sphere.json", "--db", "20"]):
        run(dispatcher, "scene", "generate", "sphere", "--out", scratch / "fit")
        refused = subprocess.run([dispatcher, *words], env=bare, text=True, capture_output=True)
        said = refused.stderr.splitlines()
        assert refused.returncode == 1 and len(said) == 1, refused.stderr
        assert said[0].startswith(f"equistream {words[0]}: ") and "pip install numpy==" in said[0], said[0]
    if not list(prefix.rglob("equistream/python/equistream/_core.*.so")):
        return
    own = {**os.environ, "EQUISTREAM_PYTHON": sys.executable}
    planned = subprocess.run([dispatcher, "farm", "--measured", scratch, "--out", scratch / "farm", "study", "--preset", "small", "--out", scratch / "study"], env=own, text=True, capture_output=True)
    assert planned.returncode == 2 and "expected a measured result" in planned.stderr, planned.stderr


def check_mitsuba(prefix, scratch):
    """Plugins and the converter are found from where the program now lies; left out where the build has no Mitsuba."""
    if not (prefix / "bin/equistream-render-mitsuba").exists():
        return
    scene = scratch / "ball.xml"
    scene.write_text('<scene version="3.0.0"><shape type="sphere"/></scene>')
    dispatcher = prefix / "bin/equistream"
    render = [dispatcher, "render", "--host", "mitsuba", "--size", "16x8", "--spp", 1, "--aovs", "depth"]
    run(*render, scene, "--out", scratch / "ball")
    assert (scratch / "ball/centre/frame.0000.exr").exists()
    run(dispatcher, "scene", "generate", "sphere", "--out", scratch / "ours")
    run(*render, scratch / "ours/sphere.json", "--frames", 0, "--out", scratch / "sphere")
    assert (scratch / "sphere/centre/frame.0000.exr").exists()


def check_headers(prefix, flags, scratch):
    installed = {file.name for file in (prefix / "include" / "equistream").iterdir()}
    assert installed == set(HEADERS), installed
    for header, languages in HEADERS.items():
        for language in languages:
            source = scratch / ("alone.c" if language.startswith("c1") else "alone.cpp")
            source.write_text(f"#include <equistream/{header}>\nint main(void) {{ return 0; }}\n")
            run(*compiler(language), *flags, "-fsyntax-only", source)
    source.write_text(USES_THE_CATALOGUE)
    run(*compiler("c++17"), *flags, source, "-o", scratch / "catalogue")
    run(scratch / "catalogue")


def host_by_pkg_config(example, flags, libraries, scratch):
    host = scratch / "by_pkg_config"
    run(*compiler("c11"), *flags, example / "toy_host.c", example / "toy_renderer.c", *libraries, "-lm", "-o", host)
    return host


def host_by_find_package(cmake, example, prefix, scratch):
    build = scratch / "build"
    run(cmake, "-G", "Ninja", "-S", example, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}")
    run(cmake, "--build", build)
    assert f"equistream_DIR:PATH={prefix}" in (build / "CMakeCache.txt").read_text()
    return build / "toy_host"


def check_components(cmake, prefix, scratch):
    """Both components are found, and one that there is not is refused, unless it is optional."""
    project = scratch / "components"
    project.mkdir()
    for components, good in (("plugin", True), ("client", True), ("plugin client", True), ("player", False),
                             ("client OPTIONAL_COMPONENTS player", True)):
        (project / "CMakeLists.txt").write_text(
            "cmake_minimum_required(VERSION 3.25)\nproject(probe LANGUAGES C CXX)\n"
            f"find_package(equistream 0.1 REQUIRED COMPONENTS {components})\n"
            "if(equistream_player_FOUND)\n  message(FATAL_ERROR \"there is no player\")\nendif()\n")
        done = subprocess.run([cmake, "-G", "Ninja", "-S", project, "-B", scratch / f"built {components}",
                               f"-DCMAKE_PREFIX_PATH={prefix}"], text=True, capture_output=True)
        assert (done.returncode == 0) == good, done.stdout + done.stderr
        assert good or "expected components plugin or client, found 'player'" in done.stderr, done.stderr


def pngs_of(client, frames, out, env):
    out.mkdir()
    run(client, frames, out, 2, env=env)
    return [(out / f"{eye}.{index:04}.png").read_bytes() for eye in ("left", "right") for index in (0, 1)]


def check_clients(cmake, example, prefix, packages, frames, scratch):
    """Both ways give the same pictures, which are not blank; the window shows the stream for a second."""
    by_pkg_config = scratch / "write_pngs"
    shutil.copy(example / "write_pngs.c", scratch)
    lines = (example / "write_pngs.c").read_text().splitlines()
    command = next(line.strip(" *") for line in lines if "cc write_pngs.c" in line)  # as it says itself
    run("sh", "-c", command.replace("cc", shlex.join(compiler("c11")), 1), env=packages, cwd=scratch)
    build = scratch / "clients"
    run(cmake, "-G", "Ninja", "-S", example, "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}")
    run(cmake, "--build", build)
    found = {**os.environ, "LD_LIBRARY_PATH": str(next(prefix.rglob("libequistream_client.so")).parent)}
    first, second = pngs_of(by_pkg_config, frames, scratch / "three", found), pngs_of(build / "write_pngs", frames, scratch / "four", os.environ)
    assert first == second, "the two builds of the example write different pictures"
    assert first[0] != first[2] and min(map(len, first)) > 5000, [len(png) for png in first]
    refused = subprocess.run([by_pkg_config, scratch / "nothing.mp4", scratch, "1"], env=found, text=True, capture_output=True)
    assert refused.returncode != 0 and "nothing.mp4" in refused.stderr, refused.stderr
    with contextlib.closing(display.Display()) as shown:
        run(build / "window", frames, 1, env=shown.environment)


def frames_of(host, out, env):
    run(host, out, env=env)
    return [(out / f"frame.{index:04}.exr").read_bytes() for index in (0, 1)]


def main():
    cmake, build, source = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
    example = source / "host-adapters/example"
    with tempfile.TemporaryDirectory() as folder:
        scratch = Path(folder).resolve()
        prefix = install_and_move(cmake, build, scratch)
        check_programs(prefix)
        check_study(prefix, scratch)
        check_mitsuba(prefix, scratch)
        library_dir = next(prefix.rglob("libequistream.so")).parent
        packages = {**os.environ, "PKG_CONFIG_PATH": str(library_dir / "pkgconfig")}
        flags = shlex.split(run("pkg-config", "--cflags", "equistream", env=packages))
        libraries = shlex.split(run("pkg-config", "--libs", "equistream", env=packages))
        check_headers(prefix, flags, scratch)
        found = {**os.environ, "LD_LIBRARY_PATH": str(library_dir)}
        by_pkg_config = frames_of(host_by_pkg_config(example, flags, libraries, scratch), scratch / "one", found)
        by_find_package = frames_of(host_by_find_package(cmake, example, prefix, scratch), scratch / "two", os.environ)
        assert by_pkg_config == by_find_package, "the two builds of the example write different frames"
        check_components(cmake, prefix, scratch)
        check_clients(cmake, source / "client/example", prefix, packages, scratch / "one", scratch)
        described = run(prefix / "bin" / "equistream", "info", scratch / "one")
        assert "256x128" in described, described
    print("installed, moved, ran, and built against both ways")


if __name__ == "__main__":
    main()
