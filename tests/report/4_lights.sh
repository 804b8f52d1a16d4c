#!/usr/bin/env bash
# James 2022, 3.3: one to ten equal point lights in one place before a wall; pixels that are white.
. tests/report/common.sh
size=1280x720
counts=(1 2 3 4 5 6 7 8 9 10)
[ -z "$QUICK" ] || { size=160x90; counts=(1 10); }
# Light pine: close to what the paper's texture of planks shows.
color='[0.62, 0.50, 0.37]'
slot=$work/wood.ktx2
if [ -n "$DATA" ]; then
    source=$DATA/brdf/merl_sgd.csv:pickled-oak-260
    note="\`${source##*:}\` of the data folder (a fit to a material of MERL)"
else
    source=$B/demo/matte_white.csv
    note='`matte_white` of the demo (there is no data folder)'
fi
table "$source" "$slot" --size 16K

floor_mesh 6 >"$work/floor.obj"
wall() { # name material lights power tone
    local lights
    lights=$(awk -v n="$3" -v p="$4" 'BEGIN { for (i = 0; i < n; i++)
        printf "%s{\"type\": \"point\", \"position\": [0, 1.2, 0], \"power\": %g, \"radius\": 10}", i ? ", " : "", p }')
    scene "$1" <<JSON
{"meshes": [{"name": "wall", "file": "floor.obj"}], "materials": [$2],
 "objects": [{"mesh": "wall", "material": "wood"}], "lights": [$lights],
 "camera": {"eye": [0, 5, 0], "target": [0, 0, 0], "up": [0, 0, -1], "fov_y": 45, "near": 0.5},
 "output": {"exposure": 1, "tone_curve": "$5"}}
JSON
    quietly "$B/gtsim" render "$work/$1.blob" --table "0=$slot" --size $size -o "$work/$1.png"
}
models=(blinn_phong ggx measured measured_ldr)
declare -A material=(
    [blinn_phong]='{"name": "wood", "model": "blinn_phong", "kd": '$color', "ks": [0.3, 0.3, 0.3], "exponent": 24}'
    [ggx]='{"name": "wood", "model": "metallic_roughness", "base_color": '$color', "metalness": 0, "roughness": 0.5}'
    [measured]='{"name": "wood", "model": "measured", "slot": 0}'
    [measured_ldr]='{"name": "wood", "model": "measured", "slot": 0}'
)
declare -A tone=([blinn_phong]=none [ggx]=aces [measured]=aces [measured_ldr]=none)
csv=$OUT/4_lights.csv
echo 'lights,blinn_phong,ggx,measured,measured_ldr' >"$csv"
for n in "${counts[@]}"; do
    pictures=()
    for model in "${models[@]}"; do
        wall "${model}_$n" "${material[$model]}" "$n" 50 "${tone[$model]}" &
        pictures+=("$work/${model}_$n.png")
    done
    wait
    "$B/report_pixels" "${pictures[@]}" >"$work/white"
    echo "$n,$(awk '{ print $5 }' "$work/white" | paste -sd,)" >>"$csv"
done
for n in 1 2 5 10; do
    for model in "${models[@]}"; do
        [ ! -e "$work/${model}_$n.png" ] || cp "$work/${model}_$n.png" "$OUT/4_${model}_$n.png"
    done
done
printf '%s\n' '1,0,0' '2,21028,0' '3,83647,0' '4,160152,0' '5,214592,0' '6,249421,0' '7,272263,0' '8,288192,0' '9,301453,0' '10,313752,0' >"$work/james"
plot 4_lights 720x400 <<GNUPLOT
set xlabel 'point lights in one place'
set ylabel 'white pixels, % of the picture'
set xrange [0.5:10.5]; set yrange [-1:*]; set xtics 1
total = $(awk -F'[x]' '{ print $1 * $2 }' <<<$size) / 100.0
plot '$csv' skip 1 using 1:(\$2/total) with linespoints lw 2 pt 7 lc rgb '#c0392b' title 'Blinn-Phong, LDR', \
     '' skip 1 using 1:(\$5/total) with linespoints lw 2 pt 5 lc rgb '#d68910' title 'measured, LDR', \
     '' skip 1 using 1:(\$3/total) with linespoints lw 2 pt 9 lc rgb '#2471a3' title 'GGX, HDR and ACES', \
     '' skip 1 using 1:(\$4/total) with linespoints lw 2 pt 2 lc rgb '#1e8449' title 'measured, HDR and ACES', \
     '$work/james' using 1:(\$2/9216.0) with linespoints dt 2 pt 6 lc rgb '#888888' title 'Blinn-Phong, James 2022'
GNUPLOT
cat <<MARKDOWN

## 4. Multiple lights

One to ten equal point lights stand in one place before a wall; counted are the pixels of $size that are white, all three channels at 255
(James 2022, section 3.3). Blinn-Phong clamps what it adds up (LDR); GGX and the measured material keep it (HDR) and go through the ACES curve.
The measured material is $note; "LDR" shows it without the curve: what saturates is the missing curve, not the model.
Our wall has one colour and no texture, and the lamp's place is our guess: the paper's scene is not described further.

$(sed '1s/.*/lights,Blinn-Phong LDR,GGX + ACES,measured + ACES,measured LDR,Blinn-Phong (James 2022),physically based (James 2022)/' "$csv" | awk -F, -v OFS=, -v from="$work/james" '
    BEGIN { while ((getline line < from) > 0) { split(line, f, ","); paper[f[1]] = f[2] "," f[3] } } NR == 1 { print; next } { print $0, paper[$1] }' | markdown_table)

![white pixels against the number of lights](4_lights.svg)

| lights | Blinn-Phong, LDR | GGX, ACES | measured, ACES | measured, LDR |
|---|---|---|---|---|
$(for n in 1 2 5 10; do [ ! -e "$OUT/4_ggx_$n.png" ] || echo "| $n |$(for model in "${models[@]}"; do cell "4_${model}_$n.png" 240; done)"; done)

Numbers: [4_lights.csv](4_lights.csv).
MARKDOWN
