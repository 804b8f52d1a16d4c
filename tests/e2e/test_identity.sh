#!/usr/bin/env bash
# One picture, bit by bit, whoever compiles the renderer, however large its tiles are, in whatever order and on however many threads
# they are rendered. tests/board/host_hash.c is compiled by each compiler (`make boards-build`); test_boards.sh runs it and the emulated
# boards on the demo's scene.
. tests/e2e/usb_common.sh

# Everything that clips: the eye inside a sphere that cuts the near plane and the guard band, a gear as thin as a needle, a wall
# through the eye, balls from below a pixel to far beyond the picture, far and near ones in a row.
cat >"$work/hard.json" <<'JSON'
{
  "meshes": [
    {"name": "ball", "shape": "sphere", "segments": 12},
    {"name": "cube", "shape": "rounded_cube", "segments": 6},
    {"name": "knot", "shape": "knot", "rings": 120, "sides": 12},
    {"name": "gear", "shape": "gear"}
  ],
  "materials": [
    {"name": "clay", "model": "lafortune_phong", "kd": [0.5, 0.4, 0.3], "ks": [0.2, 0.2, 0.2], "exponent": 300},
    {"name": "chalk", "model": "lafortune_phong", "kd": [0.7, 0.8, 0.9]},
    {"name": "gold", "model": "measured", "slot": 2}
  ],
  "objects": [
    {"mesh": "knot", "material": "gold", "position": [0.2, 0.1, 0.4], "rotation": [10, 20, 30], "scale": 0.5},
    {"mesh": "cube", "material": "chalk", "position": [0, -1000, 0], "rotation": [0, 3, 0], "scale": 999.8},
    {"mesh": "gear", "material": "clay", "position": [0.31, 0.02, 0.2], "rotation": [89.9, 0, 5], "scale": 0.4},
    {"mesh": "ball", "material": "gold", "position": [0.01, 0, 1], "rotation": [7, 8, 9], "scale": 1.02},
    {"mesh": "ball", "material": "chalk", "position": [40, 30, -400], "scale": 0.2},
    {"mesh": "ball", "material": "clay", "position": [-3000, 200, -9000], "scale": 4000},
    {"mesh": "knot", "material": "clay", "position": [30, 10, -100], "rotation": [40, 50, 0], "scale": 30},
    {"mesh": "knot", "material": "gold", "position": [-0.04, 0, -0.1], "rotation": [40, 50, 0], "scale": 0.05}
  ],
  "lights": [
    {"direction": [-0.55, 0.75, 0.70], "intensity": 3.0},
    {"direction": [0.85, 0.10, -0.60], "intensity": 0.9}
  ],
  "camera": {"eye": [0, 0, 0], "target": [0.3, 0.02, -1], "up": [0, 1, 0], "fov_y": 75, "near": 0.002},
  "output": {"exposure": 1.0, "tone_curve": "aces", "background": "#401030"}
}
JSON
gtscene build "$work/hard.json" -o "$work/hard.blob" || exit 1
tables=() slots=() s=0
for m in matte_white plastic_red gold plastic_blue_rough copper_satin satin_green; do
    tables+=("$DEMO/$m.ktx2")
    slots+=(--table $s="$DEMO/$m.ktx2")
    s=$((s + 1))
done

# What gtsim prints as the frame's hash.
pool_hash() { # scene size format model option...
    local scene=$1 size=$2 format=$3 model=$4
    shift 4
    gtsim render "$scene" "${slots[@]}" --size "$size" --format "$format" --model "$model" --stats -o "$work/x.png" "$@" |
        sed -n 's/^frame hash \([0-9a-f]*\),.*/\1/p'
}

same() { # who hash expected
    [ -n "$2" ] && [ "$2" = "$3" ] || echo "$1: hash ${2:-missing}, not $3"
}

identity() { # name scene size format model option...
    local name=$1 scene=$2 size=$3 format=$4 model=$5 expected program hash problems= threads
    shift 5
    expected=$(pool_hash "$scene" "$size" "$format" "$model" "$@")
    if [ "$model" = scene ] && [ $# = 0 ]; then # the hash programs take a scene as it is
        for program in "$B"/board/host_hash-*; do
            hash=$("$program" ${size%x*} ${size#*x} "$format" "$scene" "${tables[@]}") || hash=
            problems+=$(same "${program##*/}" "${hash##* }" "$expected")
        done
        claim "${name}_is_equal_over_compilers_levels_sanitizers_and_tile_sizes" "$problems"
    fi
    problems=
    for threads in 1 2 4; do
        problems+=$(same "$threads threads" "$(pool_hash "$scene" "$size" "$format" "$model" --threads $threads "$@")" "$expected")
        hash=$(pool_hash "$scene" "$size" "$format" "$model" --threads $threads --shuffle $threads "$@")
        problems+=$(same "$threads threads, order $threads" "$hash" "$expected")
    done
    claim "${name}_is_equal_on_1_2_and_4_threads_in_any_order_of_tiles" "$problems"
}

identity hard_cases "$work/hard.blob" 333x222 rgb888 scene
identity hard_cases_rgb565 "$work/hard.blob" 127x65 rgb565 scene
identity hard_cases_4_samples "$work/hard.blob" 127x65 rgb888 scene --samples 4
identity six_models_measured "$DEMO/six_models.blob" 320x240 rgb888 measured
identity six_models_lafortune_phong "$DEMO/six_models.blob" 320x240 rgb888 lafortune_phong
if [ -e "$B/board/work_a.blob" ]; then
    identity work_a "$B/board/work_a.blob" 320x240 rgb565 scene
else
    skip work_a_is_equal_over_compilers_levels_sanitizers_and_tile_sizes "no data folder"
    skip work_a_is_equal_on_1_2_and_4_threads_in_any_order_of_tiles "no data folder"
fi

echo 1..$n
