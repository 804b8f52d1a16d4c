#!/usr/bin/env bash
# The comparison frames: one knot of 7680 triangles, 320 x 240, RGB565, through raster.h alone.
#   work_a  Lambert under one light
#   work_b  Blinn-Phong with exponent 32 and a local viewer under three lights
# Prints what a frame takes per target and fails when the pictures differ, the host's included. Needs the programs and the blob:
# make work-a, make work-b.
#   tests/board/work.sh work_a|work_b
set -u
cd "$(dirname "$0")/../.." || exit 1
B=${B:-build}
work=$1
for program in "$B"/board/*/work_a.elf; do
    target=$(basename "$(dirname "$program")")
    line=$(tests/board/run.sh "$target" "$program" "$B/board/$work.blob") || { echo "$target: failed: $line" >&2; exit 1; }
    echo "$target $line"
done | tee "$B/board/$work.txt"
[ "${PIPESTATUS[0]}" = 0 ] || exit 1
host=$("$B/board/host_hash-gcc-O2" 320 240 rgb565 "$B/board/$work.blob" | awk '{ print $3 }')
[ "$(awk '{ print $4 }' "$B/board/$work.txt" | sort -u)" = "$host" ] || { echo "$work: the pictures differ" >&2; exit 1; }
