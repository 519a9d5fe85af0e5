#!/bin/sh
# Try mutated bags, parameter files and campaigns in every verb that reads them: see test/fuzzing.py.
set -eu
cd "$(dirname "$0")/.."

environment=$(scripts/environment.sh tests)
exec "$environment/bin/python" test/fuzzing.py "$@"
