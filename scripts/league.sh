#!/bin/sh
# Score attitude filters of other libraries over shipped cases.
set -eu
cd "$(dirname "$0")/.."

usage='usage: make league [ARGS=--save]
Score every attitude filter over every case, half an hour, and print the table.
  --save   also write the table and the picture of docs/, and benchmarks/data/league.csv'
# Before an environment is built, which takes minutes.
for argument; do
    case $argument in
        --save) ;;
        -h | --help) echo "$usage"; exit 0 ;;
        *) echo "league.sh: unknown argument '$argument'
$usage" >&2; exit 2 ;;
    esac
done

environment=$(scripts/environment.sh league)
exec "$environment/bin/python" benchmarks/attitude_league.py "$@"
