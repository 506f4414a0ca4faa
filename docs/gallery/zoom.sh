#!/bin/sh
# Renders the frames of zoom.toml to zoom-NN.png, of which zoom.png is put together, and tells the FLIP error of learnt light
# in the middle of each against light that is followed to its end.
# From frame 7 on pixels are wider than a transport length: less error is asked for there, of more learning paths.
set -e
cd "$(dirname "$0")"
for frame in 01 02 03 04 05 06 07 08 09 10 11 12; do
  case $frame in 0[1-6]) learnt="--lod-error 0.003 --set integrator.learning_paths=2097152" ;;
    *) learnt="--lod-error 0.001 --set integrator.learning_paths=4194304" ;; esac
  snowgrain render zoom.toml --frame $frame --quiet --spp "${SPP:-96}" $learnt --learnt-cache zoom-learnt -o zoom-$frame.png \
    --json-stats zoom-$frame.json
  snowgrain render zoom.toml --frame $frame --quiet --crop 168,104,216,152 --spp 8192 $learnt \
    --learnt-cache zoom-learnt -o zoom-fast.exr
  snowgrain render zoom.toml --frame $frame --quiet --crop 168,104,216,152 --spp "${CROP_SPP:-4096}" --set film.seed=2 \
    -o zoom-exact.exr --json-stats zoom-exact-$frame.json
  echo "frame $frame"
  snowgrain compare zoom-fast.exr zoom-exact.exr --json
done
