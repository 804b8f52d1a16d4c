#!/usr/bin/env bash
# gtusb against the simulated device on a mocked USB bus: stdout, stderr and exit code of every subcommand, and what the device keeps
# when something goes wrong.
. tests/e2e/usb_common.sh

scene=$DEMO/six_models.blob
gtlut build "$DEMO/gold.csv" -o "$work/gold.ktx2" --size 91x46 || exit 1
gtlut build "$DEMO/satin_green.csv" -o "$work/green.ktx2" --size 91x46 || exit 1
bank="--bank 131072" # small, so that copies of the flash cost little
# A device's flash with the scene, gold in every slot the scene uses, green in slot 6.
load='gtusb push "$DEMO/six_models.blob" && for s in 0 1 2 3 4 5; do gtusb push "$work/gold.ktx2" --slot $s || exit; done
    gtusb push "$work/green.ktx2" --slot 6'
gtsim run $bank --flash "$work/flash" -- bash -c "$load" >"$work/load" || { cat "$work/load"; exit 1; }
loaded() { # gtsim options... -- command...: with a copy of that flash
    cp "$work/flash" "$work/flash.copy" && gtsim run $bank --flash "$work/flash.copy" "$@"
}
bytes=$(stat -c %s "$work/gold.ktx2")
scene_bytes=$(stat -c %s "$scene")

# --- usage ---
expect help_goes_to_stdout 0 'Usage: gtusb COMMAND.*frame.*Exit codes.*' '' gtusb --help
expect version_is_printed 0 'gtusb [0-9]+\.[0-9]+\.[0-9]+' '' gtusb --version
expect no_command_is_a_usage_error 2 '' 'Usage: gtusb COMMAND.*' gtusb
expect unknown_command_is_a_usage_error 2 '' "gtusb: no command 'fly'; see .*" gtusb fly
for c in list info push verify select frame stats reset "set camera" "set light" "set output" "set model"; do
    expect "help_of_${c// /_}" 0 "Usage: gtusb $c.*" '' gtusb $c --help
    expect "version_of_${c// /_}" 0 'gtusb [0-9.]+' '' gtusb $c --version
    expect "unknown_option_of_${c// /_}" 2 '' "gtusb $c: .*--unknown.*" gtusb $c --unknown
done
expect help_of_set 0 'Usage: gtusb set .*' '' gtusb set --help

usage() { # claim stderr arguments...: exit code 2 before any device is looked for
    local claim=$1 err=$2
    shift 2
    expect "$claim" 2 '' "$err" gtusb "$@"
}
usage push_without_file 'Usage: gtusb push.*' push
usage push_slot_out_of_range "gtusb: push: --slot: '16' is not a whole number from 0 to 15" push "$work/gold.ktx2" --slot 16
usage push_slot_not_a_number "gtusb: push: --slot: 'two' is not .*" push "$work/gold.ktx2" --slot two
usage push_table_without_slot 'gtusb: push: .*gold.ktx2 is a table: --slot is missing; .*' push "$work/gold.ktx2"
usage push_scene_with_slot 'gtusb: push: .*six_models.blob is a scene .*; leave --slot out' push "$scene" --slot 0
usage verify_without_file 'Usage: gtusb verify.*' verify
usage verify_table_without_slot 'gtusb: verify: .*gold.ktx2 is a table: --slot is missing; .*' verify "$work/gold.ktx2"
usage select_without_slot 'gtusb: select: MATERIAL and SLOT are needed; .*' select 1
usage select_slot_out_of_range "gtusb: select: SLOT: '16' is not .* 0 to 15" select 1 16
usage select_material_out_of_range "gtusb: select: MATERIAL: '-1' is not .*" select -- -1 0
usage set_without_setting "gtusb: set: no setting ''; .*" set
usage set_unknown_setting "gtusb: set: no setting 'weather'; .*" set weather
usage model_unknown "gtusb: set: no model 'phong'; it is one of measured, lafortune_phong, blinn_phong, metallic_roughness, scene" set model phong
usage model_missing "gtusb: set: no model ''; .*" set model
usage camera_incomplete 'gtusb: set: --eye, --target, --fov and --near are all needed; .*' set camera --eye 0,0,1
usage camera_not_three_numbers "gtusb: set: --eye: '1,2' is not three numbers; write x,y,z" set camera --eye 1,2
usage camera_coordinate_out_of_range "gtusb: set: --eye: '32768' is not a number from .*" set camera --eye 0,32768,0
usage camera_fov_out_of_range "gtusb: set: --fov: '180' is not .*" set camera --fov 180
usage camera_near_zero "gtusb: set: --near: '0' is not .*" set camera --near 0
usage camera_not_a_number "gtusb: set: --near: 'nan' is not .*" set camera --near nan
usage camera_eye_is_target 'gtusb: set: --eye and --target are the same point; .*' \
    set camera --eye 1,1,1 --target 1,1,1 --fov 40 --near 0.1
usage camera_up_along_view 'gtusb: set: --up is parallel to .*' \
    set camera --eye 0,2,0 --target 0,0,0 --fov 40 --near 0.1
light_needs='gtusb: set: INDEX and either --direction and --irradiance, or --position, --power and --radius, are all needed; .*'
usage light_incomplete "$light_needs" set light 0 --direction 0,1,0
usage point_light_incomplete "$light_needs" set light 0 --position 0,1,0 --power 1,1,1
usage light_of_both_kinds "$light_needs" set light 0 --direction 0,1,0 --irradiance 1,1,1 --radius 2
usage point_light_radius_zero "gtusb: set: --radius: '0' is not .*" set light 0 --radius 0
usage point_light_power_too_large "gtusb: set: --power: '800001' is not .*" set light 0 --power 0,0,800001
usage point_light_too_far "gtusb: set: --position: '40000' is not .*" set light 0 --position 0,40000,0
usage light_index_out_of_range "gtusb: set: INDEX: '128' is not .*" set light 128 --direction 0,1,0 --irradiance 1,1,1
usage light_without_direction 'gtusb: set: --direction: 0,0,0 has none; .*' \
    set light 0 --direction 0,0,0 --irradiance 1,1,1
usage light_negative_irradiance "gtusb: set: --irradiance: '-1' is not .*" set light 0 --irradiance 1,-1,1
usage light_irradiance_out_of_range "gtusb: set: --irradiance: '256.5' is not a number from 0 to 256" set light 0 --irradiance 1,256.5,1
usage output_incomplete 'gtusb: set: --exposure, --tone and --background are all needed; .*' set output --exposure 1
usage output_unknown_tone "gtusb: set: --tone: no curve 'film'; it is none, aces or linear" set output --tone film
usage output_background_out_of_range "gtusb: set: --background: '256' is not .*" set output --background 0,0,256
usage output_exposure_too_long "gtusb: set: --exposure: '257' is not a number from 0 to 256" set output --exposure 257
usage output_exposure_out_of_range "gtusb: set: --exposure: '-1' is not .*" set output --exposure -1
usage timeout_zero "gtusb: info: --timeout: '0' is not .*" info --timeout 0
usage frame_without_output 'gtusb: frame: no output file; give -o FILE.png' frame

# --- files that are wrong, before any device is looked for ---
: >"$work/empty"
echo 'hello, world, this is no table' >"$work/text"
head -c 100 "$scene" >"$work/header.blob"
head -c $((scene_bytes - 1)) "$scene" >"$work/short.blob"
head -c $((bytes - 4)) "$work/gold.ktx2" >"$work/short.ktx2"
cp "$work/gold.ktx2" "$work/corrupt.ktx2"
printf '\x25' | dd of="$work/corrupt.ktx2" bs=1 seek=12 conv=notrunc status=none # vkFormat 37
expect push_missing_file 3 '' "gtusb: push: $work/none.ktx2: No such file.*; .*" gtusb push "$work/none.ktx2" --slot 0
expect push_empty_file 4 '' "gtusb: push: $work/empty: neither .* of 0 bytes; .*" gtusb push "$work/empty"
expect push_foreign_file 4 '' "gtusb: push: $work/text: neither a table .* nor a scene .*; .*" gtusb push "$work/text"
for f in header.blob short.blob; do
    expect "push_truncated_${f%.blob}_scene" 4 '' "gtusb: push: $work/$f: not a valid scene: .*; .*" gtusb push "$work/$f"
done
expect push_truncated_table 4 '' "gtusb: push: $work/short.ktx2: not a valid table: .*; .*" \
    gtusb push "$work/short.ktx2" --slot 0
expect push_corrupt_table 4 '' "gtusb: push: $work/corrupt.ktx2: not a valid table: .*; .*" \
    gtusb push "$work/corrupt.ktx2" --slot 0

# --- which device ---
none="no device: none with id 1209:0001 on any bus; plug it in, or .*"
for c in list info stats reset "push $scene" "select 0 0" "set model measured" "frame -o $work/x.png"; do
    expect "no_device_for_${c%% *}" 5 '' "gtusb: ${c%% *}: $none" gtsim run --devices 0 -- gtusb $c
done
check no_device_no_output test ! -e "$work/x.png"
expect list_prints_port_id_serial 0 '1-1 +1209:0001 +GT-SIM-0001' '' gtsim run -- gtusb list
expect list_prints_serial_given 0 '1-1 +1209:0001 +MINE-7' '' gtsim run --serial MINE-7 -- gtusb list
expect list_prints_both 0 $'1-. +1209:0001 +GT-SIM-0001(-2)?\n1-. +1209:0001 +GT-SIM-0001(-2)?' '' \
    gtsim run --devices 2 -- gtusb list
expect two_devices_are_listed_and_refused 6 '' \
    $'gtusb: info: 2 devices match; choose one by --serial or --port:(\n1-[12] +1209:0001 +GT-SIM-0001(-2)?){2}' \
    gtsim run --devices 2 -- gtusb info
expect two_devices_refuse_push 6 '' 'gtusb: push: 2 devices match; .*' gtsim run --devices 2 -- gtusb push "$scene"
expect serial_resolves 0 'firmware.*' '' gtsim run --devices 2 -- gtusb info --serial GT-SIM-0001-2
expect unknown_serial 5 '' 'gtusb: info: no device: 2 there, none with serial number X; see .*' \
    gtsim run --devices 2 -- gtusb info --serial X
expect unknown_port 5 '' 'gtusb: info: no device: 2 there, none with port 1-3; see .*' \
    gtsim run --devices 2 -- gtusb info --port 1-3
expect port_and_serial_that_disagree 5 '' 'gtusb: info: no device: .*' \
    gtsim run --devices 2 -- gtusb info --port 1-1 --serial GT-SIM-0001-2
port_chooses() { # the scene pushed to one device is on that one only
    gtsim run --devices 2 -- bash -c 'gtusb push "$0" --port 1-2 && gtusb info --port 1-1 && gtusb info --port 1-2' \
        "$scene" >"$work/out" && grep -c '^scene      empty' "$work/out" | grep -qx 1 &&
        tail -n 17 "$work/out" | grep -q '^scene      scene '
}
check port_resolves_and_names_that_device port_chooses

install -m 755 "$B/gtusb" "$work/gtusb" && chmod 755 "$work"
export drop=""
[ "$(id -u)" != 0 ] || drop="setpriv --reuid=65534 --clear-groups"
forbid='chmod -R a+rwX "$UMOCKDEV_DIR" && chmod 0 "$UMOCKDEV_DIR/dev/bus/usb/001/002" && '
expect no_permission_names_the_udev_rule 7 '' \
    'gtusb: info: device 1-1: no permission; install host_tools/60-goniotile.rules .*' \
    gtsim run -- bash -c "$forbid"'$drop "$work/gtusb" info'
expect no_permission_with_serial 7 '' 'gtusb: info: device 1-1: no permission; .*' \
    gtsim run -- bash -c "$forbid"'$drop "$work/gtusb" info --serial GT-SIM-0001'
expect list_says_no_permission 0 '1-1 +1209:0001 +Access denied.*' '' \
    gtsim run -- bash -c "$forbid"'$drop "$work/gtusb" list'
check rule_file_matches_the_ids grep -q 'ATTR{idVendor}=="1209", ATTR{idProduct}=="0001"' host_tools/60-goniotile.rules

# --- what a device says ---
expect info_of_an_empty_device 0 \
    $'firmware +[0-9.]+, protocol version 3.*\npicture +320 x 240, RGB888, tiles of 64 x 32\nscene +0 objects.*\n0 +empty .*' \
    '' gtsim run -- gtusb info
expect info_of_a_loaded_device 0 ".*scene +6 objects, 6 materials, 3 lights, [0-9]+ triangles.*scene +scene +$scene_bytes .*\
5 +table +$bytes .*6 +table .*7 +empty .*" '' loaded -- gtusb info
json() { # file javascript: the file parses and the expression over x is true
    node -e "const x = JSON.parse(require('fs').readFileSync('$1')); if (!($2)) process.exit(1)"
}
info_json() {
    loaded --size 33x17 --format rgb565 -- gtusb info --json >"$work/info.json" || return 1
    json "$work/info.json" "x.width == 33 && x.height == 17 && x.format == 'rgb565' && x.objects == 6 && x.tables.length == 16 &&
        x.scene.bytes == $scene_bytes && x.tables[0].kind == 'table' && x.tables[0].bytes == $bytes && x.tables[15].kind == 'empty'"
}
check info_json_parses info_json
info_counts_erasures() { # of the two banks, in turn, over restarts
    rm -f "$work/flash.new"
    for i in 1 2 3; do
        gtsim run $bank --flash "$work/flash.new" -- gtusb push "$work/gold.ktx2" --slot 2 || return 1
    done
    gtsim run $bank --flash "$work/flash.new" -- bash -c 'gtusb info --json >"$work/info.json"; gtusb info' >"$work/info.txt" &&
        json "$work/info.json" "x.tables[2].erases.join() == '2,1' && x.tables[3].erases.join() == '0,0' && x.flash.scrubbed == 0 &&
            x.flash.block_bytes == 4096 && x.flash.bytes == 2 * (2097152 + 16 * 131072)" &&
        grep -q '^2 .* 2 + 1 times$' "$work/info.txt" && grep -q '^flash *8388608 bytes in blocks of 4096$' "$work/info.txt"
}
check info_counts_erasures info_counts_erasures
list_json() {
    gtsim run --devices 2 -- gtusb list --json >"$work/list.json" &&
        json "$work/list.json" "x.length == 2 && x.map(d => d.serial).sort().join() == 'GT-SIM-0001,GT-SIM-0001-2' &&
            x.every(d => d.error === null && /^1-[12]\$/.test(d.port))"
}
check list_json_parses list_json
expect stats_before_a_frame 0 'frames 0, tiles 0.*' '' loaded -- gtusb stats
stats_add_up() {
    loaded -- bash -c 'gtusb frame -o "$work/s.png" && gtusb stats --json --tiles > "$work/stats.json" &&
        gtusb stats --tiles > "$work/stats.txt" && gtusb stats > "$work/stats_short.txt"' || return 1
    json "$work/stats.json" "x.frames == 1 && x.tile_count == 40 && x.tiles.length == 40 && x.total.covered > 10000 &&
        ['triangles', 'tested', 'covered', 'shaded', 'fetches'].every(k => x.tiles.reduce((s, t) => s + t[k], 0) == x.total[k]) &&
        Math.max(...x.tiles.map(t => t.ticks)) == x.slowest.ticks && x.tiles[x.slowest.tile].ticks == x.slowest.ticks &&
        x.tiles.map(t => t.ticks).sort((a, b) => a - b)[20] == x.median.ticks" || return 1
    [ "$(wc -l <"$work/stats.txt")" = 45 ] && [ "$(wc -l <"$work/stats_short.txt")" = 5 ] &&
        head -n 5 "$work/stats.txt" | cmp - "$work/stats_short.txt"
}
check stats_of_tiles_add_up_to_the_total stats_add_up

# --- push, frame and what changes a frame ---
expect push_prints_bytes_time_rate 0 "gold.ktx2 to table slot 7: $bytes bytes in [0-9.]+ s, [0-9.]+ MB/s" '' \
    loaded -- gtusb push "$work/gold.ktx2" --slot 7
expect push_scene_prints_bytes_time_rate 0 "six_models.blob to scene: $scene_bytes bytes in [0-9.]+ s, [0-9.]+ MB/s" '' \
    loaded -- gtusb push "$scene"
push_json() {
    loaded -- gtusb push "$work/gold.ktx2" --slot 7 --json >"$work/push.json" &&
        json "$work/push.json" "x.slot == 7 && x.kind == 'table' && x.bytes == $bytes && x.resumed_after == 0 && x.verified && !x.already_there &&
            x.file == '$work/gold.ktx2' && x.bytes_per_second > 0 && x.crc > 0"
}
check push_json_parses push_json
expect verify_of_what_was_pushed 0 "gold.ktx2 is in table slot 5: $bytes bytes, CRC-32 [0-9a-f]{8}
six_models.blob is in scene: $scene_bytes bytes, CRC-32 [0-9a-f]{8}" '' \
    loaded -- bash -c 'gtusb verify "$work/gold.ktx2" --slot 5 && gtusb verify "$DEMO/six_models.blob"'
expect verify_of_another_table 10 '' 'gtusb: verify: gold.ktx2: table slot 6 differs: its CRC-32 is .*; push the file again' \
    loaded -- gtusb verify "$work/gold.ktx2" --slot 6
expect verify_of_an_empty_slot 10 '' 'gtusb: verify: gold.ktx2: table slot 9 is empty; push the file' \
    loaded -- gtusb verify "$work/gold.ktx2" --slot 9
for after in 0 20 30000; do # in BEGIN's neighbourhood, in the first DATA, in the midst of others on their way
    expect "data_damaged_after_${after}_bytes_is_sent_again" 0 "gold.ktx2 to table slot 1: $bytes bytes .*is in table slot 1.*" '' \
        loaded --damage-after $after -- bash -c 'gtusb push "$work/gold.ktx2" --slot 1 && gtusb verify "$work/gold.ktx2" --slot 1'
done
tables=(); for s in 0 1 2 3 4 5; do tables+=(--table $s="$work/gold.ktx2"); done
same_as_render() { # gtsim options...
    loaded "$@" -- gtusb frame -o "$work/usb.png" && gtsim render "$scene" "${tables[@]}" -o "$work/render.png" \
        $(printf '%s\n' "$@" | grep -v full-speed) && cmp "$work/usb.png" "$work/render.png"
}
check frame_over_usb_equals_render same_as_render
check frame_at_full_speed_equals_render same_as_render --full-speed
check frame_in_rgb565_equals_render same_as_render --format=rgb565
check frame_of_odd_size_equals_render same_as_render --size=101x67
check frame_of_one_pixel_equals_render same_as_render --size=1x1
progress_on_a_terminal() { # and nowhere else: every push above has an empty stderr
    loaded -- script -qec 'gtusb push "$DEMO/six_models.blob"' /dev/null | tr '\r' '\n' | grep -q '^push: 100 %, .* KB, .* MB/s'
}
check progress_is_shown_on_a_terminal progress_on_a_terminal
expect frame_prints_nothing 0 '' '' loaded -- gtusb frame -o "$work/f.png"

changes() { # claim command...: the command changes the frame, reset brings it back
    local claim=$1
    shift
    printf -v command '%q ' "$@"
    check "$claim" loaded -- bash -c 'rm -f "$work"/[abc].png; gtusb frame -o "$work/a.png" && '"$command"' &&
        gtusb frame -o "$work/b.png" && gtusb reset && gtusb frame -o "$work/c.png" &&
        ! cmp "$work/a.png" "$work/b.png" && cmp "$work/a.png" "$work/c.png"'
}
changes select_changes_the_frame_until_reset gtusb select 1 6
changes model_changes_the_frame_until_reset gtusb set model lafortune_phong
changes camera_changes_the_frame_until_reset gtusb set camera --eye 0,2,9 --target 0,0.5,0 --fov 35 --near 0.1
changes light_changes_the_frame_until_reset gtusb set light 0 --direction 1,0,3 --irradiance 1,2,1
changes point_light_changes_the_frame_until_reset gtusb set light 0 --position 0,1,4 --power 100,80,60 --radius 9
changes added_light_changes_the_frame_until_reset gtusb set light 3 --direction 0,0,1 --irradiance 1,1,1
changes output_changes_the_frame_until_reset gtusb set output --exposure 0.5 --tone none --background 200,10,20
scene_model_restores() {
    loaded -- bash -c 'gtusb frame -o "$work/a.png" && gtusb set model lafortune_phong && gtusb set model scene &&
        gtusb frame -o "$work/b.png" && cmp "$work/a.png" "$work/b.png"'
}
check model_scene_restores_the_frame scene_model_restores
# The demo scene's own camera, from its description: the same eye gives the same frame, or one that differs in rounding only.
scene_camera() {
    loaded -- bash -c 'gtusb frame -o "$work/a.png" && gtusb set camera --eye $1 --target $2 --up $3 --fov $4 --near $5 &&
        gtusb frame -o "$work/b.png" && cmp "$work/a.png" "$work/b.png"' - \
        $(node -e "const c = JSON.parse(require('fs').readFileSync('host_tools/scenes/six_models.json')).camera;
            console.log([c.eye, c.target, c.up, c.fov_y, c.near].join(' '))")
}
check camera_of_the_scene_gives_the_frame_of_the_scene scene_camera

# --- refused by the device ---
refused() { # claim stderr gtsim_options... -- command...
    local claim=$1 err=$2
    shift 2
    expect "$claim" 9 '' "$err" "$@"
}
refused table_too_large_for_its_slot \
    "gtusb: push: gold.ktx2 of $bytes bytes to table slot 3: refused by the device: larger than .* bank of [0-9]+ bytes; .*" \
    gtsim run --bank 65536 -- gtusb push "$work/gold.ktx2" --slot 3
refused write_lock 'gtusb: push: .*: refused by the device: the board forbids writing; .*' \
    loaded --write-lock -- gtusb push "$work/gold.ktx2" --slot 0
refused frame_without_scene 'gtusb: frame: refused by the device: not possible now; push a scene first' \
    gtsim run -- gtusb frame -o "$work/x.png"
refused frame_without_table 'gtusb: frame: refused by the device: the table slot of material 1 is empty; .*' \
    loaded -- bash -c 'gtusb select 1 9 && gtusb frame -o "$work/x.png"'
refused select_unknown_material 'gtusb: select: material 6, slot 0: refused by the device: value out of range; .*' loaded -- gtusb select 6 0
refused light_beyond_the_next 'gtusb: set: .*refused by the device: value out of range; .*' \
    loaded -- gtusb set light 9 --direction 0,1,0 --irradiance 1,1,1
for c in info list stats "frame -o $work/x.png" "push $scene"; do
    [ "$c" = list ] || refused "wrong_protocol_version_for_${c%% *}" \
        "gtusb: ${c%% *}: the device speaks protocol version 4, this program version 3; update .*" \
        gtsim run --protocol-version 4 -- gtusb $c
done
check refusals_leave_no_output test ! -e "$work/x.png"
expect frame_into_a_missing_folder 3 '' "gtusb: frame: .*none/x.png.*" loaded -- gtusb frame -o "$work/none/x.png"
check frame_leaves_no_partial_file test -z "$(ls "$work" | grep tmp)"

# --- trouble in the middle of a push: the device keeps what it had and goes on rendering ---
before_and_after() { # claim expected_exit_code stderr gtsim_option value command: exit code of the push; frames before and after
    local claim=$1 code=$2 err=$3
    rm -f "$work"/[abc].png
    loaded "$4" "$5" -- bash -c '
        gtusb frame -o "$work/a.png" || exit 1
        '"$6"'
        echo "code $?"
        sleep 0.6
        gtusb info | grep "^1 " && gtusb frame -o "$work/b.png" && cmp "$work/a.png" "$work/b.png" &&
        gtusb push "$work/green.ktx2" --slot 1 && gtusb frame -o "$work/c.png" && ! cmp -s "$work/a.png" "$work/c.png"
    ' >"$work/out" 2>"$work/err"
    local got=$?
    [ $got = 0 ] && grep -qx "code $code" "$work/out" && [[ $(cat "$work/err") =~ ^($err)$ ]] &&
        grep -q "^1 *table *$bytes " "$work/out" && grep -q 'green.ktx2 to table slot 1' "$work/out"
    ok $? "$claim" "$work/out" "$work/err"
}
push='gtusb push "$work/green.ktx2" --slot 1'
before_and_after unplug_in_mid_push_keeps_the_table 8 'gtusb: push: USB: the device was unplugged; .*' \
    --unplug-after 30000 "$push"
check push_after_unplug_goes_on_where_it_stopped grep -q '^resumed after [0-9]* bytes of an earlier push' "$work/out"
expect info_tells_how_far_a_push_got 0 $'.*upload +[1-9][0-9]* of '"$bytes"$' bytes; push .*"received": [1-9].*' \
    'gtusb: push: USB: the device was unplugged; .*' loaded --unplug-after 30000 -- \
    bash -c 'gtusb push "$work/gold.ktx2" --slot 1; sleep 0.6; gtusb info && gtusb info --json'
loss_of_power() { # the device with its flash, cable pulled in mid-push; then another life of it
    cp "$work/flash" "$work/flash.cut" || return 1
    gtsim run $bank --flash "$work/flash.cut" --unplug-after 12000 -- gtusb push "$work/green.ktx2" --slot 1
    [ $? = 8 ] || return 1
    gtsim run $bank --flash "$work/flash.cut" -- bash -c 'gtusb info && gtusb push "$work/green.ktx2" --slot 1 &&
        gtusb verify "$work/green.ktx2" --slot 1' >"$work/cut.out" || return 1
    grep -q '^upload *[1-9][0-9]* of [0-9]* bytes; push' "$work/cut.out" && grep -q '^resumed after [1-9][0-9]* bytes' "$work/cut.out" &&
        grep -q '^green.ktx2 is in table slot 1' "$work/cut.out"
}
check push_goes_on_after_a_loss_of_power loss_of_power
before_and_after silent_device_times_out_and_keeps_the_table 8 'gtusb: push: USB: no answer within .* s; .*' \
    --freeze-after 30000 "$push --timeout 0.05"
before_and_after interrupt_with_a_silent_device 130 'gtusb: push: interrupted; the device keeps what it had' \
    --freeze-after 30000 "timeout --foreground --preserve-status -s INT 0.4 $push"
before_and_after kill_in_mid_push_keeps_the_table 137 '(.*[Kk]illed.*)?' \
    --freeze-after 30000 "timeout --foreground -s KILL 0.4 $push"
expect unplug_in_a_frame 8 '' 'gtusb: frame: USB: the device was unplugged; .*' \
    loaded --unplug-after 16 -- gtusb frame -o "$work/x.png"
check unplug_in_a_frame_leaves_no_output test ! -e "$work/x.png"
interrupted_push() { # Ctrl-C while data flows: 130, and the upload is dropped. When that is, is tried until it hits.
    local delay
    for delay in 0.02 0.03 0.04 0.05 0.06 0.07 0.08 0.10 0.12 0.15 0.2 0.3 0.4; do
        loaded -- bash -c 'timeout --foreground --preserve-status -s INT $0 gtusb push "$DEMO/six_models.blob" 2>"$work/int.err"
            [ $? = 130 ] && grep -q interrupted "$work/int.err" || exit 1
            gtusb push "$DEMO/six_models.blob" >"$work/int.out" && ! grep resumed "$work/int.out"' $delay && return
    done
    return 1
}
check interrupted_push_ends_with_130_and_drops_the_upload interrupted_push
interrupted_frame() { # Ctrl-C in the midst of a frame: 130 at once, no picture, and the device does not finish the frame
    local delay
    for delay in 0.05 0.1 0.2 0.3 0.5 0.8; do
        loaded --size 1400x1000 -- bash -c 'timeout --foreground --preserve-status -s INT $0 gtusb frame -o "$work/i.png" 2>"$work/int.err"
            [ $? = 130 ] && grep -q interrupted "$work/int.err" && [ ! -e "$work/i.png" ] || exit 1
            gtusb stats | grep "^frames 0,"' $delay && return
    done
    return 1
}
check interrupted_frame_ends_with_130_before_its_end interrupted_frame

echo 1..$n
