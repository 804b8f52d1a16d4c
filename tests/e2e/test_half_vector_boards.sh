#!/usr/bin/env bash
# Kernels in assembly for Cortex-M on the emulated boards. The half-vector table's, from the re-packed copy, give the bits that portable C
# gives from the texels, on every board, by 8, 4 and 1 taps; Lafortune-Phong's those of portable C on RV32.
set -u
B=${B:-build}
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT
targets="cortex-m3 cortex-m7 cortex-m33 rv32imac"

# A lobe sharp and bright enough to leave the kernels' range, and H beyond what the DSP loop takes.
cat >"$work/sharp.csv" <<'CSV'
theta_in,theta_out,phi_out,R,G,B
CSV
awk 'BEGIN {
    for (ti = 0; ti <= 60; ti += 20) for (to = 0; to <= 75; to += 5) for (p = 0; p < 360; p += 15) {
        d = (ti - to) ^ 2 + (p < 180 ? 180 - p : p - 180) ^ 2 * sin(to / 57.3) * sin(ti / 57.3)
        f = 0.1 + 3000 * exp(-d / 40)
        print ti "," to "," p "," f "," f / 3 "," 0.05 + f / 100
    }
}' >>"$work/sharp.csv"
n=0
echo 1..7
for size in 64x16x4 96x8x4; do
    problems=
    for copy in "" --packed; do
        "$B"/gtlut build "$work/sharp.csv" -o "$work/sharp$size$copy.ktx2" --kind half_vector --size $size $copy 2>"$work/log" ||
            problems+=$(cat "$work/log")
    done
    for taps in 8 4 1; do
        n=$((n + 1))
        hashes=
        for copy in "" --packed; do
            for target in $targets; do
                said=$(B=$B TAPS=$taps tests/board/shade.sh $target half_vector "$work/sharp$size$copy.ktx2" 2>&1)
                hash=$(grep -o 'hash [0-9a-f]*' <<<"$said")
                [ -n "$hash" ] || problems+="$target: $said"$'\n'
                hashes+="$hash $target $copy"$'\n'
            done
        done
        one=$(cut -d' ' -f2 <<<"${hashes%$'\n'}" | sort -u)
        [ "$(wc -l <<<"$one")" = 1 ] || problems+=$hashes
        [[ " ${seen-} " != *" $one "* ]] || problems+="the same bits as of other taps or nodes"$'\n'
        seen+=" $one"
        name=a_table_of_${size}_gives_the_same_bits_by_every_kernel_of_$taps
        if [ -z "$problems" ]; then
            echo "ok $n - $name"
        else
            echo "not ok $n - $name"
            sed 's/^/# /' <<<"$problems"
        fi
        problems=
    done
done

# A lobe without end; a broad one; a narrow one.
problems=
for exponent in 2 24 150; do
    hashes=
    for target in $targets; do
        said=$(B=$B EXPONENT=$exponent tests/board/shade.sh $target lafortune_phong 2>&1)
        line=$(grep -o 'lit [0-9]*\|hash [0-9a-f]*\|shaded [0-9]*' <<<"$said" | tr '\n' ' ')
        read -r _ lit _ hash _ shaded <<<"$line"
        [ -n "$line" ] && [ "$lit" = "$shaded" ] || problems+="$target, exponent $exponent: $said"$'\n'
        hashes+="$hash $target, exponent $exponent"$'\n'
    done
    [ "$(cut -d' ' -f1 <<<"${hashes%$'\n'}" | sort -u | wc -l)" = 1 ] || problems+=$hashes
done
if [ -z "$problems" ]; then
    echo "ok 7 - lafortune_phong_gives_the_same_bits_by_every_kernel"
else
    echo "not ok 7 - lafortune_phong_gives_the_same_bits_by_every_kernel"
    sed 's/^/# /' <<<"$problems"
fi
