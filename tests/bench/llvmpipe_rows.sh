#!/usr/bin/env bash
# Prints rows of results.csv: frames of the six knots over llvmpipe's, both timed in turn with as many threads (bench_llvmpipe.c).
# Environment: B (build folder). Needs bench_llvmpipe, the scene and gold's tables: make bench builds them.
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
frame=$B/bench/gold_specular_frame.ktx2
for size in 320x240 1280x720 3840x2160; do
    for threads in 1 2; do
        lines=$("$B/bench/bench_llvmpipe" ${size/x/ } $threads "$B/bench/six_knots.blob" "$frame" "$B/bench/gold_64K_packed.ktx2" "$frame")
        awk -v scene="six_knots_$size" -v threads=threads_$threads '
            { print "frame,x86-64," scene "," ($2 ~ /specular_frame/ ? "specular_frame_" : "") threads ",over_llvmpipe," $8 ",ratio" }' <<<"$lines"
    done
done
