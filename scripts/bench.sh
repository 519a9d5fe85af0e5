#!/bin/sh
# Run this package beside other software on one problem, and print work against precision.
set -eu
cd "$(dirname "$0")/.."

usage='usage: make bench [ARGS=--save]
Run this package beside other software, some ten minutes, and print the tables.
  --save   also write the pictures of docs/images and the tables of docs/benchmarks.md'
# Before an environment is built, which takes minutes.
for argument; do
    case $argument in
        --save) ;;
        -h | --help) echo "$usage"; exit 0 ;;
        *) echo "bench.sh: unknown argument '$argument'
$usage" >&2; exit 2 ;;
    esac
done

environment=$(scripts/environment.sh bench)
for benchmark in work_precision recording checking campaign; do
    "$environment/bin/python" "benchmarks/$benchmark.py" "$@"
done
