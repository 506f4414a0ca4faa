#!/usr/bin/env bash
# Renders every picture of docs/gallery.md and prints the table of what each cost.
# usage: docs/gallery/render.sh [OWN_MODEL.obj ...]
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release --quiet
snowgrain=target/release/snowgrain
stats=$(mktemp)
trap 'rm -f "$stats"' EXIT

picture() { # name, scene, options
    local name=$1 scene=$2
    shift 2
    "$snowgrain" render "$scene" -o "docs/gallery/$name.png" --json-stats "$stats" --quiet "$@"
    local command="snowgrain render $scene -o $name.png${*:+ $*}"
    python3 - "$stats" "$command" <<'PYTHON'
import json, sys
s = json.load(open(sys.argv[1]))
print("| `{}` | {} | {:.1f} MB | {:.0f} MB | {:.1f} s | {:.1f} s | {:.1f} s | {:.1f} M/s | {} |".format(
    sys.argv[2], s["grains"], s["grain_bytes"] / 1e6, s["peak_rss_bytes"] / 1e6,
    s["deposit_cpu_seconds"], s["render_seconds"], s["render_cpu_seconds"],
    s["interface_events"] / s["render_cpu_seconds"] / 1e6, s["trapped_paths"]))
PYTHON
}

echo "| command | grains | grain memory | peak memory | fall (CPU) | render | render (CPU) | interfaces per CPU second | let out |"
echo "|---|---|---|---|---|---|---|---|---|"
for spp in 1 10 100; do
    picture "snow-cube-$spp" snow-cube --spp $spp
done
for scene in snowy-sphere-thin snowy-sphere-thick snowy-teapot snowy-teapot-thin; do
    picture "$scene" "$scene"
done
for model in "$@"; do
    picture "$(basename "${model%.*}")" "$model"
done
