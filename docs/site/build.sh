#!/usr/bin/env bash
# Builds the site of docs/: open OUT/index.html. Installs MkDocs into build/site-venv first, which takes ten seconds.
#   build.sh [OUT]     (OUT: build/site)
# `build/site-venv/bin/mkdocs serve` shows each page as it is written. Exit status 77: MkDocs could not be installed.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=$(realpath -m "${1:-build/site}")
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
NO_MKDOCS_2_WARNING=1 "$venv/bin/mkdocs" build --quiet --site-dir "$out"
echo "open $out/index.html"
