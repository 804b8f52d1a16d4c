#!/usr/bin/env bash
# Counts the instructions that shading takes on an emulated board (tests/board/shade/main.c explains the figures), building what has
# changed first. In seconds; the same sphere and lights for every material.
#   tests/board/shade.sh TARGET half_vector|specular_frame TABLE.ktx2
#   tests/board/shade.sh TARGET lafortune_phong|blinn_phong|metallic_roughness
# TARGET input: only makes the input and prints its name. Environment: B (build folder); EXPONENT: of the Phong models, 24;
# TAPS=8|4|1: texels of a half-vector table that a pixel and light are evaluated by, 8;
# PROFILE=1: instructions by function, too, of the whole program.
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
target=$1 model=$2 table=${3-}
phong='"kd": [0.10, 0.06, 0.015], "ks": [0.85, 0.64, 0.28], "exponent": '${EXPONENT:-24}
case $model in
half_vector | specular_frame) material='"model": "measured", "slot": 0' ;;
lafortune_phong | blinn_phong) material="\"model\": \"$model\", $phong" ;;
metallic_roughness) material="\"model\": \"$model\", \"base_color\": [1.0, 0.77, 0.34], \"metalness\": 0.5, \"roughness\": 0.3" ;;
*) echo "shade.sh: no model $model" >&2; exit 2 ;;
esac
case ${TAPS:-8} in
8) taps=0 ;;
4) taps=1 ;;
1) taps=2 ;;
*) echo "shade.sh: no evaluation by $TAPS texels" >&2; exit 2 ;;
esac
input=$B/board/shade_$model$(basename "${table%.ktx2}" | sed 's/^./_&/')${TAPS:+_$TAPS}.bin
programs=("$B/gtscene")
options=()
[ "$target" = input ] || programs+=("$B/board/$target/shade.elf")
[ -z "${PROFILE-}" ] || programs+=("$B/board/profile.so") options+=(-plugin "$B/board/profile.so")
env -u MAKEFLAGS make -s "B=$B" "${programs[@]}" >&2
mkdir -p "$B/board"
cat >"$input.json" <<JSON
{
  "meshes": [{"name": "ball", "shape": "sphere", "segments": 4}],
  "materials": [{"name": "paint", $material}],
  "objects": [{"mesh": "ball", "material": "paint"}],
  "lights": [
    {"direction": [1, 1, 1], "irradiance": [2.0, 1.9, 1.7]},
    {"direction": [-2, 1, 1], "irradiance": [0.7, 0.9, 1.6]},
    {"direction": [0, -1, 1], "irradiance": [1.0, 0.6, 0.4]}
  ],
  "camera": {"eye": [0, 0, 3], "target": [0, 0, 0], "up": [0, 1, 0], "fov_y": 45, "near": 1},
  "output": {"exposure": 1.0, "tone_curve": "none", "background": "#000000"}
}
JSON
"$B/gtscene" build "$input.json" -o "$input.blob" 2>"$input.log" || { cat "$input.log" >&2; exit 1; }
bytes=$([ -z "$table" ] && echo 0 || stat -Lc %s "$table")
printf "$(printf '\\x%02x\\x%02x\\x%02x\\x%02x\\x%02x' $((bytes & 255)) $((bytes >> 8 & 255)) $((bytes >> 16 & 255)) $((bytes >> 24)) $taps)" >"$input.new"
truncate -s 16 "$input.new"
cat "$input.blob" >>"$input.new"
truncate -s %16 "$input.new"
[ -z "$table" ] || cat "$table" >>"$input.new"
mv "$input.new" "$input"
rm "$input.json" "$input.blob" "$input.log"
[ "$target" != input ] || { echo "$input"; exit; }
tests/board/run.sh "$target" "$B/board/$target/shade.elf" "$input" "${options[@]}"
