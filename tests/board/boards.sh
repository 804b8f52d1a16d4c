#!/usr/bin/env bash
# Runs the firmware on every emulated board with the six models, measured and Lafortune-Phong, and prints one line per board and model;
# fails when a picture differs from another, the host's included. Needs the programs: make boards builds them.
#   hash          FNV-1a of the picture, 320 x 240, RGB888
#   instructions  of one frame: culling, binning and all tiles
#   text          code and constants of the whole program
#   data+bss      its variables: the firmware's, which include the tile, an arena of 64 KB, tile statistics
#   frame needs   the same with an arena as large as this frame asks for, and the stack seen
#   stack         deepest path by the compiler's call graph from reset (calls through the hal not followed), and the deepest
#                 seen at run time, interrupt-free
set -u
cd "$(dirname "$0")/../.." || exit 1
. tests/targets.sh
B=${B:-build}
tables=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green)
tables=("${tables[@]/#/$B/demo/}")
tables=("${tables[@]/%/.ktx2}")
declare -A scene=([measured]=$B/demo/six_models.blob [lafortune_phong]=$B/board/six_models_lafortune.blob)
bad=0

field() { # line name
    awk -v name="$2" '{ for (i = 1; i < NF; i++) if ($i == name) print $(i + 1) }' <<<"$1"
}

declare -A hash
same() { # who model hash
    : "${hash[$2]:=$3}"
    [ -n "$3" ] && [ "$3" = "${hash[$2]}" ] && return
    echo "$1: $2: hash ${3:-missing}, not ${hash[$2]}" >&2
    bad=1
}

symbol_bytes() { # target program symbol
    echo $((0x$("$(target_binutils "$1")nm" -S "$2" | awk -v s="$3" '$4 == s { print $2 }')))
}

section_bytes() { # target program section_regex
    "$(target_binutils "$1")size" -A "$2" | awk -v s="$3" '$1 ~ s { n += $2 } END { print n + 0 }'
}

for model in measured lafortune_phong; do
    for program in "$B"/board/host_hash-*; do
        same "${program##*host_hash-}" $model "$(field "$("$program" 320 240 rgb888 "${scene[$model]}" "${tables[@]}")" hash)"
    done
done
format='%-10s %-15s %8s %12s %8s %9s %11s %10s %10s\n'
table=$(printf "$format" board model hash instructions text data+bss 'frame needs' 'stack path' 'stack seen')
for program in "$B"/board/*/firmware.elf; do
    target=$(basename "$(dirname "$program")")
    text=$(section_bytes "$target" "$program" '^\.(vectors|text|data)$')
    ram=$(section_bytes "$target" "$program" '^\.(data|bss)$')
    spare=$(symbol_bytes "$target" "$program" arena)
    case $target in rv32imac) start=rv32_start ;; *) start=cortex_m_start ;; esac
    path=$(find "$B/board/$target" -name '*.ci' -not -path '*/tests/*' -print0 |
        xargs -0 awk -v root=$start -f tests/bench/stack.awk)
    for model in measured lafortune_phong; do
        line=$(tests/board/run.sh "$target" "$program" "$B/board/$model.img") || { echo "$target: $model: $line" >&2; bad=1; }
        same "$target" $model "$(field "$line" hash)"
        seen=$(field "$line" stack)
        table+=$'\n'$(printf "$format" "$target" $model "$(field "$line" hash)" "$(field "$line" instructions)" "$text" "$ram" \
            $((ram - spare + $(field "$line" arena) + seen)) "$path" "$seen")
    done
done
tee "$B/board/boards.txt" <<<"$table"
exit $bad
