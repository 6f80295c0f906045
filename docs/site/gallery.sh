#!/usr/bin/env bash
# Makes a gallery of three bundled scenes: OUT/index.html, and streams that one can look around in. Any web host can hand the folder out.
#   gallery.sh [OUT]     (OUT: build/gallery), with the built programs on the PATH
# From the environment, where given: EQUISTREAM_GALLERY_FRAMES (0-29), EQUISTREAM_GALLERY_SPHERE (768x384), EQUISTREAM_GALLERY_SPP (16),
# EQUISTREAM_GALLERY_DENOISE (off). Scenes whose stream is there already stay as they are.
set -euo pipefail

out=${1:-$(dirname "$0")/../../build/gallery}
frames=${EQUISTREAM_GALLERY_FRAMES:-0-29}
sphere_size=${EQUISTREAM_GALLERY_SPHERE:-768x384}
spp=${EQUISTREAM_GALLERY_SPP:-16}
denoise=${EQUISTREAM_GALLERY_DENOISE:-off}
page=$(dirname "$(realpath "$(command -v equistream)")")/../share/equistream/web.html
declare -A captions=(
    [pavilion]="A garden pavilion: glass, a mirror, leaves, railings and a rolling ball. Move the head, and near things shift."
    [materials]="A room of materials: matt, mirrors, panes of glass, textures, masks and lamps."
    [motion]="A glowing room in which two objects move by themselves."
)
mkdir -p "$out"
cp "$page" "$out/web.html"

for name in pavilion materials motion; do
    [ ! -f "$out/$name.mp4" ] || continue
    work=$(mktemp -d)
    trap 'rm -rf "$work"' EXIT
    echo "$name"
    equistream scene generate "$name" --out "$work" >/dev/null
    equistream render "$work/$name.json" --eye centre --frames "$frames" --size "$sphere_size" --spp "$spp" --denoise "$denoise" --out "$work/sphere"
    equistream encode "$work/sphere" --out "$work/$name.mp4" --depth pece420 --fill none
    equistream play "$work/$name.mp4" --frames "${frames%%-*}" --method mesh --size 640x360 --progress none --out "$work/eyes" >/dev/null
    cp "$(find "$work/eyes/left" -name '*.png' | head -n 1)" "$out/$name.png"
    mv "$work/$name.mp4" "$out/$name.mp4"
    rm -rf "$work"
done

{
    cat <<'HTML'
<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width">
<title>equistream: gallery</title>
<style>
  body { background: #16171a; color: #e8e6e1; font: 16px/1.5 sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem; }
  main { display: grid; gap: 1.5rem; grid-template-columns: repeat(auto-fill, minmax(20rem, 1fr)); }
  figure { margin: 0; }
  img { display: block; width: 100%; }
  a { color: #8cf; }
</style>
<h1>Look around in them</h1>
<p>Drag to turn, <code>w a s d e q</code> move the head, <code>h</code> lists the keys. A headset's button appears where the browser has one.</p>
<main>
HTML
    for name in pavilion materials motion; do
        megabytes=$(stat -c %s "$out/$name.mp4" | awk '{printf "%.1f", $1 / 1e6}')
        echo "<figure><a href=\"web.html?src=$name.mp4\"><img src=\"$name.png\" alt=\"$name\"></a>"
        echo "<figcaption><b>$name</b> ($megabytes MB). ${captions[$name]}</figcaption></figure>"
    done
    echo "</main></html>"
} >"$out/index.html"
echo "to serve it: python3 -m http.server --bind 127.0.0.1 --directory $out 8000, then open http://127.0.0.1:8000/"
