#!/usr/bin/env bash
# Appends what the emulated boards measure to a CSV file of benchmark results: instructions of a frame of the six models by the firmware,
# and of the comparison frames by the renderer alone where the data folder has their mesh; these on x86-64 as well, gcc -O2. Needs
# valgrind and the programs: make bench builds them.
#   tests/board/bench.sh RESULTS.csv
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
csv=$1
B=$B tests/board/boards.sh >&2
awk 'NR > 1 { print "frame," $1 ",six_models_320x240," $2 ",instructions_per_frame," $4 ",instructions" }' "$B/board/boards.txt" >>"$csv"
[ -e "$B/board/work_a.blob" ] || exit 0
for work in work_a work_b; do
    B=$B tests/board/work.sh $work >&2
    awk -v work=$work '{ print "raster," $1 "," work ",default,instructions_per_frame," $6 ",instructions" }' "$B/board/$work.txt" >>"$csv"
    valgrind --tool=callgrind --toggle-collect=raster_begin --toggle-collect=raster_render_tile \
        --callgrind-out-file="$B/board/callgrind.out" "$B/board/host_hash-gcc-O2" 320 240 rgb565 "$B/board/$work.blob" \
        >"$B/board/callgrind.log" 2>&1 || { cat "$B/board/callgrind.log" >&2; exit 1; }
    count=$(awk '$1 == "summary:" { print $2 }' "$B/board/callgrind.out")
    [ "${count:-0}" -gt 0 ] || { echo "bench: callgrind counted no instructions of $work" >&2; exit 1; }
    echo "raster,x86-64,$work,default,instructions_per_frame,$count,instructions" >>"$csv"
done
