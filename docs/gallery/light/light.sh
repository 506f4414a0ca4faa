#!/usr/bin/env bash
# Renders the pictures of "In other lights" in docs/gallery.md.
# usage: docs/gallery/light/light.sh MAP.hdr
set -euo pipefail
map=$(realpath "$1")
cd "$(dirname "$0")"
cargo build --release --quiet
snowgrain=$(realpath ../../../target/release/snowgrain)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for light in overcast low-sun map; do
    cat garden.toml "$light.toml" > "$work/$light-garden.toml"
done
cp bench.toml lantern.toml "$work"
cp "$map" "$work/sky.hdr"
here=$PWD
cd "$work"

render() { "$snowgrain" render --quiet --roll-off 0.7 --exposure auto "$@"; }
render overcast-garden.toml --spp 64 -o overcast.png
render low-sun-garden.toml --size 400x300 --spp 192 --white-balance sunlit -o low-sun.png
render map-garden.toml --size 360x270 --spp 48 -o map.png
"$snowgrain" deposit "$here/lantern-mould.toml" --quiet -o lantern.ply
render lantern.toml --size 320x240 --spp 96 -o lantern.png -o lantern.film
"$snowgrain" develop lantern.film --exposure auto --roll-off 0.7 --glare eye -o lantern-glare.png
python3 "$here/make-bench.py" bench.glb
render bench.toml --spp 32 -o bench.png
render low-sun-garden.toml --size 320x240 --spp 80 --white-balance sunlit --set camera.from='[0.06, 0.075, 0.20]' \
    --set camera.at='[0.015, 0.03, 0.11]' --set camera.vertical_fov=20 --set camera.aperture=4mm \
    --set camera.focus=surface -o close.png
for picture in overcast low-sun map lantern lantern-glare bench close; do
    cp "$picture.png" "$here/../light-$picture.png"
done
