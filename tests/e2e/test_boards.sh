#!/usr/bin/env bash
# The firmware on emulated boards: pictures, faults, the display of the smallest one, and that the template compiles.
# `make boards-build` makes the programs.
B=${B:-build}
. tests/tap.sh
. tests/targets.sh

echo 1..5
problems=$(B=$B tests/board/boards.sh 2>&1 >"$work/table")
[ "$(wc -l <"$work/table")" = 13 ] || problems+=" six boards and two models make 13 lines, not $(wc -l <"$work/table")"
claim pictures_are_equal_on_all_boards_compilers_levels_and_tile_sizes "$problems"
sed 's/^/# /' "$work/table"

problems=$(awk 'NR > 1 && $8 < $9 { print $1, "used", $9, "bytes of stack, the call graph says", $8 }' "$work/table")
claim no_board_uses_more_stack_than_its_call_graph_says "$problems"

problems=
for program in "$B"/board/*/fault.elf; do
    target=$(basename "$(dirname "$program")")
    for kind in s r w; do
        printf %s $kind >"$work/kind"
        said=$(LIMIT=20 tests/board/run.sh "$target" "$program" "$work/kind" 2>&1)
        code=$?
        # The guard's own exception: memory management, or the limit register's usage fault; on RV32 a store access fault.
        case $code$kind$said in
        70s*'exception '[46]*'stack overflow'* | 70s*'cause 7'*'stack overflow'*) ;;
        70[rw]*fault*) ;;
        *) problems+="$target: $kind: status $code: $said"$'\n' ;;
        esac
    done
done
claim stack_overflow_and_accesses_to_address_0_end_the_emulator_with_status_70 "$problems"

problems=$({
    "$B/board/host_hash-gcc-O2" 128 64 rgb888 -o "$work/frame" "$B/board/oled.blob" "$B/board/gold_91x46.ktx2" >/dev/null &&
        tests/board/screenshot.sh "$B/board/lm3s6965/oled.elf" "$work/shot.ppm" >"$work/report" &&
        "$B/board/compare_oled" "$work/frame" "$work/shot.ppm" >>"$work/report"
} 2>&1) || problems+=" no picture"
claim the_oled_shows_the_frame_that_the_host_renders "$problems"
sed 's/^/# /' "$work/report"

problems=$(for t in cortex-m0 rv32imac; do target_compile $t "$work/$t" "" hal/template/*.c 2>&1; done)
claim the_template_compiles_for_cortex_m0_and_rv32 "$problems"
