#!/usr/bin/env bash
# Speed against error: rates of shading x sizes of tables, and the comparison models; what budgets may choose from.
. tests/report/common.sh
names=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green)
kinds=(half_vector_{256K,64K,16K,4K,1K} specular_frame_361x181 lafortune_phong blinn_phong ggx) targets=(cortex-m7 cortex-m4 cortex-m3)
[ -z "$QUICK" ] || { kinds=(half_vector_{64K,1K}); targets=(); }
rates=(1x1 2x1 2x2 4x2 4x4 flat) taps=("" /4 /1)
rungs=() # of half-vector tables; others have those of all taps
for a in "${taps[@]}"; do for r in "${rates[@]}"; do [ -n "$a" ] && [ $r = flat ] || rungs+=("$r$a"); done; done

# $work/KIND: scene.blob, and 0.ktx2 to 5.ktx2 or 0.json to 5.json, the fits of a model.
one() { # KIND INDEX NAME
    local source=$B/demo/$3.csv to=$work/$1/$2
    case $1 in
    half_vector_64K) cp "$B/demo/$3.ktx2" "$to.ktx2" ;;
    half_vector_*) table "$source" "$to.ktx2" --size "${1##*_}" --packed ;;
    specular_frame_*) quietly "$B/gtlut" build "$source" -o "$to.ktx2" --kind specular_frame --size "${1##*_}" ;;
    *) "$B/gtlut" fit "$source" --model "$1" --json >"$to.json" ;;
    esac
}
for kind in "${kinds[@]}"; do
    mkdir "$work/$kind"
    for i in "${!names[@]}"; do echo "$kind $i ${names[i]}"; done
done >"$work/jobs"
each one <"$work/jobs"
for kind in "${kinds[@]}"; do
    if [ -e "$work/$kind/0.ktx2" ]; then
        cp "$B/demo/six_models.blob" "$work/$kind/scene.blob"
        continue
    fi
    node -e 'const read = (file) => JSON.parse(require("fs").readFileSync(file)), [scene, fits] = process.argv.slice(1), s = read(scene);
        s.materials = s.materials.map((m, i) => ({...read(`${fits}/${i}.json`).material, name: m.name}));
        console.log(JSON.stringify(s))' host_tools/scenes/six_models.json "$work/$kind" >"$work/$kind/scene.json"
    quietly "$B/gtscene" build "$work/$kind/scene.json" -o "$work/$kind/scene.blob"
done

# Errors, on this machine; costs, on the boards. Pictures are the same.
arguments=("$B/demo/six_models.blob")
for name in "${names[@]}"; do arguments+=("$B/demo/$name.csv"); done
for kind in "${kinds[@]}"; do arguments+=(/ "$work/$kind/scene.blob" $(find "$work/$kind" -name '*.ktx2' | sort)); done
"$B/report_rates" "${arguments[@]}" >"$work/errors"
count() { # TARGET KIND
    local to=$work/$2/$1
    "$B/board/make_input" "$1" "$to.in" rates 0 "$work/$2/scene.blob" $(find "$work/$2" -name '*.ktx2' | sort)
    LIMIT=300 tests/board/run.sh "$1" "$B/board/$1/budget.elf" "$to.in" >"$to.counts" || { cat "$to.counts" >&2; return 1; }
    rm "$to.in"
}
for target in "${targets[@]}"; do
    for kind in "${kinds[@]}"; do echo "$target $kind"; done
done >"$work/jobs"
[ -n "$QUICK" ] || each count <"$work/jobs"

csv=$OUT/8_budgets.csv
# Pixel-lights that full quality evaluates: the same for all.
lit=$(awk '$2 == 0 && !$4 { print $10 }' "$work/${kinds[0]}/${targets[0]-cortex-m7}.counts" 2>"$work/log" || true)
{
    echo 'target,representation,bytes,rate,per_pixel_light,unit,de_mean,psnr,largest_error,on_front'
    for n in "${!kinds[@]}"; do
        kind=${kinds[n]} bytes=56 # a material in a scene file
        [ ! -e "$work/$kind/2.ktx2" ] || bytes=$("$B/gtlut" info "$work/$kind/2.ktx2" | awk '$1 == "texels:" { print $2 * $4 * $6 * 4 }')
        while read -r _ _ r _ a _ hash _ ns _ de _ psnr _ largest; do
            rung=${rates[r]}${taps[a]}
            [[ $rung != flat/* ]] || continue
            echo "x86-64,$kind,$bytes,$rung,$ns,ns,$de,$psnr,$largest"
            for target in "${targets[@]}"; do
                read -r _ _ _ _ _ shading _ _ _ _ _ board < <(awk -v r="$r" -v a="$a" '$2 == r && $4 == a' "$work/$kind/$target.counts")
                [ "$board" = "$hash" ] || { echo "report: $target: $kind $rung: another picture than on x86-64" >&2; exit 1; }
                echo "$target,$kind,$bytes,$rung,$(awk -v a="$shading" -v b="$lit" 'BEGIN { printf "%.1f", a / b }'),instructions,$de,$psnr,$largest"
            done
        done < <(grep "^$n " "$work/errors")
    done | sort -t, -k1,1 -k5,5g -k7,7g | awk -F, '
        # By cost: on the front is what errs less than all that is cheaper.
        $1 != target { target = $1; least = 1e9 } { on = $7 < least; if (on) least = $7; print $0 "," on }'
} >"$csv"

# One plot for each target: all points, the front, and the ladder's points on the recommended table.
label() { sed 's/_/ /g; s/^half vector/half-vector/; s/^ggx/GGX/; s/^lafortune phong/Lafortune-Phong, fitted/; s/^blinn phong/Blinn-Phong, fitted/' <<<"$1"; }
colours=('#08306b' '#2171b5' '#4292c6' '#6baed6' '#9ecae1' '#d68910' '#1e8449' '#c0392b' '#7d3c98')
ladder=half_vector_64K
for target in x86-64 "${targets[@]}"; do
    unit=$(awk -F, -v t="$target" '$1 == t { print $6; exit }' "$csv")
    for kind in "${kinds[@]}"; do
        grep "^$target,$kind,[0-9]*,[0-9a-z]*," "$csv" >"$work/$kind.points" || true # of all taps
        grep "^$target,$kind,[0-9]*,[0-9x]*/" "$csv" >"$work/$kind.fewer" || true
    done
    # Cheapest first; a step to each.
    awk -F, -v OFS=, -v t="$target" '$1 == t && $10 == 1 { if (n++) print $5, last; print $5, $7; last = $7 }' "$csv" >"$work/front"
    plot "8_$target" 860x520 <<GNUPLOT
set logscale xy; set key outside right top Left reverse
$(awk -F, -v t="$target" '$1 == t { if (!n++) { x = X = $5; y = Y = $7 } if ($5 < x) x = $5; if ($5 > X) X = $5; if ($7 < y) y = $7; if ($7 > Y) Y = $7 }
        END { printf "set xrange [%g:%g]; set yrange [%g:%g]", x / 1.4, X * 1.2, y / 1.5, Y * 1.5 }' "$csv")
set xtics (5, 10, 20, 50, 100, 200, 500, 1000, 2000); set ytics (0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20)
set xlabel 'shading, $unit per pixel-light of full quality'; set ylabel 'mean dE (CIE 1976) from the measurement'
set title '$target$([ "$target" = x86-64 ] || echo " (QEMU), exact counts")'
plot '$work/front' using 1:2 with lines lw 7 lc rgb '#f5d9a8' title 'Pareto front', \\
$(for n in "${!kinds[@]}"; do
        echo "    '$work/${kinds[n]}.points' using 5:7 with linespoints lw 1 pt 7 ps 0.5 lc rgb '${colours[n]}' title '$(label "${kinds[n]}")', \\"
    done)
    '$work/$ladder.points' using 5:7 with points pt 6 ps 1.6 lw 2 lc rgb '#222222' title 'the ladder', \\
    '$work/$ladder.points' using 5:7:4 with labels offset -1.1,-0.6 right font ',12' notitle, \\
    '$work/$ladder.fewer' using 5:7 with points pt 4 ps 1.1 lw 1.5 lc rgb '#222222' title '... by 4 taps or 1', \\
    '$work/$ladder.fewer' using 5:7:(\$5 > $(awk -F, '$4 == "2x1" { print $5 }' "$work/$ladder.points") ? strcol(4) : '') with labels offset -1.1,-0.6 right font ',10' notitle
GNUPLOT
done

# Of a target: COLUMN of a representation at a rate.
value() { # target representation rate column
    awk -F, -v t="$1" -v k="$2" -v r="$3" -v c="$4" '$1 == t && $2 == k && $4 == r { print $c }' "$csv"
}
# The ladder's cheapest rate that errs no more than another representation at 1x1, and what it takes.
instead() { # target representation
    awk -F, -v de="$(value "$1" "$2" 1x1 7)" -v t="$1" -v k=$ladder '$1 == t && $2 == k && $7 <= de && (!n++ || $5 < least) { least = $5; rate = $4; error = $7 }
        END { printf "%s errs %.2f and takes %.0f", rate, error, least }' "$csv"
}
ratio() { awk -v a="$1" -v b="$2" 'BEGIN { printf "%.2f", a / b }'; }
main=${targets[0]-x86-64} # what the text is about
full=$(value "$main" $ladder 1x1 5)
cat <<MARKDOWN

## 8. Budgets: speed against error

The demo's six models at 320x240, three directional lights, every surface at one rate: 1x1 shades each pixel, 2x1 to 4x4 a cell of so many pixels of one meshlet once, flat a meshlet once per
tile. Tables of every size and models fitted to the same measurements (\`gtlut fit\`). Cost: shading alone (gathering, evaluating, tone curve, copying), over the lit pixel-lights of
full quality; instructions are exact, counted by QEMU; nanoseconds are of one thread of this machine, the fastest of some frames. Error: of the displayed 8-bit colours against the measurements in double precision,
at full rate and finest levels of detail, over pixels that show a model, but for those at its outline. The boards' pictures are this machine's, bit for bit.

$(for target in "${targets[@]}" x86-64; do printf '![speed against error, %s](8_%s.svg)\n\n' "$target" "$target"; done)

The ladder, what budgets choose from tile by tile and class by class of surfaces, is all rates of the table that a material has, by all of its 8 texels a look-up, by the 4 of the nearer azimuth (/4) or by the nearest one (/1), which a tile has in common; here of 64 KB. Stars: on the front.

$(awk -F, -v k=$ladder -v rates="${rungs[*]}" '
    $2 == k { cost[$4, $1] = $5 ($10 ? " \\*" : ""); de[$4] = $7; psnr[$4] = $8; worst[$4] = $9; if (!seen[$1]++) name[++n] = $1 }
    END { line = "rate"; for (i = 1; i <= n; i++) line = line "," name[i]; print line ",mean dE,PSNR dB,largest error"
        m = split(rates, r, " "); for (j = 1; j <= m; j++) { line = r[j]; for (i = 1; i <= n; i++) line = line "," cost[r[j], name[i]]; print line "," de[r[j]] "," psnr[r[j]] "," worst[r[j]] } }' "$csv" | markdown_table)

$(awk -F, -v k=$ladder '$6 != "instructions" { next } { t[++n] = $1; cost[n] = $5; de[n] = $7; own[n] = $2 == k }
    END { for (i = 1; i <= n; i++) if (own[i]) for (j = 1; j <= n; j++) if (t[j] == t[i] && cost[j] <= cost[i] && de[i] / de[j] > most) most = de[i] / de[j]
        if (n) printf "Where a rung is not on the front, a table of another size takes as much or little less: on the boards the front errs at most %.0f %% less than the rung at the same cost.\n\n", 100 * (1 - 1 / most) }' "$csv")

Why the others are not on the ladder, by $main; its first rung takes $full there:

$(awk -F, -v t="$main" -v full="$full" -v k=$ladder '$1 == t && $4 == "1x1" && $2 ~ /^half_vector/ { cost[$3] = $5; de[$3] = $7; if ($2 == k) own = $3; if (!n++ || $3 < least) least = $3; if ($3 > most) most = $3 }
    END { printf "- *Smaller tables*: at 1x1 one of %d bytes takes %.2f of what the one of %d does and errs %.2f instead of %.2f. A smaller table saves memory (chapter 6), not instructions, so there is nothing to choose at run time", least, cost[least] / full, own, de[least], de[own]
        if (most != own) printf "; one of %d bytes takes %.2f and errs %.2f", most, cost[most] / full, de[most]; print "." }' "$csv")
$([ ! -s "$work/specular_frame_361x181.points" ] || echo "- *The specular frame* takes $(ratio "$(value "$main" specular_frame_361x181 1x1 5)" "$full") of it and errs $(value "$main" specular_frame_361x181 1x1 7): it is there for what it is (chapter 1), not for speed; its own ladder has the same rates.")
$(for kind in "${kinds[@]}"; do
    case $kind in half_vector* | specular_frame*) continue ;; esac
    echo "- *$(label $kind)* takes $(ratio "$(value "$main" $kind 1x1 5)" "$full") of it and errs $(value "$main" $kind 1x1 7). The ladder's $(instead "$main" $kind). Another model instead of the table would also change the material's colour from tile to tile."
done)
$([ -n "$QUICK" ] || printf '%s\n' "${targets[@]}" | xargs -P "$(nproc)" -n 1 tests/bench/de03_rows.sh 2>"$work/de03.log" >"$work/de03" || cat "$work/de03.log" >&2
[ ! -s "$work/de03" ] || { cat <<'TEXT'

**Measured within a mean dE of 0.3, over Lafortune-Phong.** What a frame of the six models costs, culling to packing, when the scheduler may lose that much against the frame's own full quality, over
Lafortune-Phong at full quality: the smallest budget that keeps to it, found by bisection. Mean dE over the pixels that show a model, or over the whole picture; where the frame without a budget (no survey, nothing to decide) is
cheaper still, it counts.

TEXT
    awk -F, '{ sub(/measured_over_lafortune_de03/, "", $5); v[$2, $5] = $6; if (!seen[$2]++) t[++n] = $2 }
        END { print "target,cheapest,at a budget,at a budget; dE over the whole picture"; for (i = 1; i <= n; i++) print t[i] "," v[t[i], ""] "," v[t[i], "_scheduler"] "," v[t[i], "_scheduler_frame"] }' <(sort -r "$work/de03") | markdown_table
})

Numbers: [8_budgets.csv](8_budgets.csv).
MARKDOWN
