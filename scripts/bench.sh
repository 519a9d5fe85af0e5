#!/bin/sh
# Run benchmarks beside other libraries, in an environment that has these.
#
#   bench.sh bench [--save]    this package beside other software, work against precision
#   bench.sh league [--save]   attitude filters of other libraries over shipped cases
set -eu
cd "$(dirname "$0")/.."

kind=$1
shift
case $kind in
    bench)
        benchmarks='work_precision recording checking campaign'
        about='Run this package beside other software, some ten minutes, and print the tables.
  --save   also write the pictures of docs/images and the tables of docs/benchmarks.md' ;;
    league)
        benchmarks=attitude_league
        about='Score every attitude filter over every case, over an hour, and print the table. Results are kept: it may be stopped.
  --save   also write the table and the picture of docs/, and the reference rows of the verb league' ;;
    *)
        echo "bench.sh: unknown kind '$kind'" >&2
        exit 2 ;;
esac
usage="usage: make $kind [ARGS=--save]
$about"
# Before an environment is built, which takes minutes.
for argument; do
    case $argument in
        --save) ;;
        -h | --help) echo "$usage"; exit 0 ;;
        *) echo "bench.sh: unknown argument '$argument'
$usage" >&2; exit 2 ;;
    esac
done

environment=$(scripts/environment.sh "$kind")
for benchmark in $benchmarks; do
    "$environment/bin/python" "benchmarks/$benchmark.py" "$@"
done
