#!/bin/sh
# Renders sweep.toml with one property changed at a time, of which sweep.png is put together.
set -e
cd "$(dirname "$0")"
render() { snowgrain render sweep.toml --set "$2" --set "$3" -o "sweep-$1.png"; }
ray='snow.rule="ray"'
for v in 0.1mm 0.15mm 0.2mm 0.3mm 0.4mm; do render "radius-$v" "snow.radius=$v" "$ray"; done
for v in 0mm 0.05mm 0.1mm 0.15mm 0.19mm; do render "variation-$v" "snow.variation=$v" "$ray"; done
for v in 1.05 1.2 1.31 1.5 1.8; do render "index-$v" "ice.ior=$v" "$ray"; done
for v in 1000 4000 12000 40000 120000; do render "grains-$v" "snow.grains=$v" "$ray"; done
for v in 80 150 280 340 450; do render "density-$v" "snow.density=$v" snow.max_slope=80.0; done
