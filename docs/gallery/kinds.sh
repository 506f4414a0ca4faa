#!/bin/sh
# Renders each kind of snow to kind-NAME.png, of which kinds.png is put together.
set -e
cd "$(dirname "$0")"
for kind in fresh wind-slab old corn melt-freeze-crust firn depth-hoar surface-hoar graupel; do
  snowgrain render kinds.toml --size 240x180 --spp "${SPP:-512}" --set "snow.kind=$kind" \
    --set integrator.calibration_paths=262144 -o "kind-$kind.png"
done
