#!/usr/bin/env bash
# Work A: one knot of 7680 triangles, 320 x 240, RGB565, Lambert under one light, through raster.h alone. Prints what a frame takes per
# target and fails when the pictures differ, the host's included. Needs the programs and the blob: make work-a.
set -u
cd "$(dirname "$0")/../.." || exit 1
B=${B:-build}
for program in "$B"/board/*/work_a.elf; do
    target=$(basename "$(dirname "$program")")
    line=$(tests/board/run.sh "$target" "$program" "$B/board/work_a.blob") || { echo "$target: failed: $line" >&2; exit 1; }
    echo "$target $line"
done | tee "$B/board/work_a.txt"
[ "${PIPESTATUS[0]}" = 0 ] || exit 1
host=$("$B/board/host_hash-gcc-O2" 320 240 rgb565 "$B/board/work_a.blob" | awk '{ print $3 }')
[ "$(awk '{ print $4 }' "$B/board/work_a.txt" | sort -u)" = "$host" ] || { echo "work A: the pictures differ" >&2; exit 1; }
