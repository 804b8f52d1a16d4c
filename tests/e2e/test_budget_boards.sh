#!/usr/bin/env bash
# Budgets on the emulated boards, by their own clocks, which count instructions exactly: 10^5 tiles of random scenes and of hard ones at random
# budgets (tests/board/budget/main.c), and some of the random ones with broad lobes and with tables that are read from their texels, without a re-packed copy or too
# tall for the fastest loop, and at an exposure beyond what that loop takes. Arguments: targets. GONIOTILE_ROWS: a file to which figures are added as rows of results.csv.
set -u
B=${B:-build}
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT
targets=${*:-cortex-m3 cortex-m4 cortex-m7}
tables=("$B/demo/plastic_red.ktx2" "$B/demo/gold.ktx2" "$B/board/gold_91x46.ktx2")
six=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green)
six=("${six[@]/#/$B/demo/}")
six=("${six[@]/%/.ktx2}")
texels=("$work/plain.ktx2" "$work/tall.ktx2" "$B/board/gold_91x46.ktx2")
"$B"/gtlut build "$B/demo/plastic_red.csv" -o "${texels[0]}" --kind half_vector --size 64K 2>/dev/null
"$B"/gtlut build "$B/demo/gold.csv" -o "${texels[1]}" --kind half_vector --size 96x16x4 --packed 2>/dev/null
n=0
[ -x "$B/board/make_input" ] || { echo "1..1"; echo "ok 1 # SKIP no scheduler to be run"; exit; }
echo "1..$(wc -w <<<"$targets")"
row() { [ -z "${GONIOTILE_ROWS-}" ] || echo "budget,$1,$2,total,$3,$4,$5" >>"$GONIOTILE_ROWS"; }
# Thousandths and the like as a decimal number.
part() { awk -v x="$1" -v of="$2" 'BEGIN { printf "%.6g", x / of }'; }
claim() { # name problems
    n=$((n + 1))
    if [ -z "$2" ]; then
        echo "ok $n - $1"
    else
        echo "not ok $n - $1"
        sed 's/^/# /' <<<"$2"
    fi
}
run() { # target kind scenes frames
    local kind=$2 these=("${tables[@]}")
    [ "$kind" != texels ] || kind=broad these=("${texels[@]}")
    "$B/board/make_input" "$1" "$work/in" tiles "$kind" 1 "$3" "$4" "${these[@]}" &&
        LIMIT=250 tests/board/run.sh "$1" "$B/board/$1/budget.elf" "$work/in"
}
for target in $targets; do
    over=0 late=0 differ=0 tiles=0 problems=''
    for what in "random 64 13" texels\ 16\ 8 bright\ 24\ 8 one_tile\ 1\ 8 slivers\ 1\ 8 lights\ 1\ 8 interleaved\ 1\ 8 inside\ 1\ 8; do
        read -r kind scenes frames <<<"$what"
        said=$(run "$target" "$kind" "$scenes" "$frames" 2>&1)
        echo "# $target $kind: $(tr -s '\n ' ' ' <<<"$said")"
        if ! read -r _ t _ o _ _ _ _ _ c _ l _ d _ _ _ _ p99 _ most _ _ median _ own <<<"$(tr -s '\n ' ' ' <<<"$said")" || [ -z "${own-}" ]; then
            problems+="$kind: $said"$'\n'
            continue
        fi
        tiles=$((tiles + t)) over=$((over + o)) late=$((late + l)) differ=$((differ + d))
        [ "$o$l$d" = 000 ] || problems+="$kind: $o of $t tiles over, $l frames, $d differ"$'\n'
        [ "$kind" != random ] || [ "$p99" -le 1100 ] || problems+="$kind: spent over predicted $p99 thousandths at 99 %"$'\n'
        [ "$kind" != random ] || [ "$own" -le 20000 ] || problems+="$kind: deciding takes $own millionths of budgets"$'\n'
        [ "$most" -le 1250 ] || problems+="$kind: spent over predicted up to $most thousandths"$'\n'
        case=$kind
        [ $kind != random ] || case=all
        row "$target" $case budget_used_median "$(part "$median" 1000)" 1
        row "$target" $case scheduler_share "$(part "$own" 1000000)" 1
        row "$target" $case prediction_p99 "$(part "$p99" 1000)" 1
        row "$target" $case prediction_max "$(part "$most" 1000)" 1
        row "$target" $case tiles_at_coarsest_levels "$c" tiles
    done
    row "$target" all tiles_over_budget $over tiles
    row "$target" all tiles $tiles tiles
    claim "no_tile_of_${tiles}_takes_more_than_its_share_or_a_quarter_more_than_predicted_and_generous_budgets_change_no_bit_on_$target" "$problems"
    [ -n "${GONIOTILE_ROWS-}" ] || continue
    # The still picture of six models, when half or a quarter of what its shading takes at full quality is left for it.
    "$B/board/make_input" "$target" "$work/in" picture 0 "$B/demo/six_models.blob" "${six[@]}"
    LIMIT=250 tests/board/run.sh "$target" "$B/board/$target/budget.elf" "$work/in" >"$work/six"
    sed "s/^/# $target six models: /" "$work/six"
    for share in half quarter; do
        row "$target" all psnr_at_$share "$(awk -v s=$share '$1 == s { printf "%.2f", 10 * log(255 * 255 * 230400 / $NF) / log(10) }' "$work/six")" dB
    done
done
