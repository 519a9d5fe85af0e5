#!/bin/sh
# The loop of editing, within a minute: style, types of what changed since the last time, and of most tests one case.
#
# Left out are ROS, processes, packaging, the documents, and tests of some seconds: `make test` has them.
set -eu
cd "$(dirname "$0")/.."

environment=$(scripts/environment.sh tests)
scripts/lint.sh
exec "$environment/bin/python" -m pytest -n 2 -q -m "not (long or ros or slow)" --one-case --hypothesis-profile=quick \
    test/test_import_walls.py test/arithmetic test/campaign test/certificate test/estimates test/evaluation test/foundation test/groups test/lie test/mechanics test/messages \
    test/motion test/portable test/proof test/recording test/runs test/scenario test/sensors test/simulation test/testing test/words "$@"
