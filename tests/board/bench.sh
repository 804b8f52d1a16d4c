#!/usr/bin/env bash
# Appends what the emulated boards measure to a CSV file of benchmark results: instructions of a frame of the six models by the firmware,
# and of work A by the renderer alone where the data folder has its mesh. Needs the programs: make bench builds them.
#   tests/board/bench.sh RESULTS.csv
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
csv=$1
B=$B tests/board/boards.sh >&2
awk 'NR > 1 { print "frame," $1 ",six_models_320x240," $2 ",instructions_per_frame," $4 ",instructions" }' "$B/board/boards.txt" >>"$csv"
[ -e "$B/board/work_a.blob" ] || exit 0
B=$B tests/board/work_a.sh >&2
awk '{ print "raster," $1 ",work_a,default,instructions_per_frame," $6 ",instructions" }' "$B/board/work_a.txt" >>"$csv"
