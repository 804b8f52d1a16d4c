#!/usr/bin/env bash
# The freestanding folders compile for every target with nothing but the compiler's own headers, link together, and ask
# the run-time library for no more than design allows. TAP on stdout.
cd "$(dirname "$0")/.." || exit 1
. tests/tap.sh
. tests/targets.sh

echo "1..$(($(wc -w <<<"$TARGETS") * 3 + 3))"
for t in $TARGETS; do
    out=$work/$t problems=
    for folder in lut raster firmware; do
        files=$(ls $folder/*.c 2>&1) && problems+=$(target_compile "$t" "$out" "" $files 2>&1) ||
            problems+="$folder does not compile for $t"$'\n'
    done
    claim "every_file_compiles_for_$t" "$problems"
    problems=$(target_link "$t" "$work/$t.o" "$out"/*.o 2>&1) && [ -e "$work/$t.o" ] || problems+=" not linked"
    claim "the_three_folders_link_together_for_$t" "$problems"
    if [ -e "$work/$t.o" ]; then
        problems=$("$(target_binutils "$t")nm" -u "$work/$t.o" | awk '{ print $NF }' | grep -vxE "$(target_allowed "$t")")
    fi
    claim "undefined_symbols_are_on_the_list_for_$t" "$problems"
done
# The sections of variables: d, b and c, and their small-data forms. Not asked of x86-64, where position-independent code
# files constant tables of pointers under relocated data.
claim objects_hold_no_mutable_data "$(arm-none-eabi-nm -A "$work"/cortex-m7/*.o | sed "s|$work/||" | grep -E ' [dDbBcCsSgG] ')"
problems=$(target_compile cortex-m7 "$work/graph" -fcallgraph-info=su lut/*.c raster/*.c firmware/*.c 2>&1 &&
    awk -f tests/bench/stack.awk "$work"/graph/*.ci)
claim "no_function_recurses_or_sizes_its_stack_at_run_time" "$problems"
problems=$(target_product cortex-m7 measured_lafortune "$work/product.o" 2>&1)
problems+=$(arm-none-eabi-nm --defined-only "$work/product.o" 2>&1 |
    grep -E ' [tT] .*(specular_frame|lut_eval|lut_half_vector|lut_interpolate|blinn|metallic|diffuse_row|point_light|light_box|cells|survey|bound|budget|fewer|loop_four|loop_one)')
named=$(arm-none-eabi-nm --defined-only "$work/product.o" | grep -cE ' T (raster_begin|raster_half_vector_arm|raster_shade_lafortune_phong_loop)$')
[ "$named" = 3 ] || problems+=" what it does name is missing"
claim a_product_links_no_part_that_it_does_not_name "$problems"
