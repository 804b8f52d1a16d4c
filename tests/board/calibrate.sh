#!/usr/bin/env bash
# Measures what the steps of a tile take on an emulated board and fits the table of costs to it (tests/board/calibrate/main.c,
# tests/bench/calibrate.c). Needs the programs, the demo's scene and tables: make calibrate.
#   tests/board/calibrate.sh TARGET OUT.h
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
target=$1 out=$2
input=$B/board/$target/calibrate.bin
tests/board/input.sh "$input" 0 "$B/demo/six_models.blob" "$B/demo/gold.ktx2" "$B/board/gold_91x46.ktx2"
mkdir -p "$(dirname "$out")"
LIMIT=600 tests/board/run.sh "$target" "$B/board/$target/calibrate.elf" "$input" >"$B/board/$target/calibrate.txt"
"$B/bench/calibrate" "$target" "$B/board/$target/calibrate.txt" >"$out.new"
clang-format-14 -i --style=file:.clang-format "$out.new" 2>/dev/null || true
mv "$out.new" "$out"
