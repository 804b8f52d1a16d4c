#!/usr/bin/env bash
# Every way of shading at every rate, under directional and point lights, with one and four samples per pixel: the emulated boards' pixels are the
# host's (tests/board/calibrate/main.c, its short walk).
set -u
B=${B:-build}
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT
echo 1..1
tests/board/input.sh "$work/in" 23 "$B/demo/six_models.blob" "$B/demo/gold.ktx2" "$B/board/gold_91x46.ktx2"
host=$("$B/board/calibrate-host" <"$work/in" 2>&1)
problems=
for target in cortex-m3 cortex-m7 cortex-m33 rv32imac; do
    said=$(LIMIT=200 tests/board/run.sh $target "$B/board/$target/calibrate.elf" "$work/in" 2>&1)
    [[ $said == "end hash "* && $said == "$host" ]] || problems+="$target: $said; host: $host"$'\n'
done
if [ -z "$problems" ]; then
    echo "ok 1 - rates_of_shading_give_the_same_bits_on_boards_and_the_host"
else
    echo "not ok 1 - rates_of_shading_give_the_same_bits_on_boards_and_the_host"
    sed 's/^/# /' <<<"$problems"
fi
