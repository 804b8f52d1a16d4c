#!/usr/bin/env bash
# make report: three cheap chapters with tiny pictures and without the data folder.
. tests/tap.sh
B=$(cd "${B:-build}" && pwd) || exit 1
SVG=$PWD/tests/e2e/svg_images.mjs
# A build folder of its own: the report of who runs this stays.
mkdir "$work/b"
for name in gtlut gtscene gtsim goniotile_oiio.so demo report_pixels report_fresnel report_lobes report_rates; do
    ln -s "$B/$name" "$work/b/$name"
done
R=$work/b/report
report() {
    B=$work/b QUICK=1 GONIOTILE_DATA=$work tests/report/report.sh 2 4 8 && node "$SVG" "$R/2_interpolation.svg" check &&
        node "$SVG" "$R/2_extrapolation.svg" check && node "$SVG" "$R/4_lights.svg" check && node "$SVG" "$R/8_x86-64.svg" check
}
check "the chapters are written without the data folder, their plots are well-formed" report

unbuilt() {
    B=$work/none tests/report/report.sh 4 2>"$work/err"
    [ $? = 1 ] && grep -q 'make report builds what chapters call' "$work/err" && [ ! -e "$work/none" ]
}
check "without what chapters call nothing is begun" unbuilt

named() {
    local file bad=0
    grep -oE '\]\([^)]*\)|src="[^"]*"' "$R/REPORT.md" | sed -E 's/^\]\(|\)$|src="|"$//g' >"$work/names"
    [ "$(wc -l <"$work/names")" -ge 12 ] || { cat "$work/names"; return 1; }
    while read -r file; do [ -s "$R/$file" ] || { echo "no $file"; bad=1; }; done <"$work/names"
    grep -q '^## 2\.' "$R/REPORT.md" && grep -q '^## 4\.' "$R/REPORT.md" && ! grep -q '^## 3\.' "$R/REPORT.md" && return $bad
}
check "REPORT.md has the chapters that were made, and every picture, plot and file that it names is there" named

# The lobe between slices: at most 2 % off in the specular frame, 23.8 % (half of 20 degrees) with the outgoing direction held.
lobe() { awk -F, 'NR == 2 { print; exit !($1 == 30 && $2 < 0.02 && $3 > 0.2 && $3 < 0.28) }' "$R/2_errors.csv"; }
check "a lobe between slices stays itself in the specular frame, and not with the outgoing direction held" lobe

fade() { # of p = 1 nothing, of p = 0 all is gone at the horizon; p = 0.2 keeps a fifth
    awk -F, '$1 == 75 { edge = $2 } END { print edge, $0; exit !(edge > 0 && $1 == 89.5 && $2 / edge > 0.999 && $4 / edge > 0.19 && $4 / edge < 0.23 && $5 / edge < 0.03) }' "$R/2_extrapolation.csv"
}
check "values beyond the measured angles fade to the share that was asked for" fade

white() { # lights,blinn_phong,ggx,measured,measured_ldr: of 14400 pixels
    cat "$R/4_lights.csv"
    awk -F, '$1 == 1 && $2 == 0 { one = 1 } $1 == 10 { ten = $2 > 1400 && $2 < 5000 && $3 == 0 && $4 == 0 } END { exit !(one && ten) }' "$R/4_lights.csv"
}
check "ten lights make a fifth of the picture white with Blinn-Phong's clamp, none of it with ACES" white

ladder() { # each rate errs more than the one before, fewer taps more than all; at 1x1 the larger table less than the smaller, and by fewer than half a dE
    awk -F, '{ print } $2 ~ /half_vector/ { de[$2, $4] = $7; n++ }
        END { k = split("1x1 2x1 2x2 4x2 4x4 flat", r, " "); bad = n != 32 || de["half_vector_64K", "1x1"] >= de["half_vector_1K", "1x1"] || de["half_vector_1K", "1x1"] > 0.5
            for (i = 2; i <= k; i++) bad += de["half_vector_64K", r[i]] <= de["half_vector_64K", r[i - 1]]
            k = split("1x1 1x1/4 1x1/1 2x1/1", r, " "); for (i = 2; i <= k; i++) bad += de["half_vector_64K", r[i]] <= de["half_vector_64K", r[i - 1]]; exit bad }' "$R/8_budgets.csv"
}
check "coarser rates of shading and fewer taps err more, in their order, smaller tables at full rate, too" ladder

echo "1..$n"
