#!/usr/bin/env bash
# Builds the benchmark's scenes into $B/bench: knots_<triangles>.blob, knots_1m_mesh.blob, overdraw_<layers>.blob.
#   knots     equal knots of 8,000 triangles (2k: one of 2,000), each turned its own way, Lafortune-Phong under two lights: 32k
#             are four that fill the picture, 128k and 1m the same with 12 and 121 more behind them in the distance
#   1m_grid   125 of the same knots side by side, which fill the picture
#   1m_mesh   one knot of 1,000,000 triangles
#   overdraw  layers of spheres, each layer covering the picture, the farthest first
# Environment: B (build folder).
set -eu
cd "$(dirname "$0")/../.."
B=${B:-build}
mkdir -p "$B/bench"

scene() { # name camera_eye_z mesh objects
    cat >"$B/bench/$1.json" <<JSON
{
  "meshes": [$3],
  "materials": [
    {"name": "red", "model": "lafortune_phong", "kd": [0.52, 0.05, 0.04], "ks": [0.10, 0.10, 0.10], "exponent": 40},
    {"name": "blue", "model": "lafortune_phong", "kd": [0.05, 0.14, 0.55], "ks": [0.10, 0.10, 0.10], "exponent": 40},
    {"name": "sand", "model": "lafortune_phong", "kd": [0.60, 0.48, 0.30], "ks": [0.05, 0.05, 0.05], "exponent": 20}
  ],
  "objects": [
$4
  ],
  "lights": [
    {"direction": [-0.5, 0.8, 0.6], "irradiance": [3.0, 2.8, 2.6]},
    {"direction": [0.9, 0.1, 0.5], "irradiance": [0.8, 0.9, 1.0]}
  ],
  "camera": {"eye": [0, 0, $2], "target": [0, 0, 0], "fov_y": 30, "near": 0.5},
  "output": {"tone_curve": "none", "background": "#15171a"}
}
JSON
    "$B/gtscene" build "$B/bench/$1.json" -o "$B/bench/$1.blob"
}

# Knots as lines of objects; the last line is the camera's distance. volume: four side by side fill the picture, those beyond
# them are spread evenly over the volume that the eye sees from 3 to 32 times their distance, the nearest first. grid: all side by
# side, columns to rows as 4 to 3.
place() { # volume|grid count
    awk -v how="$1" -v n="$2" 'BEGIN {
        split("red blue sand", material, " ")
        tangent = 0.26795 # of 15 degrees
        front = how == "grid" || n < 4 ? n : 4
        columns = int(sqrt(front * 4 / 3) + 0.5)
        rows = int((front + columns - 1) / columns)
        high = 2.3 * rows > 2.3 * columns * 3 / 4 ? 2.3 * rows : 2.3 * columns * 3 / 4
        eye = 1 + high / 2 / tangent
        for (i = 0; i < n; i++) {
            if (i < front) {
                x = 2.3 * (i % columns - (columns - 1) / 2)
                y = 2.3 * ((rows - 1) / 2 - int(i / columns))
                z = 0
            } else { # 121 of them are the whole volume
                depth = eye * (27 + (32 ^ 3 - 27) * (i - 3.5) / 121) ^ (1 / 3)
                x = (i * 0.754877666 % 1 - 0.5) * 2 * depth * tangent * 4 / 3
                y = (i * 0.569840291 % 1 - 0.5) * 2 * depth * tangent
                z = eye - depth
            }
            printf "    {\"mesh\": \"knot\", \"material\": \"%s\", \"position\": [%g, %g, %g], \"rotation\": [%d, %d, %d]}%s\n",
                material[i % 3 + 1], x, y, z, i * 37 % 360, i * 71 % 360, i * 113 % 360, i + 1 < n ? "," : ""
        }
        printf "%g\n", eye
    }'
}

knots() { # name rings sides volume|grid count
    local objects eye
    objects=$(place "$4" "$5")
    eye=$(tail -1 <<<"$objects")
    scene "knots_$1" "$eye" "{\"name\": \"knot\", \"shape\": \"knot\", \"rings\": $2, \"sides\": $3}" "$(head -n -1 <<<"$objects")"
}
knots 2k 100 10 volume 1
knots 8k 200 20 volume 1
knots 32k 200 20 volume 4
knots 128k 200 20 volume 16
knots 1m 200 20 volume 125
knots 1m_grid 200 20 grid 125
knots 1m_mesh 1250 400 volume 1

# Layers of four by three spheres that cover the picture, one behind the other, the farthest drawn first.
overdraw() { # layers
    local spheres
    spheres=$(awk -v n="$1" 'BEGIN {
        split("red blue sand", material, " ")
        for (k = n - 1; k >= 0; k--)
            for (i = 0; i < 12; i++) {
                grow = 1 + 0.25 * k # farther ones are larger: each layer looks the same
                printf "    {\"mesh\": \"ball\", \"material\": \"%s\", \"position\": [%g, %g, %g], \"scale\": %g}%s\n",
                    material[(i + k) % 3 + 1], 2 * grow * (i % 4 - 1.5), 2 * grow * (int(i / 4) - 1), 12 - 12 * grow, 1.42 * grow,
                    k || i < 11 ? "," : ""
            }
    }')
    scene "overdraw_$1" 12 '{"name": "ball", "shape": "sphere", "segments": 12}' "$spheres"
}
overdraw 1
overdraw 4
overdraw 16
