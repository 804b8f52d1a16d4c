#!/usr/bin/env bash
# Measures and writes $B/bench/results.csv; prints it as a table. Needs bench_frame and the demo's scene and tables
# (make bench builds them), the boards' programs, valgrind, llvm-mca and the cross compilers.
#
# Instruction counts repeat exactly with one compiler; milliseconds are this machine's. Frames: 320 x 240, RGB888, culling and binning
# included, loading excluded.
# RAM is everything but the flash-resident meshes, tables and code, on Cortex-M7:
#   arena   bins and transforms of this very frame; taken on x86-64, whose pointers are larger: an upper bound
#   stack   the deepest path by -fstack-usage; what the board's functions add is not in it
#   total   arena, struct app (USB, protocol buffers, table store, the tile, the frame's state), one statistics record per
#           tile, and app_poll's stack
#   renderer  the same for a product that embeds lut/ and raster/ only: arena, struct raster, struct raster_tile, stack
set -eu
cd "$(dirname "$0")/../.."
. tests/targets.sh
B=${B:-build}
scene=$B/demo/six_models.blob
# In the order of the scene's table slots.
tables=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green)
tables=("${tables[@]/#/$B/demo/}")
tables=("${tables[@]/%/.ktx2}")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
csv=$work/results.csv

row() { # suite target case variant metric value unit
    [ -n "$6" ] || { echo "bench: $*: no value was measured" >&2; exit 1; }
    (IFS=, && echo "$*") >>"$csv"
}
row suite target case variant metric value unit

# --- frame: time and instructions on this machine ---
case=six_models_320x240
declare -A instructions
for model in measured_aa4 lafortune_phong_aa4 measured lafortune_phong; do
    ms=$("$B/bench/bench_frame" $model 51 "$scene" "${tables[@]}" | awk '$1 == "ms_per_frame" { print $2 }')
    valgrind --tool=callgrind --toggle-collect='bench_frame*' --callgrind-out-file="$work/callgrind" \
        "$B/bench/bench_frame" $model 1 "$scene" "${tables[@]}" >"$work/out" 2>"$work/log" ||
        { cat "$work/log" >&2; exit 1; }
    instructions[$model]=$(awk '$1 == "summary:" { print $2 }' "$work/callgrind")
    [ "${instructions[$model]:-0}" -gt 0 ] || { echo "bench: callgrind counted no instructions of bench_frame" >&2; exit 1; }
    row frame x86-64 $case $model instructions_per_frame "${instructions[$model]}" instructions
    row frame x86-64 $case $model ms_per_frame "$ms" ms
    [ $model != measured_aa4 ] || arena_aa4=$(awk '$1 == "arena_bytes" { print $2 }' "$work/out")
done
row frame x86-64 $case measured_over_lafortune_phong instructions_per_frame \
    "$(awk "BEGIN { printf \"%.3f\", ${instructions[measured]} / ${instructions[lafortune_phong]} }")" ratio
arena=$(awk '$1 == "arena_bytes" { print $2 }' "$work/out")

# --- size: code ---
for t in cortex-m0 cortex-m3 cortex-m4 cortex-m7 rv32imac; do
    for part in lut raster firmware lut+raster; do
        objects=()
        for folder in ${part/+/ }; do
            [ -d "$work/$t/$folder" ] || target_compile "$t" "$work/$t/$folder" -fcallgraph-info=su $folder/*.c
            objects+=("$work/$t/$folder"/*.o)
        done
        target_link "$t" "$work/linked.o" "${objects[@]}"
        row size $t "$part" O2 text_bytes "$(target_text_bytes $t "$work/linked.o")" bytes
    done
done

tests/bench/products.sh >>"$csv"

# --- size: RAM ---
t=cortex-m7
cat >"$work/sizes.c" <<'SIZES'
#include "app.h"
char sizeof_app[sizeof(struct app)], sizeof_raster[sizeof(struct raster)], sizeof_tile[sizeof(struct raster_tile)],
    sizeof_tile_stats[sizeof(struct usb_tile_stats)],
    tile_count[((320 - 1) / RASTER_TILE_WIDTH + 1) * ((240 - 1) / RASTER_TILE_HEIGHT + 1)];
SIZES
target_compile $t "$work/sizes" "" "$work/sizes.c"
size_of() { # symbol
    arm-none-eabi-nm -S "$work"/sizes/*.o | awk -v s="$1" '$4 == s { print "0x" $2 }'
}
stack_of() { # function
    awk -v root="$1" -f tests/bench/stack.awk "$work/$t"/*/*.ci
}
begin=$(stack_of raster_begin)
render=$(stack_of raster_render_tile)
poll=$(stack_of app_poll)
renderer_stack=$((begin > render ? begin : render))
statistics=$(($(size_of tile_count) * $(size_of sizeof_tile_stats)))
row size $t $case arena ram_bytes "$arena" bytes
row size $t $case tile ram_bytes $(($(size_of sizeof_tile))) bytes
row size $t $case app ram_bytes $(($(size_of sizeof_app))) bytes
row size $t $case tile_statistics ram_bytes $statistics bytes
row size $t $case renderer_stack ram_bytes $renderer_stack bytes
row size $t $case app_stack ram_bytes "$poll" bytes
row size $t $case renderer ram_bytes $((arena + $(size_of sizeof_raster) + $(size_of sizeof_tile) + renderer_stack)) bytes
row size $t ${case}_aa4 renderer ram_bytes $((arena_aa4 + $(size_of sizeof_raster) + $(size_of sizeof_tile) + renderer_stack)) bytes
row size $t $case total ram_bytes $((arena + $(size_of sizeof_app) + statistics + poll)) bytes

# --- emulated boards, comparison frames, inner loops ---
B=$B tests/board/bench.sh "$csv"
B=$B tests/bench/mca.sh >>"$csv"
B=$B tests/bench/raster_rows.sh >>"$csv"

# --- shading: cost and error of every table and model; beside llvmpipe ---
B=$B tests/bench/shade_rows.sh >>"$csv"
# The tables of costs are what they were measured to be.
for target in cortex-m3 cortex-m4 cortex-m7; do
    B=$B tests/board/calibrate.sh $target "$work/costs.h" 2>/dev/null
    cmp "$work/costs.h" hal/costs/${target//-/_}.h || { echo "bench: make calibrate BOARD=$target has not been run" >&2; exit 1; }
done
B=$B GONIOTILE_ROWS=$csv tests/e2e/test_budget_boards.sh >"$work/budget" 2>&1 || { cat "$work/budget" >&2; exit 1; }
B=$B tests/bench/de03_rows.sh >>"$csv" 2>"$work/de03" || { cat "$work/de03" >&2; exit 1; }
"$B/bench/bench_tables" >"$work/tables"
grep -v '^#' "$work/tables" >>"$csv" || cat "$work/tables" >&2 # the data folder is missing
B=$B tests/bench/llvmpipe_rows.sh >>"$csv"

# --- environment maps as directional lights ---
"$B/bench/bench_envlight" >"$work/envlight"
grep -v '^#' "$work/envlight" >>"$csv" || cat "$work/envlight" >&2 # the data folder is missing

# --- USB: faults, the bus, what a push costs the device ---
"$B/bench/bench_usb" faults >>"$csv"
"$B/bench/bench_usb" bus "$scene" "${tables[@]}" >>"$csv"
"$B/bench/bench_usb" requests "$work/requests"
line=$(tests/board/run.sh cortex-m4 "$B/board/cortex-m4/push.elf" "$work/requests") || { echo "bench: push.elf: $line" >&2; exit 1; }
row usb cortex-m4 all total instructions_per_byte "$(awk '{ printf "%.2f", $7 / $3 }' <<<"$line")" instructions

mkdir -p "$B/bench"
mv "$csv" "$B/bench/results.csv"
awk -F, '{ printf "%-6s %-10s %-20s %-29s %-23s %12s %s\n", $1, $2, $3, $4, $5, $6, $7 }' "$B/bench/results.csv"
echo "written: $B/bench/results.csv"
