#!/usr/bin/env bash
# The demo's chain, with the built programs on the PATH: scene, spheres and truth, stream, eyes, scores, page.
#   chain.sh OUT
# From the environment, where given: EQUISTREAM_DEMO_FRAMES (60-61), EQUISTREAM_DEMO_SPHERE (1280x640: its small eye takes a quarter
# of that, at least 64 pixels a side), EQUISTREAM_DEMO_EYE (640x360), EQUISTREAM_DEMO_SPP (24), EQUISTREAM_DEMO_DENOISE (off).
# OUT/commands.txt has the commands as they were run.
set -euo pipefail

out=${1:?usage: chain.sh OUT}
frames=${EQUISTREAM_DEMO_FRAMES:-60-61}
sphere_size=${EQUISTREAM_DEMO_SPHERE:-1280x640}
eye_size=${EQUISTREAM_DEMO_EYE:-640x360}
spp=${EQUISTREAM_DEMO_SPP:-24}
denoise=${EQUISTREAM_DEMO_DENOISE:-off}
here=$(dirname "$0")
scene=$out/scene/pavilion.json
mkdir -p "$out"
: >"$out/commands.txt"
renderer=$(dirname "$(realpath "$(command -v equistream)")")/equistream-render-embree
settings="$frames $sphere_size $eye_size $spp $denoise $(cksum <"$renderer")"
replace= # what a run with other settings, or of another build, left makes way
[ "$settings" = "$(cat "$out/settings.txt" 2>/dev/null)" ] || replace=--overwrite
[ -z "$replace" ] || rm -f "$out/settings.txt" # until all of it is of these settings

say() { printf '\n\033[1m%s\033[0m\n' "$*"; }
run() {
    local words=$*
    echo "${words/ --overwrite/}" >>"$out/commands.txt"
    "$@"
}

say "1/7 scene"
[ -z "$replace" ] && [ -f "$scene" ] || equistream scene generate pavilion --out "$out/scene" --overwrite
echo "equistream scene generate pavilion --out $out/scene" >>"$out/commands.txt"

say "2/7 render: the sphere with depth, what lies behind it, its small right-eye stream, and the truth twice"
run equistream render "$scene" --eye centre --small right --layers --frames "$frames" --size "$sphere_size" --spp "$spp" --denoise "$denoise" --seed 1 $replace \
    --out "$out/sphere"
for seed in 2 3; do
    run equistream render "$scene" --camera perspective --eye both --frames "$frames" --size "$eye_size" --spp "$spp" --seed "$seed" --aovs none $replace \
        --out "$out/truth-$seed"
done

say "3/7 encode"
run equistream encode "$out/sphere" --out "$out/pavilion.mp4" --crf 16 --depth pece420 # a code that every browser decodes
equistream info "$out/pavilion.mp4"

say "4/7 play"
run equistream play "$out/pavilion.mp4" --scene "$scene" --method eye-depth --size "$eye_size" $replace --out "$out/eyes"
run equistream play "$out/pavilion.mp4" --method rotation --size "$eye_size" $replace --out "$out/rotated"

say "5/7 play: the head moves from side to side"
python3 "$here/heads.py" "$out/sphere/centre/manifest.json" "$out/heads"
for head in "$out"/heads/*.csv; do
    name=$(basename "$head" .csv)
    run equistream play "$out/pavilion.mp4" --head "$head" --frames "${frames%%-*}" --scene "$scene" --method eye-depth --size "$eye_size" \
        --progress none $replace --out "$out/moved/$name" >/dev/null
    printf .
done
echo
echo "$settings" >"$out/settings.txt"

say "6/7 compare"
for system in eyes rotated; do
    rm -rf "$out/$system/difference"
    run equistream compare "$out/$system" "$out/truth-2" --truth2 "$out/truth-3" --gaps "$out/eyes/gaps" --difference "$out/$system/difference" \
        --out "$out/$system/compare.json"
done
run equistream compare "$out/truth-3" "$out/truth-2" --out "$out/ceiling.json"

say "7/7 page"
equistream info "$out/sphere/centre" --pictures "$out/pictures/sphere" >/dev/null
for eye in left right; do
    equistream info "$out/truth-2/$eye" --pictures "$out/pictures/$eye" >/dev/null
done
cp "$(dirname "$(realpath "$(command -v equistream)")")/../share/equistream/web.html" "$out/web.html"
python3 "$here/page.py" "$out"
echo "open $out/index.html"
