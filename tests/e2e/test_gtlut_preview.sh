#!/usr/bin/env bash
# gtlut preview: what is in the pictures, by their numbers.
. tests/e2e/gtlut_common.sh
SVG=${READ_IMAGE%/*}/svg_images.mjs

# A measurement of a diffuse material of albedo pi/4, and one of gold with few directions.
awk 'BEGIN { print "theta_in,theta_out,phi_out,R,G,B"
    for (i = 0; i <= 60; i += 20) for (j = 0; j <= 75; j += 5) for (k = 0; k < 360; k += 10) print i "," j "," k ",0.25,0.25,0.25" }' >diffuse.csv
"$G" measure gold -o all.csv || exit 1
awk -F, '!/^[0-9]/ || $2 % 5 == 0 && $3 % 10 == 0' all.csv >gold.csv
# Environment maps: radiance 1 all over, Radiance HDR in flat RGBE; and none.
{ printf '#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 7\n' && for _ in {1..28}; do printf '\200\200\200\201'; done; } >white.hdr

lobe() {
    "$G" preview diffuse.csv --what lobe --theta-in 40 -o lobe.svg && node "$SVG" lobe.svg check || return 1
    node "$SVG" lobe.svg images | grep -qx '0 900 560 4' || return 1
    # The upper outline is a half circle of 400 pixels around (450, 560 - 145): just inside covered, just outside not.
    node "$SVG" lobe.svg 0 $(awk 'BEGIN { for (a = 10; a <= 170; a += 10) for (r = 396; r <= 404; r += 8)
        printf "%d,%d ", 450 + r * cos(a / 57.29578), 415 - r * sin(a / 57.29578) }') >outline
    awk '{ want = NR % 2 ? 255 : 0; if ($4 != want) { print "point " NR ": alpha " $4; bad = 1 } } END { exit bad || NR != 34 }' outline || return 1
    node "$SVG" lobe.svg text | grep -q 'largest value 0.25' && node "$SVG" lobe.svg text | grep -q extrapolated
}
check "the lobe of a diffuse material is a hemisphere; what lies beyond the measured angles is said to be extrapolated" lobe

plots() {
    local f m
    "$G" preview diffuse.csv --what plots -o plots.svg && node "$SVG" plots.svg check || return 1
    node "$SVG" plots.svg text >text
    for f in 'θin = 75°' 'θout, degrees (below 0: the side of the light)' 'BRDF, luminance, 1/sr' 'Plane of incidence (dotted: not measured)' diffuse.csv; do
        grep -qF "$f" text || { echo "no text $f"; cat text; return 1; }
    done
    grep -q stroke-dasharray plots.svg || return 1
    # With theta_in 0 all angles up to 75 degrees are 1/4: one straight line in each plot.
    "$G" build gold.csv --kind half_vector --size 1K -o half.ktx2 2>/dev/null && "$G" preview half.ktx2 --what plots -o half.svg || return 1
    ! node "$SVG" half.svg text | grep 'not measured'
}
check "plots have axes with units; curves are dotted where a measurement ends, those of a half-vector table nowhere" plots

slices() {
    local k i
    "$G" build gold.csv -o paper.ktx2 --size 13x7 2>/dev/null && "$G" export paper.ktx2 -o paper.exr || return 1
    "$G" preview paper.ktx2 --what slices -o slices.svg && node "$SVG" slices.svg check || return 1
    [ "$(node "$SVG" slices.svg images)" = "$(for i in 0 1 2 3; do echo $i 13 7 3; done)" ] || return 1
    k=$(node "$SVG" slices.svg text | sed -nE 's/^paper.ktx2: sRGB of x.*, x = ([0-9.]+) · BRDF in 1.sr/\1/p')
    [ -n "$k" ] || { node "$SVG" slices.svg text; return 1; }
    # slice 3 stands at the lower right of the four in the EXR
    points=$(for y in 0 1 3 6; do for x in 0 2 6 11; do echo $x,$y; done; done)
    paste <(node "$SVG" slices.svg 3 $points) <(node "$READ_IMAGE" paper.exr $(for p in $points; do echo $((${p%,*} + 13)),$((${p#*,} + 7)); done)) |
        awk -v k="$k" '{ for (c = 1; c <= 3; c++) { x = k * $(c + 3); x = x / (1 + x)
            want = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ^ (1 / 2.4) - 0.055)
            if ($c - want > 0.7 || want - $c > 0.7) { print "texel " NR ": " $0 ", want " want; bad = 1 } } } END { exit bad || NR != 16 }'
}
check "slices of a table show its texels by the formula that the page states" slices

sample_slices() {
    "$G" preview gold.csv --what slices -o samples.svg && node "$SVG" samples.svg check || return 1
    node "$SVG" samples.svg images | grep -qx '3 36 16 3' || { node "$SVG" samples.svg images; return 1; }
    ! node "$SVG" samples.svg text | grep -E 'filled|extrapolated' || return 1
    awk -F, '$1 == 40 && $2 == 40 && ($3 < 30 || $3 > 330) { next } { print }' gold.csv >gap.csv
    "$G" check gap.csv --repair -o gap.gtm >/dev/null 2>&1
    "$G" preview gap.gtm --what slices -o gap.svg && node "$SVG" gap.svg text | grep -q 'filled in by interpolation' || return 1
    [ "$(node "$SVG" gap.svg 2 0,8 1,8)" = "$(printf '123 79 163\n123 79 163')" ] || [ "$(node "$SVG" gap.svg 2 1,8 2,8)" = "$(printf '123 79 163\n123 79 163')" ]
}
check "slices of a measurement show its samples, what was filled in hatched" sample_slices

image_slices() {
    "$G" preview paper.ktx2 --against paper.ktx2 --what image_slices -o same.svg && node "$SVG" same.svg check || return 1
    node "$SVG" same.svg text | grep -q 'RMS 0 %' || return 1
    [ "$(node "$SVG" same.svg 2 20,100 60,150)" = "$(printf '0 0 0\n0 0 0')" ] || return 1
    [ "$(node "$SVG" same.svg 0 20,100 60,150)" = "$(node "$SVG" same.svg 1 20,100 60,150)" ] || return 1
    "$G" preview diffuse.csv --what image_slices -o one.svg || return 1
    # All the same, shown as a quarter of the light; theta_d 80 is not measured.
    [ "$(node "$SVG" one.svg images)" = "0 180 180 3" ] || return 1
    node "$SVG" one.svg 0 40,120 50,150 80,130 8,100 | awk '{ if ($1 != $2 || $2 != $3 || $1 < 134 || $1 > 142) { print; bad = 1 } } END { exit bad || NR != 4 }' || return 1
    node "$SVG" one.svg 0 {20..27},20 | grep -cx '224 159 62' | grep -qx 2
}
check "image slices of the same differ by nothing; what was not measured is hatched" image_slices

sphere() {
    "$G" preview diffuse.csv --what sphere --envmap white.hdr --size 16 -o sphere.exr || return 1
    node "$READ_IMAGE" sphere.exr $(for i in {2..13}; do echo $i,7 7,$i; done) >values
    awk '{ for (c = 1; c <= 3; c++) if ($c < 0.775 || $c > 0.796) { print "value " $0; bad = 1 } } END { exit bad || NR != 24 }' values || return 1
    node "$READ_IMAGE" sphere.exr 0,0 15,15 | grep -vx '0 0 0' && return 1
    "$G" preview diffuse.csv --what sphere --envmap white.hdr --size 16 --threads 1 -o one.exr || return 1
    diff <(node "$READ_IMAGE" one.exr $(for i in {2..13}; do echo $i,7 7,$i; done)) values || return 1
    "$G" preview diffuse.csv --what sphere --size 24 -o sphere.svg && node "$SVG" sphere.svg check || return 1
    "$G" preview diffuse.csv --what sphere --size 24 --exposure 3 -o bright.svg || return 1
    node "$SVG" sphere.svg images | grep -qx '0 24 24 3' || return 1
    # lit from above at the left
    awk 'NR == 1 { a = $1 } NR == 2 { b = $1 } NR == 3 { c = $1 } END { exit !(a > b + 40 && c > a && a > 100) }' \
        <(node "$SVG" sphere.svg 0 9,8 14,20; node "$SVG" bright.svg 0 9,8)
}
check "a sphere in a white furnace shows its albedo, by one thread as by several; the built-in room lights from above" sphere

mesh() {
    printf 'v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n' >square.obj
    "$G" preview diffuse.csv --what sphere --mesh square.obj --turn 0 --envmap white.hdr --size 20 -o mesh.exr || return 1
    node "$READ_IMAGE" mesh.exr 10,10 | awk '{ exit !($1 > 0.775 && $1 < 0.796) }'
}
check "a mesh takes the sphere's place" mesh

sheet() {
    mkdir materials && cp diffuse.csv paper.ktx2 materials && cp half.ktx2 "materials/a'b.ktx2" && echo "no material" >materials/README.txt
    "$G" preview materials --size 12 -o sheet.svg && node "$SVG" sheet.svg check || return 1
    [ "$(node "$SVG" sheet.svg text | grep -E 'csv|ktx2' | sed 's/&#39;/'"'"'/')" = "$(printf "a'b.ktx2\ndiffuse.csv\npaper.ktx2")" ] || { node "$SVG" sheet.svg text; return 1; }
    node "$SVG" sheet.svg images | grep -qE '^0 [0-9]+ [0-9]+ 3$'
}
check "a folder becomes a contact sheet of the materials in it, each with its name" sheet

partial_sheet() {
    mkdir some && cp diffuse.csv some && head -c 900 paper.ktx2 >some/short.ktx2 && echo nothing >some/x.csv
    "$G" preview some --size 12 -o some.svg 2>err && node "$SVG" some.svg check || { cat err; return 1; }
    [ "$(node "$SVG" some.svg text | grep -E 'csv|ktx2')" = diffuse.csv ] || { node "$SVG" some.svg text; return 1; }
    grep -q 'some/short.ktx2: left out' err && grep -q 'some/x.csv: left out' err || { cat err; return 1; }
    # broad enough for the legend of what is extrapolated
    [ "$(node "$SVG" some.svg images | cut -d' ' -f2)" -ge 480 ] || return 1
    rm some/diffuse.csv
    "$G" preview some --size 12 -o none.svg 2>err
    [ $? = 4 ] && grep -q 'none of 2 materials can be read' err && [ ! -e none.svg ]
}
check "a bad file in a folder is left out of the sheet with a warning" partial_sheet

fits() {
    "$G" preview "$DATA/brdf/merl_sgd.csv" --size 8 -o fits.svg && node "$SVG" fits.svg check || return 1
    node "$SVG" fits.svg text >names
    cut -d, -f1 "$DATA/brdf/merl_sgd.csv" | tail -n +2 | diff - <(head -60 names)
}
if [ -r "$DATA/brdf/merl_sgd.csv" ]; then
    check "60 fits stand on one page" fits
else
    skip "60 fits stand on one page" "no data folder"
fi

folder() {
    quiet "$G" preview half.ktx2 --against gold.csv --size 16 -o pictures || return 1
    [ "$(ls pictures | tr '\n' ' ')" = "image_slices.svg lobe.png plots.svg slices.svg sphere.png " ] || { ls pictures; return 1; }
    for f in pictures/*.svg; do node "$SVG" "$f" check || return 1; done
    for f in pictures/*.png; do [ "$(head -c 4 "$f" | tail -c 3)" = PNG ] || return 1; done
    "$G" preview half.ktx2 --size 16 -o pictures # once more into the same folder
}
check "without --what a folder gets all pictures" folder

refusals() {
    head -c 900 paper.ktx2 >short.ktx2
    head -c 80 white.hdr >short.hdr
    head -c 300 sphere.exr >short.exr
    printf 'v 1 2 3\n' >empty.obj
    mkdir nothing
    refused 3 'missing.csv' preview missing.csv -o out.png --what lobe &&
        refused 4 'short.ktx2' preview short.ktx2 -o out.png --what lobe &&
        refused 4 'short.ktx2' preview half.ktx2 --against short.ktx2 -o out.png --what image_slices &&
        refused 4 'short.hdr' preview half.ktx2 --envmap short.hdr -o out.exr &&
        refused 4 'short.exr' preview half.ktx2 --envmap short.exr -o out.png --what sphere &&
        refused 3 'missing.exr' preview half.ktx2 --envmap missing.exr -o out.png --what sphere &&
        refused 4 'empty.obj' preview half.ktx2 --mesh empty.obj -o out.exr &&
        refused 4 'nothing: no file' preview nothing -o out.png &&
        refused 2 "'lobes' is none of" preview half.ktx2 -o out.png --what lobes &&
        refused 2 'is one file' preview half.ktx2 -o out.png --what lobe,plots &&
        refused 2 'is one file' preview half.ktx2 -o out.png &&
        refused 2 "'x.jpg' is neither a folder nor .svg" preview half.ktx2 -o x.jpg --what sphere &&
        refused 2 "'x.exr' is neither a folder nor .svg" preview half.ktx2 -o x.exr --what lobe &&
        refused 2 "'x.jpg' is neither a folder nor .svg" preview materials -o x.jpg &&
        refused 2 'of a folder or a table of fits' preview half.ktx2 -o out.png --what sheet &&
        refused 2 'only the sheet' preview materials -o out.png --what lobe &&
        refused 2 '--theta-in.* 89' preview half.ktx2 -o out.png --what lobe --theta-in 90 &&
        refused 3 'no/such' preview half.ktx2 -o no/such/x.svg --what lobe &&
        refused 2 'no output' preview half.ktx2 || return 1
    mkdir bin && ln -s "$(command -v head)" bin/head
    PATH=$PWD/bin "$G" preview half.ktx2 -o x.svg --what plots 2>err
    [ $? = 3 ] && grep -q 'install gnuplot' err && [ ! -e x.svg ] || { cat err; return 1; }
}
check "corrupt files, wrong options and a missing gnuplot end in their exit codes and leave nothing behind" refusals

echo "1..$n"
