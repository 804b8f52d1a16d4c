#!/usr/bin/env bash
# Prints rows of results.csv for the scenes of scenes.sh, which it builds first: instructions per frame by callgrind on x86-64 and on
# emulated boards, and the arena that the frame takes. 320 x 240, RGB888, culling and binning included, loading excluded.
# Environment: B (build folder). Needs bench_frame, valgrind and the boards' programs (make bench builds them).
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tests/bench/scenes.sh >&2

frame() { # scene case variant
    local count
    valgrind --tool=callgrind --toggle-collect='bench_frame*' --callgrind-out-file="$work/callgrind" \
        "$B/bench/bench_frame" lafortune_phong 1 "$B/bench/$1.blob" >"$work/out" 2>"$work/log" || { cat "$work/log" >&2; exit 1; }
    count=$(awk '$1 == "summary:" { print $2 }' "$work/callgrind")
    [ "${count:-0}" -gt 0 ] || { echo "raster_rows: $1: callgrind counted no instructions" >&2; exit 1; }
    echo "raster,x86-64,$2,$3,instructions_per_frame,$count,instructions"
    echo "raster,x86-64,$2,$3,arena_bytes,$(awk '$1 == "arena_bytes" { print $2 }' "$work/out"),bytes"
}
for n in 2k 8k 32k 128k 1m 1m_grid 1m_mesh; do frame "knots_$n" "knots_$n" lod05; done
for n in 1 4 16; do frame "overdraw_$n" "overdraw_$n" lod05; done
# The same on emulated boards, RGB565, as far as the scene fits their memory.
for target in cortex-m3 cortex-m7; do
    for case in knots_{2k,8k,32k,128k,1m,1m_grid} overdraw_{1,4,16}; do
        line=$(tests/board/run.sh $target "$B/board/$target/work_a.elf" "$B/bench/$case.blob") ||
            { echo "raster_rows: $case on $target: $line" >&2; exit 1; }
        echo "raster,$target,$case,lod05,instructions_per_frame,$(awk '{ for (i = 1; i < NF; i++) if ($i == "instructions") print $(i + 1) }' <<<"$line"),instructions"
    done
done
# The same million triangles without levels of detail: what they save.
"$B/gtscene" build "$B/bench/knots_1m.json" -o "$B/bench/knots_1m_finest.blob" --lod-error 0
frame knots_1m_finest knots_1m finest
