#!/usr/bin/env bash
# Writes a board's input: four uint32_t, how many bytes each of three files has and NUMBER; then the files, each at a multiple of 16 bytes.
#   tests/board/input.sh OUT NUMBER FILE FILE FILE
set -eu
out=$1 number=$2
shift 2
# Four bytes, the lowest first.
little() { printf "$(printf '\\x%02x\\x%02x\\x%02x\\x%02x' $(($1 & 255)) $(($1 >> 8 & 255)) $(($1 >> 16 & 255)) $(($1 >> 24)))"; }
{
    for part in "$@"; do little "$(stat -Lc %s "$part")"; done
    little "$number"
} >"$out"
for part in "$@"; do
    truncate -s %16 "$out"
    cat "$part" >>"$out"
done
