#!/bin/sh
# Run this package beside other software on one problem, and print work against precision.
set -eu
cd "$(dirname "$0")/.."

environment=$(scripts/environment.sh bench)
exec "$environment/bin/python" benchmarks/work_precision.py "$@"
