#!/usr/bin/env bash
# Atlases: tables go in and come out to the byte, a device shades from one as from the tables alone, and damage is refused.
. tests/e2e/usb_common.sh

names=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green) # slots of six_models
half=("${names[@]/#/$DEMO/}")
half=("${half[@]/%/.ktx2}")
frame=()
for name in "${names[@]:0:5}"; do
    gtlut build "$DEMO/$name.csv" -o "$work/$name.ktx2" --size 31x16 2>"$work/log" || { cat "$work/log"; exit 1; }
    frame+=("$work/$name.ktx2")
done
cd "$work" || exit 1

same_out() { # atlas file...: each file is what is extracted
    local i=0 f
    for f in "${@:2}"; do
        gtlut atlas --extract $i "$1" -o out.ktx2 && cmp out.ktx2 "$f" || return 1
        i=$((i + 1))
    done
    ! gtlut atlas --extract $i "$1" -o none.ktx2 && [ ! -e none.ktx2 ]
}
round() { # atlas file...
    gtlut atlas "${@:2}" -o "$1" && same_out "$@"
}
check half_vector_tables_come_out_as_they_went_in round half.ktx2 "${half[@]}"
check specular_frame_tables_come_out_as_they_went_in round frame.ktx2 "${frame[@]}"
check one_table_is_an_atlas round one.ktx2 "${frame[0]}"
twice() {
    gtlut atlas half.ktx2 "${half[0]}" one.ktx2 -o x.ktx2 && return 1 # not of one kind
    gtlut atlas one.ktx2 frame.ktx2 "${frame[2]}" -o seven.ktx2 && same_out seven.ktx2 "${frame[0]}" "${frame[@]}" "${frame[2]}"
}
check atlases_bring_all_their_tables twice
same_bytes() {
    gtlut atlas frame.ktx2 -o again.ktx2 && cmp frame.ktx2 again.ktx2
}
check an_atlas_of_an_atlas_is_the_same same_bytes
expect info_lists_the_tables 0 'kind: atlas, specular frame
bytes: [0-9]+
tables: 5 in 3 columns
texels of a table: 31 x 16 x 4
table 0: matte_white.csv
table 1: plastic_red.csv
table 2: gold.csv
table 3: plastic_blue_rough.csv
table 4: copper_satin.csv' '' gtlut info frame.ktx2
expect info_in_json 0 '\{"kind": "atlas", "table_kind": "half_vector", "bytes": [0-9]+, "columns": 3, "texels": \[8, 64, 32\], "sources": \[("[a-z_]+.csv"(, )?){6}\]\}' '' \
    gtlut info half.ktx2 --json

# The image is that of the paper: the slices in row-major order (2 x 2), in each the tables (3 x 2).
root=$(cd "$OLDPWD" && pwd)
texels() { # table file: its texels, all that follows the first 228 bytes and the key/value data
    tail -c $((4 * 31 * 16 * 4)) "$1"
}
image() {
    local i
    gtlut atlas frame.ktx2 -o frame.exr || return 1
    for i in 0 1 2 3 4; do
        gtlut atlas --extract $i frame.exr --axes 31x16x4 --grid 3x2 -o out.ktx2 && gtlut info out.ktx2 | grep -q 'theta_in: 0 20 40 60' &&
            cmp <(texels out.ktx2) <(texels "${frame[i]}") || return 1
    done
}
check an_exr_image_keeps_every_texel image
layout() {
    gtlut export "${frame[4]}" -o single.exr || return 1
    # Table 4 is the middle one of the lower row; node (5, 3) of slices 0 and 3.
    node "$root/tests/e2e/read_image.mjs" frame.exr $((31 + 5)),$((16 + 3)) $((93 + 31 + 5)),$((32 + 16 + 3)) >of_atlas
    node "$root/tests/e2e/read_image.mjs" single.exr 5,3 $((31 + 5)),$((16 + 3)) >of_table
    cat of_atlas of_table
    cmp of_atlas of_table
}
check the_image_is_slices_of_grids layout
png() {
    gtlut atlas half.ktx2 -o half.png --exposure 0.5 && [ "$(head -c 4 half.png | tail -c 3)" = PNG ]
}
check a_png_to_look_at png

# --- on the device ---
scene=$DEMO/six_models.blob
sed -E 's/"material": "[a-z_]+"/"slot": 0/' "$root/host_tools/scenes/six_models.json" |
    awk '/"slot": 0/ && /"mesh"/ { sub(/"slot": 0/, "\"slot\": " i++) } { print }' |
    sed -E '/^  "materials"/,/^  \]/c\  "materials": [],' >slots.json
separate() { # picture
    gtsim render "$scene" --table 0="${half[0]}" --table 1="${half[1]}" --table 2="${half[2]}" --table 3="${half[3]}" \
        --table 4="${half[4]}" --table 5="${half[5]}" --size 160x120 -o "$1"
}
check the_tables_are_rendered_from separate separate.png
from_atlas() {
    gtsim render "$scene" --atlas half.ktx2 --size 160x120 -o atlas.png && cmp separate.png atlas.png
}
check a_picture_from_an_atlas_is_that_from_the_tables from_atlas
index_only() {
    gtscene build slots.json -o slots.blob && gtscene info slots.blob | grep -cE '^material .* slot +[0-5] measured$' | grep -qx 6 &&
        gtsim render slots.blob --atlas half.ktx2 --size 160x120 -o slots.png && cmp separate.png slots.png
}
check surfaces_that_carry_only_the_index_show_the_same index_only
instead() {
    gtsim render "$scene" --atlas half.ktx2 --table 2="${half[5]}" --size 160x120 -o instead.png && ! cmp -s separate.png instead.png
}
check a_table_takes_the_place_of_the_atlas_one instead
pushed() {
    gtsim run --flash flash --size 160x120 -- bash -c 'gtusb push "$0" && gtusb push half.ktx2 >first && gtusb push half.ktx2 --json >second &&
        gtusb verify half.ktx2 && gtusb frame -o pushed.png' "$scene" || return 1
    cat first second
    [ "$(grep -cE '^half.ktx2 to table slot [0-5]: [1-9][0-9]+ bytes in ' first)" = 6 ] && cmp separate.png pushed.png &&
        node -e 'const x = JSON.parse(require("fs").readFileSync("second"));
            process.exit(x.length == 6 && x.every((t, i) => t.slot == i && t.already_there && t.resumed_after == t.bytes) ? 0 : 1)'
}
check gtusb_pushes_what_is_not_there_yet pushed
cut_off() { # a push that was interrupted after the second table goes on with the third
    rm -f flash && gtsim run --flash flash --size 160x120 -- bash -c 'gtusb push "${half_0}" --slot 0 && gtusb push "${half_1}" --slot 1 &&
        gtusb push half.ktx2 >third' || return 1
    [ "$(grep -cE '^half.ktx2 to table slot [01]: all [0-9]+ bytes are there already$' third)" = 2 ] && ! grep resumed third
}
export half_0=${half[0]} half_1=${half[1]}
check a_push_goes_on_where_it_stopped cut_off
another() { # cut off in its last table; then another atlas of the same last table goes its own way
    rm -f flash && gtlut atlas "${half[@]:0:5}" -o five.ktx2 && gtlut atlas "${half[1]}" "${half[@]:1}" -o other.ktx2 || return 1
    gtsim run --flash flash -- gtusb push five.ktx2 >/dev/null || return 1
    gtsim run --flash flash --unplug-after 100000 -- bash -c 'gtusb push half.ktx2; [ $? = 8 ] || exit 1
        sleep 0.6; gtusb info | grep "^upload" && gtusb push other.ktx2 && gtusb verify other.ktx2'
}
check another_atlas_after_one_that_was_cut_off_is_pushed another
expect slots_that_the_device_lacks 9 '' 'gtusb: push: half.ktx2: 6 tables from slot 11 on, the device has table slots 0 to 15; give fewer' \
    gtsim run -- gtusb push half.ktx2 --slot 11
seventeen() {
    gtlut atlas frame.ktx2 frame.ktx2 frame.ktx2 one.ktx2 one.ktx2 -o many.ktx2
}
check seventeen_tables_fit_into_a_file seventeen
expect but_not_into_a_device 9 '' 'gtsim: render: many.ktx2: 17 tables, the device has 16 slots; give fewer' \
    gtsim render "$scene" --atlas many.ktx2 -o x.png
expect an_atlas_is_no_table 4 '' 'gtsim: render: frame.ktx2: an atlas; give it with --atlas' gtsim render "$scene" --table 0=frame.ktx2 -o x.png
expect an_atlas_is_no_table_to_gtlut 4 '' 'gtlut: export: frame.ktx2: an atlas; gtlut atlas --extract takes a table out of it' \
    gtlut export frame.ktx2 -o x.png

# --- refusals ---
gtlut build "$DEMO/gold.csv" -o small.ktx2 --size 21x16 2>log
gtlut build "$DEMO/gold.csv" -o swap.ktx2 --size 31x16 --swap 2>log
expect tables_of_two_sizes 4 '' 'gtlut: atlas: small.ktx2: not of the same kind, size and angles as .*matte_white.ktx2; build both alike' \
    gtlut atlas "${frame[0]}" small.ktx2 -o x.ktx2
expect tables_of_two_kinds 4 '' 'gtlut: atlas: .*gold.ktx2: not of the same kind.*' gtlut atlas "${frame[0]}" "${half[2]}" -o x.ktx2
expect tables_that_read_their_angles_differently 4 '' 'gtlut: atlas: swap.ktx2: not of the same kind.*' gtlut atlas "${frame[0]}" swap.ktx2 -o x.ktx2
expect no_table_at_all 4 '' 'gtlut: atlas: .*gold.csv: not a KTX 2.0 file; .*' gtlut atlas "$DEMO/gold.csv" -o x.ktx2
expect not_an_atlas 4 '' 'gtlut: atlas: .*: not an atlas; .*' gtlut atlas --extract 0 "${frame[0]}" -o x.ktx2
expect no_such_file 3 '' 'gtlut: atlas: none.ktx2: No such file.*' gtlut atlas none.ktx2 -o x.ktx2
expect no_table_given 2 '' 'gtlut: atlas: no table given; .*' gtlut atlas -o x.ktx2
expect no_output 2 '' 'gtlut: atlas: no output file; give -o FILE' gtlut atlas frame.ktx2
expect output_of_another_kind 2 '' "gtlut: atlas: -o: 'x.bmp' does not end in .ktx2, .exr or .png" gtlut atlas frame.ktx2 -o x.bmp
expect index_beyond_the_last 2 '' 'gtlut: atlas: --extract 5: frame.ktx2 has tables 0 to 4' gtlut atlas --extract 5 frame.ktx2 -o x.ktx2
expect axes_without_grid 2 '' 'gtlut: atlas: --axes and --grid go together; .*' gtlut atlas --extract 0 frame.exr --axes 31x16x4 -o x.ktx2
expect an_image_of_other_axes 4 '' 'gtlut: atlas: frame.exr: 186 x 64 pixels do not hold 4 slices of 96 x 32 .*' \
    gtlut atlas --extract 0 frame.exr --axes 32x16x4 --grid 3x2 -o x.ktx2
gtlut build "$DEMO/gold.csv" -o large.ktx2 2>log
expect more_than_a_texture_holds 2 '' 'gtlut: atlas: 65 tables make 3249 x 1448 x 4 texels, at most 4096 a side and 16777216 in all fit; give fewer' \
    gtlut atlas $(printf 'large.ktx2 %.0s' {1..65}) -o x.ktx2
check nothing_was_left_behind eval '[ ! -e x.ktx2 ] && [ ! -e x.png ] && [ -z "$(ls -A | grep tmp)" ]'

# Every length in the head of the file and some behind; every byte of the head changed.
head_bytes=$((228 + $(od -A n -t u4 -j 60 -N 4 one.ktx2)))
cut_anywhere() {
    local n
    for n in $(seq 0 97 $head_bytes) $((head_bytes - 1)) $head_bytes $((head_bytes + 1)) $(($(stat -c %s one.ktx2) - 1)); do
        head -c "$n" one.ktx2 >cut.ktx2
        gtlut atlas --extract 0 cut.ktx2 -o x.ktx2 2>err
        [ $? = 4 ] && [ "$(wc -l <err)" = 1 ] || { echo "$n bytes"; cat err; return 1; }
    done
    cat one.ktx2 <(printf '\0\0\0\0') >long.ktx2
    gtlut atlas --extract 0 long.ktx2 -o x.ktx2 2>err
    [ $? = 4 ]
}
check a_file_cut_anywhere_ends_with_code_4 cut_anywhere
damaged() {
    local n code refused=0
    for ((n = 0; n < head_bytes; n += 19)); do
        cp one.ktx2 bad.ktx2
        printf '\xee' | dd of=bad.ktx2 bs=1 seek=$n conv=notrunc status=none
        gtlut atlas --extract 0 bad.ktx2 -o y.ktx2 >out 2>err
        code=$?
        refused=$((refused + (code == 4)))
        [ $code = 4 ] || { [ $code = 0 ] && gtlut info y.ktx2 >out; } || { echo "byte $n: exit code $code"; cat err; return 1; }
    done
    echo "$refused refused"
    [ $refused -ge 30 ] # the rest are texts and descriptions
}
check a_damaged_head_is_refused_or_gives_a_table damaged

echo 1..$n
