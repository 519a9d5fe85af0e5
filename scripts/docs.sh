#!/bin/sh
# Build the site of docs/ and of the docstrings; a warning is an error.
set -eu
cd "$(dirname "$0")/.."

environment=$(scripts/environment.sh docs)
"$environment/bin/python" -m sphinx --builder html --fresh-env --fail-on-warning --keep-going --quiet docs build/docs
echo "The site: $PWD/build/docs/index.html"
