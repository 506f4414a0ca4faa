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
render low-sun-garden.toml --size 400x300 --spp 96 --white-balance sunlit -o low-sun.png
render map-garden.toml --size 360x270 --spp 48 -o map.png
"$snowgrain" deposit "$here/lantern-mould.toml" --quiet -o lantern.ply
render lantern.toml --size 320x240 --spp 96 -o lantern.png
python3 "$here/make-bench.py" bench.glb
render bench.toml --spp 48 -o bench.png
render low-sun-garden.toml --view close --size 320x240 --spp 96 --white-balance sunlit -o close.film -o close.png
"$snowgrain" develop close.film --exposure auto --roll-off 0.7 --white-balance sunlit --glare eye -o close-glare.png
for picture in overcast low-sun map lantern bench close close-glare; do
    cp "$picture.png" "$here/../light-$picture.png"
done
