#!/usr/bin/env bash
# How the red of the sphere fades under more and more snow: mean red over mean green of the picture.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release --quiet
stats=$(mktemp)
trap 'rm -f "$stats"' EXIT
echo "| grains | red / green |"
echo "|---|---|"
for grains in 10000 50000 100000 200000 400000 700000 1000000; do
    target/release/snowgrain render snowy-sphere-thick -o "$stats.png" --size 128x128 --spp 64 --quiet \
        --set camera.backdrop='[0,0,0]' --set snow.grains=$grains --json-stats "$stats"
    python3 -c 'import json, sys
red, green, _ = json.load(open(sys.argv[1]))["mean_radiance"]
print(f"| {sys.argv[2]} | {red / green:.3f} |")' "$stats" "$grains"
done
rm -f "$stats.png"
