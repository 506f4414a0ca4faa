#!/bin/sh
# Makes the pictures of "Colour after the render" and "A hole in the snow" in docs/gallery.md.
set -eu
cd "$(dirname "$0")"
snowgrain="cargo run --release --quiet --"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

$snowgrain render snowy-teapot --size 360x300 --keep ice-paths -o "$work/teapot.film" --quiet
develop() { $snowgrain develop "$work/teapot.film" "$@"; }
develop -o teapot-clean.png
develop --impurity soot=2ppm -o teapot-sooty.png
develop --impurity dust-sahara=500ppm -o teapot-dusty.png
develop --impurity snow-algae=200000cells/mL -o teapot-algae.png

for pores in air water; do
    $snowgrain render snowy-sphere-thick --size 300x300 --spp 32 --set ice.pores=$pores \
        -o "sphere-in-$pores.png" --quiet
done

$snowgrain deposit hole/mould.toml -o "$work/hole.ply" --quiet
cp hole/hole.toml "$work"
$snowgrain render "$work/hole.toml" --exposure 0.7 -o hole.png -o "$work/hole.exr" --quiet
