#!/bin/sh
# Renders the same grains with Snowgrain, Embree, Mitsuba 3 and Cycles and prints what each costs and finds.
#
#   benches/peers/run.sh [--quick] [--only embree,snowgrain] [--scenes cube-32,stick-1m] [--threads 2] [--keep]
#
# Needs git, a C++17 compiler, Rust and Python 3.11 or later with venv and pip; Linux. All that is installed
# goes to target/peers. `SNOWGRAIN=path` measures that program instead of building this checkout's.
set -eu
export PYTHONDONTWRITEBYTECODE=1
here=$(CDPATH= cd -- "$(dirname -- "$0")" && pwd)
root=$(CDPATH= cd -- "$here/../.." && pwd)
work=${PEERS_FOLDER:-$root/target/peers}
python=${PYTHON:-python3}
mkdir -p "$work"

venv=$work/venv
stamp=$venv/installed
wanted=$(cat "$here"/requirements*.txt)
if [ ! -e "$stamp" ] || [ "$(cat "$stamp")" != "$wanted" ]; then
    echo "installing the peers in $venv" >&2
    "$python" -m venv "$venv"
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r "$here/requirements.txt"
    # Blender's module exists for one Python version only; without it the other peers still run.
    "$venv/bin/pip" install --quiet --disable-pip-version-check -r "$here/requirements-cycles.txt" ||
        echo "Cycles is left out: bpy cannot be installed for this Python" >&2
    printf '%s\n' "$wanted" >"$stamp"
fi

library=$("$venv/bin/python" -c 'import embreex, glob, os
found = glob.glob(os.path.join(os.path.dirname(embreex.__path__[0]), "embreex.libs", "libembree4*.so*"))
print(found[0] if found else "")')
if [ -z "$library" ]; then
    echo "the embreex wheel of this platform holds no libembree4" >&2
    exit 1
fi
tracer=$work/tracer
"${CXX:-c++}" -std=c++17 -O3 -march=native -fno-math-errno -Wall -Wextra "$here/embree/tracer.cpp" -o "$tracer" \
    "$library" -Wl,-rpath,"$(dirname "$library")" -pthread

snowgrain=${SNOWGRAIN:-}
if [ -z "$snowgrain" ]; then
    (cd "$root" && cargo build --quiet --release --bin snowgrain)
    snowgrain=${CARGO_TARGET_DIR:-$root/target}/release/snowgrain
fi

exec "$venv/bin/python" "$here/compare.py" --snowgrain "$snowgrain" --tracer "$tracer" --folder "$work/run" "$@"
