#!/bin/sh
# Run the test suite.
#
#   test.sh newest [pytest arguments]   today's libraries; the ROS part is left out, and counted, without a Python 3.12
#   test.sh oldest [pytest arguments]   the libraries of Ubuntu 24.04
set -eu
cd "$(dirname "$0")/.."

kind=$1
shift
if [ "$kind" = newest ]; then
    environment=$(scripts/environment.sh any)
else
    status=0
    environment=$(scripts/environment.sh oldest) || status=$?
    if [ $status -eq 3 ]; then
        echo "make: left out: the libraries of Ubuntu 24.04 need Python 3.12 on Linux x86-64, and none was found" >&2
        exit 0
    fi
    [ $status -eq 0 ] || exit $status
fi
case $environment in
    *-headless) ;;
    *) export LIE_RIGID_BODY_TEST_ROS=required ;;
esac
# a file to a process: tests that share a node or a bag stay together
exec "$environment/bin/python" -m pytest -n 2 --dist loadfile "$@"
