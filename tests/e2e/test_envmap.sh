#!/usr/bin/env bash
# From an environment map to a picture on the simulated device: gtscene build --envmap, what it accepts and refuses.
. tests/e2e/gtscene_common.sh

# Radiance files of 64 x 32 pixels, without compression.
cat >"$work/map.mjs" <<'JS'
import { writeFileSync } from 'node:fs';
const [file, kind] = process.argv.slice(2), w = 64, h = 32, pixels = Buffer.alloc(4 * w * h);
const put = (x, y, mantissas, exponent) => pixels.set([...mantissas, exponent], 4 * (y * w + x)); // m / 256 * 2^(exponent - 128)
for (let y = 0; y < h; y++)
    for (let x = 0; x < w; x++) {
        if (kind === 'constant') put(x, y, [128, 128, 128], 128); // 0.5
        if (kind === 'front' && Math.abs(x - 31.5) < 1 && Math.abs(y - 15.5) < 1) put(x, y, [255, 128, 64], 132);
        if (kind === 'sun' && x === 10 && y === 9) put(x, y, [255, 255, 255], 148);
    }
writeFileSync(file, Buffer.concat([Buffer.from(`#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${h} +X ${w}\n`), pixels]));
JS
for kind in constant front sun black; do node "$work/map.mjs" "$work/$kind.hdr" $kind; done
cat >"$work/sphere.json" <<'JSON'
{
  "meshes": [{"name": "sphere", "shape": "sphere", "segments": 12}],
  "materials": [{"name": "white", "model": "lafortune_phong", "kd": [1, 1, 1]}],
  "objects": [{"mesh": "sphere", "material": "white"}],
  "lights": [],
  "camera": {"eye": [0, 0, 30], "target": [0, 0, 0], "fov_y": 4.5, "near": 1},
  "output": {"tone_curve": "linear", "background": "#000000"}
}
JSON

with_lights() { # number
    sed 's/"lights": \[\]/"lights": ['"$(printf '{"direction": [0, 1, 0], "irradiance": [1, 1, 1]},%.0s' $(seq "$1") | sed 's/,$//')"']/' "$work/sphere.json"
}
with_lights 3 >"$work/three.json"
with_lights 124 >"$work/many.json"

build() { # map [options]
    rm -f "$work/s.blob"
    "$G" build "$work/sphere.json" -o "$work/s.blob" --no-lod --envmap "$work/$1.hdr" "${@:2}" && "$G" info "$work/s.blob" >"$work/info"
}
light_is() { # direction, irradiance: the mean direction of all lights, the sum of their irradiance; within 0.002
    grep -E '^light' "$work/info"
    awk -v want="$*" '/^light +[0-9]+ directional/ {
        gsub(/,/, "")
        for (i = 0; i < 3; i++) { sum[i + 4] += $(i + 9); sum[i + 1] += $(i + 5) * $9; }
        bright += $9 }
        END { split(want, w, " ")
        for (i = 1; i <= 6; i++) if ((sum[i] / (i <= 3 ? bright : 1) - w[i]) ^ 2 > 4e-6) exit 1
        exit !bright }' "$work/info"
}
lights() {
    grep -cE '^light +[0-9]+ directional' "$work/info"
}
bad() { # code pattern options...
    local code=$1 pattern=$2
    shift 2
    refused "$code" "$pattern" "$G" build "$work/sphere.json" -o "$work/x.blob" "$@"
}

# Four pixels of solid angle 0.00960: radiance 15.94, 8, 4.
check "what is bright in the map's centre shines from +z" eval 'build front && light_is 0 0 0.998 0.6132 0.3078 0.1539'
check "a map turned by 90 degrees shines from +x" eval 'build front --envmap-rotate 90 && light_is 0.998 0 0 0.6132 0.3078 0.1539'
check "a map turned by -90 degrees and twice as bright" eval 'build front --envmap-rotate -90 --envmap-scale 2 && light_is -0.998 0 0 1.2263 0.6156 0.3078'
check "as many lights as asked for, sixteen when not" eval 'build constant && [ "$(lights)" = 16 ] && build constant --envmap-lights 64 && [ "$(lights)" = 64 ] &&
    build constant --envmap-lights 4 && [ "$(lights)" = 4 ]'
check "two builds give the same bytes" eval 'build constant && cp "$work/s.blob" "$work/first" && build constant && cmp "$work/first" "$work/s.blob"'

# A surface under constant radiance r sends out r: 127.5.
white() {
    build constant --envmap-lights 64 && "$B/gtsim" render "$work/s.blob" --size 64x64 -o "$work/white.png" || return 1
    node tests/e2e/read_image.mjs "$work/white.png" 32,32 12,32 52,32 32,12 32,52 20,20 44,44 | tee "$work/pixels"
    awk '{ for (i = 1; i <= 3; i++) if ($i < 124 || $i > 131) bad = 1 } END { exit bad || NR != 7 }' "$work/pixels"
}
check "64 lights of constant radiance 0.5 show a white sphere at 0.5 within 3 %, on the device" white
real=${GONIOTILE_DATA:-../shared/data}/envmaps/studio_256.exr
if [ -r "$real" ]; then
    check "a real map lights a scene beside its own lights" eval '"$G" build "$work/three.json" -o "$work/s.blob" --envmap "$real" --envmap-lights 9 &&
        "$G" info "$work/s.blob" >"$work/info" && [ "$(lights)" = 12 ]'
else
    skip "a real map lights a scene beside its own lights" "no $real"
fi

check "no such map: 3" bad 3 'none.exr: No such file' --envmap "$work/none.exr"
echo "not an image" >"$work/text.exr"
check "not an image: 4" bad 4 'text.exr: .*; give an intact image' --envmap "$work/text.exr"
head -c 3000 "$work/constant.hdr" >"$work/cut.hdr"
"$B/gtsim" render "$work/s.blob" --size 16x8 -o "$work/sky.png" || exit 1
check "a picture of encoded integers is no radiance: 4" bad 4 'sky.png: pixels are uint8, linear floats are wanted: EXR or Radiance HDR' --envmap "$work/sky.png"
check "a truncated map: 4" bad 4 'cut.hdr: .*; give an intact image' --envmap "$work/cut.hdr"
check "a black map: 4" bad 4 'black.hdr: black all over; give a map that holds light' --envmap "$work/black.hdr"
check "a light too bright for the blob: 4, and the scale that would do" eval 'bad 4 "irradiance of [0-9.]+, the limit is 256; give --envmap-scale [0-9.e-]+$" --envmap "$work/sun.hdr" &&
    build sun --envmap-scale "$(sed "s/.* //" "$work/err")"'
check "more lights than a scene holds: 4" refused 4 '16 lights beside the scene.s 124, at most 128 fit' "$G" build "$work/many.json" -o "$work/x.blob" --envmap "$work/constant.hdr"
check "numbers out of range: 2" eval 'bad 2 "--envmap-lights: .65. is not a whole number from 4 to 64" --envmap-lights 65 && bad 2 "--envmap-lights" --envmap-lights 3 &&
    bad 2 "--envmap-scale" --envmap-scale 0 && bad 2 "--envmap-rotate" --envmap-rotate 361'
echo "1..$n"
