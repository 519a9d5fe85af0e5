#!/bin/sh
# Run the test suite.
#
#   test.sh newest [pytest arguments]   today's libraries; the ROS part is left out, and counted, without a Python for it
#   test.sh oldest [pytest arguments]   the libraries of Ubuntu 24.04
#   test.sh kilted [pytest arguments]   the tests of the node, with the client library of ROS 2 Kilted
set -eu
cd "$(dirname "$0")/.."

kind=$1
shift
if [ "$kind" = newest ]; then
    environment=$(scripts/environment.sh tests)
else
    status=0
    case $kind in
        oldest) wanted="the libraries of Ubuntu 24.04 need Python 3.12" ;;
        kilted) wanted="the client library of ROS 2 Kilted needs Python 3.13 or 3.14"; set -- test/ros "$@" ;;
    esac
    environment=$(scripts/environment.sh $kind) || status=$?
    if [ $status -eq 3 ]; then
        echo "make: left out: $wanted on Linux x86-64, and none was found" >&2
        exit 0
    fi
    [ $status -eq 0 ] || exit $status
fi
case $environment in
    *-headless) ;;
    *) export LIE_RIGID_BODY_TEST_ROS=required ;;
esac
# Neighbours stay in one process, as they often share a node or a bag, until another process has nothing left to do. There is
# one more than cores, as many tests wait for the processes that they start. `Watch` of test/conftest.py ends what hangs.
cores=$(getconf _NPROCESSORS_ONLN)
exec "$environment/bin/python" -m pytest -n $((cores < 8 ? cores + 1 : 8)) --dist worksteal "$@"
