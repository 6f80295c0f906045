#!/usr/bin/env bash
# Builds the site of docs/: open OUT/index.html. Installs MkDocs into build/site-venv first, which takes ten seconds.
#   build.sh [--gallery] [OUT]     (OUT: build/site)
# --gallery: renders the gallery into build/gallery (gallery.sh: minutes, with the built programs on the PATH) and puts it into the
# site. Its streams need a server: python3 -m http.server --bind 127.0.0.1 --directory OUT 8000.
# `build/site-venv/bin/mkdocs serve` shows each page as it is written. Exit status 77: MkDocs could not be installed.
set -euo pipefail
started_in=$PWD
cd "$(dirname "$0")/../.."
gallery=
if [ "${1:-}" = --gallery ]; then
    gallery=$PWD/build/gallery
    shift
    command -v equistream >/dev/null || {
        echo "--gallery: expected equistream on the PATH, found none: build it, then PATH=\$PWD/build/release/bin:\$PATH $0 --gallery" >&2
        exit 2
    }
fi
out=$PWD/build/site
[ $# -eq 0 ] || out=$(cd "$started_in" && realpath -m -- "$1")
venv=build/site-venv

if ! sha256sum --check --status "$venv/requirements.sha256" 2>/dev/null; then
    echo "installing MkDocs into $venv"
    rm -rf "$venv"
    { python3 -m venv "$venv" && "$venv/bin/pip" install --quiet --disable-pip-version-check -r docs/site/requirements.txt; } || {
        rm -rf "$venv"
        echo "no site: MkDocs could not be installed" >&2
        exit 77
    }
    sha256sum docs/site/requirements.txt >"$venv/requirements.sha256"
fi
[ -z "$gallery" ] || docs/site/gallery.sh "$gallery"
EQUISTREAM_SITE_GALLERY=$gallery NO_MKDOCS_2_WARNING=1 "$venv/bin/mkdocs" build --quiet --site-dir "$out"
echo "open $out/index.html"
