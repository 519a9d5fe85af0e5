#!/bin/sh
# Check style and types.
set -eu
cd "$(dirname "$0")/.."

environment=$(scripts/environment.sh tests)
"$environment/bin/ruff" check .
"$environment/bin/ruff" format --check .
case $environment in
    # NumPy's own types change from release to release; the code is held to those of today's.
    *-headless) echo "Types left unchecked: today's NumPy, whose types they are checked against, needs Python 3.12" ;;
    *) "$environment/bin/mypy" ;;
esac
