#!/usr/bin/env bash
# Prints rows of results.csv: what the six models take, measured, at the smallest budget whose picture is a mean dE of at most 0.3 from full
# quality, over Lafortune-Phong at full quality; whole frames on emulated boards, culling and binning included, a picture that has come to
# rest. The scheduler chooses; the budget is bisected, to a part in 128 of what full quality takes. Mean dE: CIE 1976.
#   measured_over_lafortune_de03                  the pixels that show a model; or the frame without a budget, where that takes less
#   measured_over_lafortune_de03_scheduler        the same at a budget, whatever the frame without takes
#   measured_over_lafortune_de03_scheduler_frame  at a budget, mean dE of the whole picture, background included
#   tests/bench/de03_rows.sh [TARGET...]
# Environment: B (build folder). Needs what make bench builds.
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
LIMIT_DE=0.3 STEPS=7
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
tables=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green)
tables=("${tables[@]/#/$B/demo/}")
tables=("${tables[@]/%/.ktx2}")
bytes=$((320 * 240 * 3))

field() { # line name
    awk -v name="$2" '{ for (i = 1; i < NF; i++) if ($i == name) print $(i + 1) }' <<<"$1"
}

# at TARGET BUDGET: the board's lines to $work/out; the pictures to $work/full.rgb and given.rgb, the last megabyte of its external memory.
at() {
    local target=$1 machine
    "$B/board/make_input" "$target" "$work/in" picture "$2" "$B/demo/six_models.blob" "${tables[@]}"
    LIMIT=120 tests/board/run.sh "$target" "$B/board/$target/budget.elf" "$work/in" \
        -object "memory-backend-file,id=memory,size=16M,mem-path=$work/memory,share=on" -machine memory-backend=memory >"$work/out" || return 1
    tail -c 1M "$work/memory" | head -c $bytes >"$work/full.rgb"
    tail -c 1M "$work/memory" | tail -c +$((bytes + 1)) | head -c $bytes >"$work/given.rgb"
}

# smallest TARGET FIELD: the frame's ticks at the smallest budget whose FIELD of report_difference is within the limit, and that line
smallest() {
    local low high middle best= line
    low=$(field "$full" least)
    high=$((($(field "$full" fixed) + $(field "$full" shading)) / 40 * 11 / 10)) # 40 tiles; survey and choice come on top
    for ((i = 0; i < STEPS; i++)); do
        middle=$(((low + high) / 2))
        at "$1" $middle || { cat "$work/out" >&2; exit 1; }
        line=$("$B/report_difference" "$work/full.rgb" "$work/given.rgb")
        if awk -v de="$(field "$line" "$2")" -v limit=$LIMIT_DE 'BEGIN { exit !(de <= limit) }'; then
            high=$middle
            best="$(field "$(grep ^given "$work/out")" frame) $line budget $middle"
        else
            low=$middle
        fi
    done
    echo "$best"
}

ratio() { # a b
    awk -v a="$1" -v b="$2" 'BEGIN { printf "%.3f", a / b }'
}
row() { # target metric ticks lafortune
    echo "budget,$1,all,total,measured_over_lafortune_$2,$(ratio "$3" "$4"),ratio"
}
frame() { # target image: instructions of the firmware's frame
    field "$(tests/board/run.sh "$1" "$B/board/$1/firmware.elf" "$B/board/$2.img")" instructions
}

for target in ${*:-cortex-m3 cortex-m4 cortex-m7}; do
    at "$target" 2000000
    full=$(grep ^full "$work/out")
    lafortune=$(frame "$target" lafortune_phong) measured=$(frame "$target" measured)
    shown=$(smallest "$target" de_mean) picture=$(smallest "$target" de_frame)
    [ -n "$shown" ] && [ -n "$picture" ] || { echo "de03_rows: $target: no budget is within $LIMIT_DE" >&2; exit 1; }
    row "$target" de03 $((${shown%% *} < measured ? ${shown%% *} : measured)) "$lafortune"
    row "$target" de03_scheduler "${shown%% *}" "$lafortune"
    row "$target" de03_scheduler_frame "${picture%% *}" "$lafortune"
    echo "de03_rows: $target: Lafortune-Phong $lafortune, measured without a budget $measured; at budgets $shown; $picture" >&2
done
