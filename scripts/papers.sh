#!/bin/sh
# Published numbers beside ours.
set -eu
cd "$(dirname "$0")/.."

environment=$(scripts/environment.sh tests)
exec "$environment/bin/python" benchmarks/papers.py "$@"
