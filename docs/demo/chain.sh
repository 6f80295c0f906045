#!/usr/bin/env bash
# The demo's chain, with the built programs on the PATH: scene, spheres and truth, stream, eyes, scores, page.
#   chain.sh OUT
# From the environment, where given: EQUISTREAM_DEMO_FRAMES (60-61), EQUISTREAM_DEMO_SPHERE (1280x640: its small eye takes a quarter
# of that, at least 64 pixels a side), EQUISTREAM_DEMO_EYE (640x360), EQUISTREAM_DEMO_SPP (24, twice that for the truth).
set -euo pipefail

out=${1:?usage: chain.sh OUT}
frames=${EQUISTREAM_DEMO_FRAMES:-60-61}
sphere_size=${EQUISTREAM_DEMO_SPHERE:-1280x640}
eye_size=${EQUISTREAM_DEMO_EYE:-640x360}
spp=${EQUISTREAM_DEMO_SPP:-24}
mkdir -p "$out"

say() { printf '\n\033[1m%s\033[0m\n' "$*"; }

say "1/6 scene"
[ -f "$out/scene/pavilion.json" ] || equistream scene generate pavilion --out "$out/scene"
scene=$out/scene/pavilion.json

say "2/6 render: the sphere (with depth, motion, normals, albedo, ids), its small right-eye stream, and the truth"
equistream render "$scene" --eye centre --small right --frames "$frames" --size "$sphere_size" --spp "$spp" --seed 1 --out "$out/sphere"
equistream render "$scene" --camera perspective --eye both --frames "$frames" --size "$eye_size" --spp $((2 * spp)) --seed 2 \
    --aovs none --out "$out/truth"

say "3/6 encode"
equistream encode "$out/sphere" --out "$out/pavilion.mp4" --crf 16
equistream info "$out/pavilion.mp4"

say "4/6 play"
equistream play "$out/pavilion.mp4" --scene "$scene" --method eye-depth --fill small-wide,pushpull --size "$eye_size" --out "$out/eyes"
equistream play "$out/pavilion.mp4" --method rotation --size "$eye_size" --out "$out/rotated"

say "5/6 compare"
for system in eyes rotated; do
    equistream compare "$out/$system" "$out/truth" --gaps "$out/eyes/gaps" --difference "$out/$system/difference" \
        --out "$out/$system/compare.json"
done

say "6/6 page"
equistream info "$out/sphere/centre" --pictures "$out/pictures/sphere" >/dev/null
for eye in left right; do
    equistream info "$out/truth/$eye" --pictures "$out/pictures/$eye" >/dev/null
done
python3 "$(dirname "$0")/page.py" "$out"
echo "open $out/index.html"
