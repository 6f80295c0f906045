"""Makes Debian packages of a build, installs them in a fresh Debian root, and uses them there as their users would.

usage: packages_test.py CPACK BUILD_DIR SOURCE_DIR

Needs root, debootstrap and a mirror; exits with 77 and says why where they are missing. EQUISTREAM_PACKAGES=DIR keeps
the packages there.
"""

import contextlib
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

LIMITS_MB = {"equistream": 20, "libequistream3": 2, "libequistream-client1": 3, "libequistream-client1-modules": 3, "libequistream-dev": 1, "python3-equistream": 8}
ALL_MB = 30
LIGHT = ("libequistream3", "libequistream-client1", "python3-equistream")  # they need no OpenImageIO
SUITE = "bookworm"
MIRROR = "http://deb.debian.org/debian"
SOURCES = f"""deb {MIRROR} {SUITE} main
deb {MIRROR} {SUITE}-updates main
deb http://deb.debian.org/debian-security {SUITE}-security main
"""
COMPILERS = ["gcc", "g++", "cmake", "ninja-build", "pkg-config", "libglm-dev"]
SKIPPED = 77
USE = """
cd /root
equistream --version
equistream doctor
equistream scene generate motion --out scenes
equistream render scenes/motion.json --frames 0-1 --size 256x128 --spp 2 --progress none --out frames
equistream encode frames --out motion.mp4 --depth auto --progress none
equistream info motion.mp4
equistream play motion.mp4 --size 160x90 --progress none --out eyes
ls eyes/left/frame.0001.png eyes/right/frame.0001.png
test -s /usr/share/man/man1/equistream-encode.1 -a -s /usr/share/bash-completion/completions/equistream
test -s /usr/share/doc/equistream/copyright
python3 -c 'import equistream as es; print(es.open_stream("motion.mp4").tracks[0]["codec"])'
"""
LINK = """
cd /root/example
cc toy_host.c toy_renderer.c $(pkg-config --cflags --libs equistream) -lm -o by_pkg_config && ./by_pkg_config /root/one
cmake -G Ninja -S . -B build && cmake --build build && ./build/toy_host /root/two
cmp /root/one/frame.0000.exr /root/two/frame.0000.exr
cc show.c $(pkg-config --cflags --libs equistream-client) -o show && ./show
cmake -G Ninja -S components -B components/build && cmake --build components/build && ./components/build/show
"""
SHOW_C = """
#include <equistream/client.h>
#include <stdio.h>
int main(void) {
    printf("client ABI %d\\n", (int)es_client_abi_version());
    return es_client_abi_version() == ES_CLIENT_ABI_VERSION ? 0 : 1;
}
"""
SHOW_CMAKE = """cmake_minimum_required(VERSION 3.25)
project(show LANGUAGES C CXX)
find_package(equistream 0.1 REQUIRED COMPONENTS client)
add_executable(show ../show.c)
target_link_libraries(show PRIVATE equistream::client)
"""


def run(*words, **options):
    done = subprocess.run([str(word) for word in words], text=True, capture_output=True, **options)
    assert done.returncode == 0, f"{shlex.join(map(str, words))}: {done.returncode}\n{done.stdout[-6000:]}{done.stderr[-6000:]}"
    return done.stdout


@contextlib.contextmanager
def timed(what):
    begin = time.monotonic()
    yield
    print(f"{what}: {time.monotonic() - begin:.0f} s", flush=True)


def skip(why):
    print(f"skipped: {why}")
    sys.exit(SKIPPED)


def make_packages(cpack, build, folder):
    with timed("cpack"):
        run(cpack, "--config", build / "CPackConfig.cmake", "-B", folder)
    packages = {file.name.split("_")[0]: file for file in sorted(folder.glob("*.deb"))}
    assert {*LIMITS_MB} - {"python3-equistream"} <= {*packages} <= {*LIMITS_MB}, packages
    for name, file in packages.items():
        fields = dict(re.findall(r"^ ([A-Z][\w-]+): (.*)$", run("dpkg-deb", "--info", file), re.M))
        contents = run("dpkg-deb", "--contents", file)
        megabytes = file.stat().st_size / 1e6
        print(f"{file.name}: {megabytes:.2f} MB, installed {int(fields['Installed-Size']) / 1024:.1f} MiB; depends on {fields['Depends']}")
        assert megabytes < LIMITS_MB[name], (name, megabytes)
        assert f"usr/share/doc/{name}/copyright" in contents, contents
        assert "/usr/local" not in contents and "__pycache__" not in contents, contents
    assert sum(file.stat().st_size for file in packages.values()) / 1e6 < ALL_MB
    return packages


def mounted_in(folder):
    places = [line.split()[4] for line in pathlib.Path("/proc/self/mountinfo").read_text().splitlines()]
    places = [re.sub(r"\\([0-7]{3})", lambda octal: chr(int(octal[1], 8)), place) for place in places]
    return [place for place in places if place.startswith(f"{folder}/")]


@contextlib.contextmanager
def scratch_folder():
    """It goes in the end, but stays where anything is mounted in it: this machine's /dev would go with it."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="equistream_packages_")).resolve()
    try:
        yield folder
    finally:
        if mounted := mounted_in(folder):
            raise AssertionError(f"{folder}: expected nothing mounted there in the end, found {', '.join(mounted)}; umount these, then remove the folder")
        shutil.rmtree(folder)


@contextlib.contextmanager
def fresh_root(folder):
    root = folder / "root"
    with timed("debootstrap"):
        done = subprocess.run(["debootstrap", "--variant=minbase", "--include=ca-certificates", SUITE, root, MIRROR], text=True, capture_output=True)
    if done.returncode:
        skip(f"debootstrap: {(done.stdout + done.stderr).strip().splitlines()[-1]}")
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
    shutil.copy("/etc/ssl/certs/ca-certificates.crt", root / "etc/ssl/certs/ca-certificates.crt")
    (root / "etc/apt/sources.list").write_text(SOURCES)
    mounts = [root / "proc", root / "dev"]
    try:
        run("mount", "-t", "proc", "proc", mounts[0])
        run("mount", "--rbind", "/dev", mounts[1])
        run("mount", "--make-rslave", mounts[1])
        yield root
    finally:
        for mount in reversed(mounts):
            if os.path.ismount(mount):
                subprocess.run(["umount", "-R", mount])  # scratch_folder says what is left


def inside(root, script):
    environment = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "DEBIAN_FRONTEND": "noninteractive", "LC_ALL": "C.UTF-8"}
    return run("chroot", root, "sh", "-exc", script, env=environment)


def install(root, flags, packages, names):
    def megabytes():
        return int(run("du", "-sxm", root).split()[0])

    before = megabytes()
    with timed(f"apt-get install {flags} {' '.join(names)}"):
        inside(root, f"apt-get install -y -qq {flags} {' '.join(f'/root/{packages[name].name}' for name in names)} && apt-get clean")
    print(f"the root grew by {megabytes() - before} MB")


def main():
    cpack, build, source = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    if os.geteuid() != 0:
        skip("expected root, for debootstrap and chroot")
    for program in ("debootstrap", "dpkg-shlibdeps"):
        if not shutil.which(program):
            skip(f"expected {program}, found none (apt-get install debootstrap dpkg-dev)")
    with scratch_folder() as folder:
        packages = make_packages(cpack, build, folder / "packages")
        if kept := os.environ.get("EQUISTREAM_PACKAGES"):
            shutil.copytree(folder / "packages", kept, dirs_exist_ok=True, ignore=lambda _, names: [name for name in names if not name.endswith(".deb")])
        with fresh_root(folder) as root:
            for file in packages.values():
                shutil.copy(file, root / "root")
            inside(root, "apt-get update -qq")
            install(root, "--no-install-recommends", packages, [name for name in packages if name in LIGHT])
            install(root, "--no-install-recommends", packages, ["equistream"])
            install(root, "", packages, [name for name in packages if name != "libequistream-dev"])
            with timed("doctor, scene, render, encode, info, play, Python"):
                print(inside(root, USE))
            shutil.copytree(source / "host-adapters/example", root / "root/example")
            (root / "root/example/show.c").write_text(SHOW_C)
            (root / "root/example/components").mkdir()
            (root / "root/example/components/CMakeLists.txt").write_text(SHOW_CMAKE)
            inside(root, f"apt-get install -y -qq --no-install-recommends {' '.join(COMPILERS)} /root/{packages['libequistream-dev'].name}")
            with timed("programs linked by pkg-config and find_package"):
                inside(root, LINK)
            inside(root, "apt-get remove -y -qq equistream && test ! -e /usr/bin/equistream && ls /usr/lib/libequistream.so.3")


if __name__ == "__main__":
    main()
