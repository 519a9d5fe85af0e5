#!/bin/sh
# Run the live node; where that is impossible say so, and show the headless verbs instead.
set -eu
cd "$(dirname "$0")/.."

status=0
environment=$(scripts/environment.sh live) || status=$?
if [ $status -eq 0 ]; then
    # In place of this shell, so that signals and the exit status are the node's.
    exec "$environment/bin/lie-rigid-body" sim "$@"
elif [ $status -ne 3 ]; then
    exit $status
fi

environment=$(scripts/environment.sh headless)
cat >&2 <<'TEXT'
The live node needs Python 3.12, 3.13 or 3.14 on Linux x86-64, and none was found. Install one with any of
    apt install python3.12 python3.12-venv        (Ubuntu 24.04)
    apt install python3 python3-venv              (Ubuntu 26.04)
    uv python install 3.12
    pyenv install 3.12
    conda create --name py312 python=3.12
or name one with  make sim PYTHON=/path/to/python3.12
Without it, this is the same motion recorded and checked without ROS:
TEXT
bag=.cache/sim.mcap
set -x
"$environment/bin/lie-rigid-body" record $bag --scenario dzhanibekov --duration 20 --force
"$environment/bin/lie-rigid-body" check $bag
