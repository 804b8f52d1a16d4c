#!/usr/bin/env bash
# Puts pictures to be looked at side by side in $B/bench/contact_sheet.png: a row per material, of the demo and of the data folder where there
# is one; a table of 256 KB first, then, each followed by ten times its difference from that: tables of 64, 16 and 4 KB, the
# specular frame, and the models fitted to the material. Each picture: a sphere and a knot by three lights, one of them from behind.
# Environment: B (build folder), GONIOTILE_DATA, SHEET (materials of the demo; all six), CELL (240x120). Needs gtlut, gtscene and contact_sheet:
# make contact-sheet.
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
data=${GONIOTILE_DATA:-../shared/data}/brdf
work=$B/bench/contact
mkdir -p "$work"

scene() { # name material_json
    cat >"$work/$1.json" <<JSON
{
  "meshes": [
    {"name": "ball", "shape": "sphere", "segments": 48},
    {"name": "knot", "shape": "knot", "rings": 200, "sides": 20}
  ],
  "materials": [$2],
  "objects": [
    {"mesh": "ball", "material": "paint", "position": [-1.15, 0, 0], "scale": 1.1},
    {"mesh": "knot", "material": "paint", "position": [1.2, 0, 0], "rotation": [20, 30, 0], "scale": 1.05}
  ],
  "lights": [
    {"direction": [-0.5, 0.6, 0.8], "irradiance": [2.0, 1.9, 1.8]},
    {"direction": [1, 0.2, 0.1], "irradiance": [1.0, 1.1, 1.2]},
    {"direction": [0.3, 0.5, -0.8], "irradiance": [1.5, 1.5, 1.5]}
  ],
  "camera": {"eye": [0, 0, 6], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 22, "near": 1},
  "output": {"exposure": 1.0, "tone_curve": "none", "background": "#202020", "lod_error": 0}
}
JSON
    "$B/gtscene" build "$work/$1.json" -o "$work/$1.blob"
}
scene measured '{"name": "paint", "model": "measured", "slot": 0}'

row() { # name source
    local size model table pictures=()
    for size in 256K 64K 16K 4K; do
        table=$work/$1_$size.ktx2
        "$B/gtlut" build "$2" -o "$table" --kind half_vector --size $size 2>"$work/log" || { cat "$work/log" >&2; exit 1; }
        pictures+=("$work/measured.blob:$table")
    done
    if [[ $2 == *.csv ]]; then
        "$B/gtlut" build "$2" -o "$work/$1_frame.ktx2" --kind specular_frame 2>"$work/log" || { cat "$work/log" >&2; exit 1; }
        pictures+=("$work/measured.blob:$work/$1_frame.ktx2")
    else
        pictures+=("${pictures[0]}")
    fi
    for model in lafortune_phong blinn_phong ggx; do
        scene "$1_$model" "$("$B/gtlut" fit "$2" --model $model 2>>"$work/log" | head -1 | sed -E 's/"name": "[^"]*"/"name": "paint"/')"
        pictures+=("$work/$1_$model.blob")
    done
    [ ${#sheet[@]} = 0 ] || sheet+=(/)
    sheet+=("${pictures[@]}")
}
sheet=()
for material in ${SHEET-matte_white plastic_red gold plastic_blue_rough copper_satin satin_green}; do
    "$B/gtlut" measure "$material" -o "$work/$material.csv"
    row "$material" "$work/$material.csv"
done
for file in "$data"/*_rgb.bsdf; do
    [ ! -e "$file" ] || row "$(basename "${file%_rgb.bsdf}")" "$file"
done
"$B/bench/contact_sheet" "$B/bench/contact_sheet.png" "${CELL:-240x120}" "${sheet[@]}"
echo "written: $B/bench/contact_sheet.png"
