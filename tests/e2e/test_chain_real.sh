#!/usr/bin/env bash
# Real materials on a real mesh through the whole chain, as README's example: import, build, scene, push over USB, frame.
# Needs the data folder. KEEP=FOLDER keeps the pictures.
. tests/e2e/usb_common.sh

DATA=${GONIOTILE_DATA:-../shared/data}
mesh=$DATA/meshes/spot_6k.obj

for name in cc_ibiza_sunset paper_white; do
    material=$DATA/brdf/${name}_rgb.bsdf
    if [ ! -f "$material" ] || [ ! -f "$mesh" ]; then
        for step in imports builds becomes_a_scene is_pushed_and_rendered_over_usb equals_the_frame_without_usb shows_a_surface; do
            skip "${name}_$step" "no real data (GONIOTILE_DATA)"
        done
        continue
    fi
    check "${name}_imports" gtlut import "$material" -o "$work/m.gtm"
    check "${name}_builds" gtlut build "$work/m.gtm" -o "$work/m.ktx2"
    check "${name}_becomes_a_scene" gtscene build host_tools/scenes/spot.json --data "$DATA/meshes" -o "$work/spot.blob"
    check "${name}_is_pushed_and_rendered_over_usb" gtsim run -- bash -e -c 'gtusb push "$work/spot.blob"
        gtusb push "$work/m.ktx2" --slot 0; gtusb frame -o "$work/usb.png"; gtusb stats --json > "$work/stats.json"'
    check "${name}_equals_the_frame_without_usb" bash -c 'gtsim render "$work/spot.blob" --table 0="$work/m.ktx2" \
        -o "$work/render.png" && cmp "$work/usb.png" "$work/render.png"'
    check "${name}_shows_a_surface" node -e "const x = JSON.parse(require('fs').readFileSync('$work/stats.json')).total;
        if (!(x.covered > 10000 && x.shaded > 10000 && x.fetches == 8 * x.shaded)) { console.log(x); process.exit(1) }"
    [ -z "${KEEP:-}" ] || cp "$work/usb.png" "$KEEP/$name.png"
done

echo 1..$n
