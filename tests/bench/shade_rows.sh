#!/usr/bin/env bash
# Prints rows of results.csv, suite `shade`: what shading costs by kind of table and model, how far its integers are from double precision,
# and what frames of the six models cost beside the same in Lafortune-Phong. Variants are <kind>-<bytes of texels and warps>-<texels read>;
# `half_vector` has the re-packed copy, `portable-half_vector` is without, and on x86-64 built for any such processor.
# Environment: B (build folder). Needs the programs and tables that make bench builds, valgrind and the emulators.
#
#   instructions_per_pixel_light  per lit pixel-light (n.l > 0, n.v > 0), block set-up included, tone curve and packing excluded:
#                                 tests/board/shade/main.c on boards, callgrind on x86-64
#   gather_instructions_per_pixel what shading a covered pixel takes besides, without tone curve and packing
#   ns_per_pixel_light            one thread; ns_per_covered_pixel_light: of all covered pixels' lights
#   cycles_per_pixel_light_mca    llvm-mca's model of Cortex-M7 over instructions as they are executed amid the sphere in the model's functions,
#                                 branches predicted and caches that hit, times instructions_per_pixel_light
#   steps_*, within_1_step        the integers against double precision from the same table and normals: 8-bit steps, share of channels
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

field() { # line name
    awk -v name="$2" '{ for (i = 1; i < NF; i++) if ($i == name) print $(i + 1) }' <<<"$1"
}

row() { # target case variant metric value unit
    [ -n "$5" ] || { echo "shade_rows: $*: no value was measured" >&2; exit 1; }
    (IFS=, && echo "shade,$*")
}

counted() { # function program argument...: its instructions
    local function=$1 count
    shift
    valgrind --tool=callgrind --toggle-collect="$function" --callgrind-out-file="$work/callgrind" "$@" >"$work/out" 2>"$work/log" ||
        { cat "$work/log" >&2; exit 1; }
    count=$(awk '$1 == "summary:" { print $2 }' "$work/callgrind")
    [ "${count:-0}" -gt 0 ] || { echo "shade_rows: callgrind counted no instructions of $function in $*" >&2; exit 1; }
    echo "$count"
}

ratio() { # decimals a b
    awk -v d="$1" -v a="$2" -v b="$3" 'BEGIN { printf "%." d "f", a / b }'
}

# Cycles per instruction by llvm-mca, in the functions that evaluate models and tables.
cycles_per_instruction() { # target input
    local names=raster_half_vector:raster_shade_lafortune_phong:shade_half_vector:shade_specular_frame:shade_lafortune_phong
    local program=$B/board/$1/shade.elf count=100000
    names+=:shade_blinn_phong:shade_metallic_roughness:lut_specular_frame:lut_interpolate:lut_angle:lut_turn
    tests/board/run.sh "$1" "$program" "$2" -plugin "$B/board/trace.so,names=$names,skip=200000,count=$count" >"$work/out" 2>"$work/trace"
    [ "$(wc -l <"$work/trace")" = $count ] || { echo "shade_rows: $1: no trace" >&2; exit 1; }
    arm-none-eabi-objdump -d --no-show-raw-insn "$program" >"$work/disassembly"
    awk -f tests/bench/trace_text.awk "$work/disassembly" "$work/trace" >"$work/trace.s"
    llvm-mca-14 -mtriple=thumbv7em-none-eabi -mcpu="$1" -iterations=1 "$work/trace.s" 2>"$work/log" |
        awk -v n=$count '$1 == "Total" && $2 == "Cycles:" { printf "%.4f", $3 / n }'
}

program_of() { # variant
    case $1 in portable-*) echo "$B/bench/bench_shade_portable" ;; *) echo "$B/bench/bench_shade" ;; esac
}

# Against double precision. Leaves the hash of the radiances in $hash.
errors() { # material variant input
    local line
    line=$("$(program_of "$2")" error "$3")
    hash=$(field "$line" hash)
    for metric in steps_p99 steps_p999 steps_max; do
        row x86-64 "$1" "$2" $metric "$(field "$line" $metric)" steps
    done
    row x86-64 "$1" "$2" within_1_step "$(field "$line" within_1_step)" ratio
}

# One table or model on all targets; the radiances must be the same everywhere.
shading() { # material variant kind [table]
    local material=$1 variant=$2 kind=$3 table=${4-} input line lit dark target program
    program=$(program_of "$variant")
    input=$(tests/board/shade.sh input "$kind" $table)
    errors "$material" "$variant" "$input"
    line=$("$program" time "$input" 101)
    for metric in ns_per_pixel_light ns_per_covered_pixel_light; do
        row x86-64 "$material" "$variant" "$metric" "$(field "$line" $metric)" ns
    done
    dark=$(counted picture_dark "$program" count "$input")
    lit=$(counted picture_lit "$program" count "$input")
    row x86-64 "$material" "$variant" instructions_per_pixel_light "$(ratio 1 $((lit - dark)) "$(field "$(<"$work/out")" lit)")" instructions
    for target in cortex-m3 cortex-m4 cortex-m7; do
        line=$(tests/board/run.sh $target "$B/board/$target/shade.elf" "$input") || { echo "shade_rows: $target: $variant: $line" >&2; exit 1; }
        [ "$(field "$line" hash)" = "$hash" ] || { echo "shade_rows: $target: $variant: other radiances than on x86-64" >&2; exit 1; }
        row "$target" "$material" "$variant" instructions_per_pixel_light "$(field "$line" per_pixel_light)" instructions
        [ $target != cortex-m7 ] ||
            row $target "$material" "$variant" cycles_per_pixel_light_mca \
                "$(awk -v n="$(field "$line" per_pixel_light)" -v c="$(cycles_per_instruction $target "$input")" 'BEGIN { if (c) printf "%.1f", n * c }')" cycles
        row "$target" "$material" "$variant" gather_instructions_per_pixel "$(field "$line" gather)" instructions
    done
}

# Of texels and warps.
table_bytes() { # file warps
    "$B/gtlut" info "$1" | awk -v warps="$2" '$1 == "texels:" { print $2 * $4 * $6 * 4 + warps }'
}

for size in 64K 16K 4K; do
    table=$B/bench/gold_$size
    bytes=$(table_bytes "$table.ktx2" 388)
    shading gold "half_vector-$bytes-8" half_vector "${table}_packed.ktx2"
    packed=$hash
    shading gold "portable-half_vector-$bytes-8" half_vector "$table.ktx2"
    [ "$hash" = "$packed" ] || { echo "shade_rows: $size: other radiances from the re-packed copy" >&2; exit 1; }
    row host gold "half_vector-$bytes-8" packed_bytes "$("$B/gtlut" info "${table}_packed.ktx2" | awk '/^re-packed copy:/ { print $3 }')" bytes
done
for taps in 4 1; do # errors are those of leaving texels out
    TAPS=$taps shading gold "half_vector-$(table_bytes "$B/bench/gold_64K.ktx2" 388)-$taps" half_vector "$B/bench/gold_64K_packed.ktx2"
done
frame=$B/bench/gold_specular_frame.ktx2
shading gold "specular_frame-$(table_bytes "$frame" 0)-8" specular_frame "$frame"
for model in lafortune_phong blinn_phong metallic_roughness; do
    shading gold "$model-0-0" $model
done

# --- the integers of other materials' tables ---
for table in "$B"/bench/*_64K.ktx2; do
    material=$(basename "${table%_64K.ktx2}")
    [ "$material" = gold ] || errors "$material" "half_vector-$(table_bytes "$table" 388)-8" "$(tests/board/shade.sh input half_vector "$table")"
done

# --- the six models' frame, measured over Lafortune-Phong: by instructions; on x86-64 by time, too ---
materials=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green)
case=six_models_320x240
frame_rows() { # variant tables_suffix
    local tables=("${materials[@]/#/$B/bench/}") measured lafortune target
    tables=("${tables[@]/%/_$2.ktx2}")
    measured=$(counted 'bench_frame*' "$B/bench/bench_frame" measured 1 "$B/demo/six_models.blob" "${tables[@]}")
    lafortune=$(counted 'bench_frame*' "$B/bench/bench_frame" lafortune_phong 1 "$B/demo/six_models.blob" "${tables[@]}")
    row x86-64 "$case" "$1" measured_over_lafortune "$(ratio 3 "$measured" "$lafortune")" ratio
    measured=$("$B/bench/bench_frame" measured 51 "$B/demo/six_models.blob" "${tables[@]}")
    lafortune=$("$B/bench/bench_frame" lafortune_phong 51 "$B/demo/six_models.blob" "${tables[@]}")
    measured=$(field "$measured" ms_per_frame)
    lafortune=$(field "$lafortune" ms_per_frame)
    row x86-64 "$case" "${1}_time" measured_over_lafortune "$(ratio 3 "$measured" "$lafortune")" ratio
    for target in cortex-m3 cortex-m7; do
        measured=$(field "$(tests/board/run.sh $target "$B/board/$target/firmware.elf" "$B/bench/six_models_$2.img")" instructions)
        lafortune=$(field "$(tests/board/run.sh $target "$B/board/$target/firmware.elf" "$B/board/lafortune_phong.img")" instructions)
        row "$target" "$case" "$1" measured_over_lafortune "$(ratio 3 "$measured" "$lafortune")" ratio
    done
}
frame_rows full 64K_packed
frame_rows full_plain 64K # without the re-packed copy
frame_rows full_specular_frame specular_frame
"$B/bench/bench_models"
