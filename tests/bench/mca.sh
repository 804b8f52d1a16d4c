#!/usr/bin/env bash
# Prints rows of results.csv: cycles of an iteration of the rasterizer's inner loops by llvm-mca's models of Cortex-M4 and M7, from the
# boards' objects. Needs those (make boards-build), llvm-14 and the binutils.
#
# A loop is an innermost one of its function's: from the target of a branch backwards to the branch. Where there are several, the
# longest that has an instruction matching the one given. Its instructions count as if all were executed, whichever way its own branches and conditions
# go, with caches that hit and branches that are predicted; IT, which the cores fold, is left out.
# Environment: B (build folder).
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}

# The loop's instructions as llvm-mca reads them.
loop_text() { # object function instruction
    arm-none-eabi-objdump -d --no-show-raw-insn --disassemble="$2" "$1" | awk -v want="$3" '
        function value(digits,    v, i) {
            for (i = 1; i <= length(digits); i++)
                v = 16 * v + index("0123456789abcdef", substr(digits, i, 1)) - 1
            return v
        }
        /^ *[0-9a-f]+:\t/ && $2 !~ /^\.(word|short|byte)$/ {
            line = $0
            sub(/:.*/, "", line)
            gsub(/ /, "", line)
            at[n] = value(line)
            text[n] = $0
            sub(/^[^\t]*\t/, "", text[n])
            if ($2 ~ /^(b|b(eq|ne|cs|cc|mi|pl|hi|ls|ge|lt|gt|le))(\.[nw])?$/ || $2 ~ /^cbn?z$/) {
                target[n] = value($2 ~ /^cb/ ? $4 : $3)
                sub(/[0-9a-f]+ <.*/, "loop", text[n])
            }
            n++
        }
        END {
            for (last = 0; last < n; last++) {
                if (!(last in target) || target[last] > at[last])
                    continue
                found = 0
                for (first = last; first > 0 && at[first] > target[last]; first--)
                    if (first < last && first in target && target[first] <= at[first] && target[first] >= target[last])
                        found = -1 # a loop inside
                for (i = first; found >= 0 && i <= last; i++)
                    found += text[i] ~ "^" want
                if (found > 0 && last - first + 1 > length_best) {
                    length_best = last - first + 1
                    best = first
                }
            }
            print "\t.syntax unified\nloop:"
            for (i = best; i < best + length_best; i++) {
                split(text[i], word, "\t")
                mnemonic = word[1]
                sub(/\.[nw]$/, "", mnemonic) # widths that the other assembler would refuse
                if (mnemonic ~ /^it[te]*$/) {
                    conditional = length(mnemonic) - 1
                    continue
                }
                if (conditional && conditional--)
                    sub(/..$/, "", mnemonic)
                print "\t" mnemonic "\t" substr(text[i], length(word[1]) + 2)
            }
        }'
}

row() { # target loop object function instruction
    local text cycles
    text=$(loop_text "$B/board/$1/raster/$3.o" "$4" "$5")
    cycles=$(llvm-mca-14 -mtriple=thumbv7em-none-eabi -mcpu="$1" -iterations=1000 <<<"$text" |
        awk '$1 == "Total" && $2 == "Cycles:" { print $3 / 1000 }')
    [ -n "$cycles" ] && [ "$(wc -l <<<"$text")" -gt 5 ] || { echo "mca: $1: no loop with $5 in $4" >&2; exit 1; }
    echo "raster,$1,$2,default,cycles_per_iteration_mca,$cycles,cycles"
}

for target in cortex-m4 cortex-m7; do
    row $target fill_span small raster_fill_small 'strd.*[[]r'
    row $target diffuse_pixel diffuse shade_diffuse_row udiv
    row $target blinn_phong_pixel_light blinn_phong_run shade_blinn_phong_row clz
done
