#!/bin/sh
# Renders the frames of zoom.toml to zoom-NN.png, of which zoom.png is put together, and tells the FLIP error of learnt light
# in the middle of each against light that is followed to its end.
set -e
cd "$(dirname "$0")"
for frame in 01 02 03 04 05 06 07 08 09 10 11 12; do
  snowgrain render zoom.toml --frame $frame --quiet --spp "${SPP:-256}" --lod-error 0.01 -o zoom-$frame.png \
    --json-stats zoom-$frame.json
  snowgrain render zoom.toml --frame $frame --quiet --crop 160,96,224,160 --spp "${CROP_SPP:-1024}" --lod-error 0.01 \
    -o zoom-fast.exr
  snowgrain render zoom.toml --frame $frame --quiet --crop 160,96,224,160 --spp "${CROP_SPP:-1024}" --set film.seed=2 \
    -o zoom-exact.exr --json-stats zoom-exact-$frame.json
  echo "frame $frame"
  snowgrain compare zoom-fast.exr zoom-exact.exr --json
done
