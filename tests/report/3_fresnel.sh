#!/usr/bin/env bash
# James 2022, 3.2: a floor under one point light, seen from 0 to 80 degrees off its normal.
. tests/report/common.sh
size=400x300
views=(0 40 65 80)
[ -z "$QUICK" ] || { size=80x60; views=(0 80); }
gloss=0.3 exponent=60 roughness=0.4
slot=$work/floor.ktx2
if [ -n "$DATA" ]; then
    table "$DATA/brdf/merl_sgd.csv:natural-209" "$slot" --size 64K
    note='`natural-209` of the data folder (a fit to a wood of MERL)'
    color=(0.096 0.035 0.012)
else
    table "$B/demo/plastic_blue_rough.csv" "$slot" --size 64K
    note='`plastic_blue_rough` of the demo (there is no data folder)'
    color=(0.03 0.09 0.46)
fi
rgb="[${color[0]}, ${color[1]}, ${color[2]}]"
floor_mesh 6 >"$work/floor.obj"
models=(blinn_phong ggx measured)
declare -A material=(
    [blinn_phong]='"model": "blinn_phong", "kd": '$rgb', "ks": ['$gloss,$gloss,$gloss'], "exponent": '$exponent
    [ggx]='"model": "metallic_roughness", "base_color": '$rgb', "metalness": 0, "roughness": '$roughness
    [measured]='"model": "measured", "slot": 0'
)
for angle in "${views[@]}"; do
    for model in "${models[@]}"; do
        scene "$model" <<JSON
{"meshes": [{"name": "floor", "file": "floor.obj"}], "materials": [{"name": "wood", ${material[$model]}}],
 "objects": [{"mesh": "floor", "material": "wood"}],
 "lights": [{"type": "point", "position": [0, 1, 0], "power": 160, "radius": 20}],
 "camera": {"eye": [0, $(awk -v a="$angle" 'BEGIN { a /= 57.29578; print 7 * cos(a) ", " 7 * sin(a) }')], "target": [0, 0, 0],
            "up": [0, 1, -0.001], "fov_y": 45, "near": 0.1},
 "output": {"exposure": 1, "tone_curve": "aces", "background": "#20242a"}}
JSON
        quietly "$B/gtsim" render "$work/$model.blob" --table "0=$slot" --size $size --samples 4 -o "$OUT/3_${model}_$angle.png"
    done
done
csv=$OUT/3_fresnel.csv
"$B/report_fresnel" "$slot" "${color[@]}" $gloss $exponent $roughness >"$csv"
plot 3_fresnel 720x400 <<GNUPLOT
set xlabel 'viewing angle from the normal, degrees'
set ylabel 'specular share of the reflected light, %'
set xrange [0:85]; set yrange [0:100]
plot '$csv' skip 1 using 1:(100*\$2) with lines lw 2 lc rgb '#c0392b' title 'Blinn-Phong', \
     '' skip 1 using 1:(100*\$3) with lines lw 2 lc rgb '#2471a3' title 'GGX', \
     '' skip 1 using 1:(100*\$4) with lines lw 2 lc rgb '#1e8449' title 'measured'
GNUPLOT
cat <<MARKDOWN

## 3. Fresnel effect

A floor, a point light one unit above it, the eye seven units away at 0, 40, 65 and 80 degrees from the normal (James 2022, section 3.2). The
measured material is $note. Blinn-Phong (ks $gloss, exponent $exponent) and GGX (roughness $roughness) have its diffuse colour, $rgb.

| view | Blinn-Phong | GGX | measured |
|---|---|---|---|
$(for angle in "${views[@]}"; do echo "| $angle° |$(for model in "${models[@]}"; do cell "3_${model}_$angle.png" 300; done)"; done)

The specular share is what the floor within six units of the lamp's foot sends to the eye beyond what a Lambertian floor of the same colour would
(double precision, without ambient light):

$(awk -F, -v OFS=, -v views="${views[*]}" 'BEGIN { split(views, v, " "); for (i in v) want[v[i]] = 1 }
    NR == 1 { print "view,Blinn-Phong,GGX,measured" } $1 in want { printf "%d°,%.1f %%,%.1f %%,%.1f %%\n", $1, 100 * $2, 100 * $3, 100 * $4 }' "$csv" | markdown_table)

![specular share by viewing angle](3_fresnel.svg)

In the paper, figure 3.2, Blinn-Phong's floor "has a constant specular response over all viewing angles", while the physically based one "appears
mostly diffuse" from above, does not change between 0° and 40°, and becomes more specular at 65° and especially at 80°.

Numbers: [3_fresnel.csv](3_fresnel.csv).
MARKDOWN
