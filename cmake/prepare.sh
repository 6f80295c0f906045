#!/usr/bin/env bash
# Makes what ./demo, ./test and ./bench need: packages, the Python environment of the tests, the build.
# Sourced with the preset's name as $1 and a target to build as $2, `native_programs` say (unless given: all).
# Sets BUILD and, where the real scenes lie beside the checkout, EQUISTREAM_SCENES.
# A preset may need packages of its own: packages.PRESET.txt. What is there already is left alone, so a second run starts
# in seconds. ccache keeps what was compiled, also for other checkouts of the same sources.

preset=$1
target=${2:-}
BUILD=$PWD/build/$preset
export CCACHE_DIR=${CCACHE_DIR:-${HOME:-$PWD/build}/.cache/equistream-ccache}
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1 # another checkout of the same sources hits the cache

as_root() {
    if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

install_packages() {
    local missing=() package
    while read -r package; do
        dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null | grep -q '^installed$' || missing+=("$package")
    done < <(cat cmake/packages.txt "cmake/packages.$preset.txt" 2>/dev/null)
    [ ${#missing[@]} -eq 0 ] && return
    echo "installing ${#missing[@]} packages: ${missing[*]}"
    as_root apt-get update -qq
    as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

make_python_environment() {
    local stamp=build/venv/requirements.sha256 python
    python=$(python3 -c 'import sys; print("python%d.%d" % sys.version_info[:2])')
    if [ -d "build/venv/lib/$python" ] && [ -f "$stamp" ] && sha256sum --check --status "$stamp"; then return; fi
    echo "making the tests' Python environment in build/venv"
    rm -rf build/venv
    python3 -m venv build/venv
    build/venv/bin/pip install --quiet --disable-pip-version-check -r tests/requirements.txt
    sha256sum tests/requirements.txt >"$stamp"
}

# "3 min 20 s"
duration() {
    if [ "$1" -lt 60 ]; then echo "$1 s"; else echo "$(($1 / 60)) min $(($1 % 60)) s"; fi
}

# A file takes 4 s of a processor on average; one that ccache has takes almost none.
say_how_long() {
    local plan files
    ninja -C "$BUILD" build.ninja >/dev/null # configures again if need be: a dry run would count nothing else
    # A copy has another name, as a dry run of build.ninja itself ends where CMake would look for new files.
    cp "$BUILD/build.ninja" "$BUILD/dry_run.ninja"
    plan=$(ninja -C "$BUILD" -f dry_run.ninja -n ${target:+"$target"}) || { echo "$plan" >&2; return 1; }
    files=$(awk '/Building C/ { ++n } END { print n + 0 }' <<<"$plan")
    [ "$files" -eq 0 ] ||
        echo "building ${target:-everything}: $files files to compile: $(duration $((files * 4 / $(nproc)))) on $(nproc) idle processors, less what the compiler cache holds"
}

build() {
    local begin=$SECONDS
    [ -f "$BUILD/build.ninja" ] && [ -z "${EQUISTREAM_CMAKE_OPTIONS:-}" ] ||
        cmake --preset "$preset" "-DEQUISTREAM_PYTHON=$PWD/build/venv/bin/python3" ${EQUISTREAM_CMAKE_OPTIONS:-} >"$BUILD.configure.log" ||
        { cat "$BUILD.configure.log"; return 1; }
    say_how_long
    local quiet=(--quiet)
    if [ -t 1 ]; then quiet=(); fi
    cmake --build --preset "$preset" ${target:+--target "$target"} -- "${quiet[@]}"
    echo "built ${target:-everything} in $(duration $((SECONDS - begin)))"
}

install_packages
mkdir -p build
make_python_environment
build
if [ -z "${EQUISTREAM_SCENES:-}" ] && [ -d ../shared/scenes ]; then
    EQUISTREAM_SCENES=$(cd ../shared/scenes && pwd)
    export EQUISTREAM_SCENES
fi
export PATH=$BUILD/bin:$PATH
