#!/usr/bin/env bash
# gtsim: pictures without USB, and programs run with the simulated device on their USB.
. tests/e2e/usb_common.sh

scene=$DEMO/six_models.blob
gtlut build "$DEMO/gold.csv" -o "$work/gold.ktx2" --size 91x46 || exit 1
tables=(); for s in 0 1 2 3 4 5; do tables+=(--table $s="$work/gold.ktx2"); done

# --- usage ---
expect help_goes_to_stdout 0 'Usage: gtsim COMMAND.*run.*render.*' '' gtsim --help
expect version_is_printed 0 'gtsim [0-9]+\.[0-9]+\.[0-9]+' '' gtsim --version
expect no_command_is_a_usage_error 2 '' 'Usage: gtsim COMMAND.*' gtsim
expect unknown_command_is_a_usage_error 2 '' "gtsim: no command 'fly'; see .*" gtsim fly
for c in run render; do
    expect "help_of_$c" 0 "Usage: gtsim $c.*" '' gtsim $c --help
    expect "version_of_$c" 0 'gtsim [0-9.]+' '' gtsim $c --version
    expect "unknown_option_of_$c" 2 '' "gtsim $c: .*--unknown.*" gtsim $c --unknown
    expect "size_without_x_for_$c" 2 '' "gtsim: $c: --size: '320' is not a size; .*" gtsim $c --size 320
    expect "width_out_of_range_for_$c" 2 '' "gtsim: $c: --size WIDTH: '4097' is not .*" gtsim $c --size 4097x10
    expect "height_out_of_range_for_$c" 2 '' "gtsim: $c: --size HEIGHT: '0' is not .*" gtsim $c --size 10x0
    expect "unknown_format_for_$c" 2 '' "gtsim: $c: --format: no format 'png'; .*" gtsim $c --format png
done
usage() { # claim stderr arguments...
    local claim=$1 err=$2
    shift 2
    expect "$claim" 2 '' "$err" gtsim "$@"
}
usage render_without_scene 'gtsim: render: a scene and -o FILE.png are needed; .*' render -o "$work/x.png"
usage render_without_output 'gtsim: render: a scene and -o FILE.png are needed; .*' render "$scene"
usage render_two_scenes 'Usage: gtsim render.*' render "$scene" "$scene" -o "$work/x.png"
usage table_without_slot "gtsim: render: --table: 'a.ktx2' has no slot; .*" render "$scene" --table a.ktx2
usage table_slot_out_of_range "gtsim: render: --table SLOT: '16' is not .*" render "$scene" --table 16=a.ktx2
usage unknown_model "gtsim: render: --model: no model 'ggx'; .*" render "$scene" --model ggx
usage render_on_no_thread "gtsim: render: --threads: '0' is not .*" render "$scene" --threads 0
usage render_on_too_many_threads "gtsim: render: --threads: '65' is not .*" render "$scene" --threads 65
usage shuffle_needs_a_number "gtsim: render: --shuffle: 'x' is not .*" render "$scene" --shuffle x
usage run_without_program 'gtsim: run: no program to run; .*' run
usage run_too_many_devices "gtsim: run: --devices: '3' is not .*" run --devices 3 -- true
usage run_flash_of_two_devices 'gtsim: run: --flash is for one device, --devices is 2' \
    run --devices 2 --flash "$work/f" -- true
usage run_empty_serial "gtsim: run: --serial: '' is not 1 to 31 printable ASCII characters" run --serial '' -- true
usage run_long_serial "gtsim: run: --serial: .* is not 1 to 31 .*" run --serial "$(printf 'x%.0s' {1..32})" -- true
usage run_foreign_serial "gtsim: run: --serial: .* is not 1 to 31 .*" run --serial 'é' -- true
usage run_long_serial_of_two "gtsim: run: --serial: .* is not 1 to 29 .*" run --devices 2 --serial "$(printf 'x%.0s' {1..30})" -- true
expect run_longest_serial 0 '.* x{31}' '' gtsim run --serial "$(printf 'x%.0s' {1..31})" -- gtusb list
usage run_octal_is_decimal "gtsim: run: --devices: '010' is not .*" run --devices 010 -- true
usage run_unplug_negative "gtsim: run: --unplug-after: '-1' is not .*" run --unplug-after -1 -- true
usage run_bank_out_of_range "gtsim: run: --bank: '1' is not .*" run --bank 1 -- true

# --- render ---
expect render_is_silent 0 '' '' gtsim render "$scene" "${tables[@]}" -o "$work/a.png"
expect render_prints_what_it_cost 0 'tiles 40, .*triangles [1-9].*' '' \
    gtsim render "$scene" "${tables[@]}" -o "$work/b.png" --stats
expect threads_print_what_the_frame_cost 0 'tiles 40, .*frame hash [0-9a-f]{8}, threads 3, [0-9.]+ ms' '' \
    gtsim render "$scene" "${tables[@]}" -o "$work/t.png" --stats --threads 3 --shuffle 5
check threads_render_the_same cmp "$work/a.png" "$work/t.png"
check render_repeats cmp "$work/a.png" "$work/b.png"
expect lafortune_needs_no_table 0 '' '' gtsim render "$scene" --model lafortune_phong -o "$work/l.png"
check models_differ bash -c '! cmp "$work/a.png" "$work/l.png"'
expect render_odd_size 0 '' '' gtsim render "$scene" --model lafortune_phong --size 33x17 -o "$work/odd.png"
png_size() { # the IHDR chunk says 33 x 17
    [ "$(od -An -tx1 -j16 -N8 "$work/odd.png" | tr -d ' ')" = 0000002100000011 ]
}
check picture_has_that_size png_size
bad() { # claim code stderr arguments...: and no output file
    local claim=$1 code=$2 err=$3
    shift 3
    expect "$claim" "$code" '' "$err" gtsim render "$@" -o "$work/bad.png"
}
: >"$work/empty"
head -c 1000 "$scene" >"$work/short.blob"
head -c 1000 "$work/gold.ktx2" >"$work/short.ktx2"
bad missing_scene 3 "gtsim: render: $work/none: No such file.*; .*" "$work/none"
bad empty_scene 4 "gtsim: render: $work/empty: empty; .*" "$work/empty"
bad truncated_scene 4 "gtsim: render: $work/short.blob: not a valid scene: .*; .*" "$work/short.blob"
bad table_as_scene 4 "gtsim: render: $work/gold.ktx2: not a valid scene: .*; .*" "$work/gold.ktx2"
bad missing_table 3 "gtsim: render: $work/none: No such file.*; .*" "$scene" --table 0="$work/none"
bad truncated_table 4 "gtsim: render: $work/short.ktx2: not a valid table: .*; .*" "$scene" --table 0="$work/short.ktx2"
head -c 4096 "$scene" >"$work/part.blob" # as long as a table may be
bad scene_as_table 4 "gtsim: render: $work/part.blob: not a valid table: .*; .*" "$scene" --table 0="$work/part.blob"
bad empty_table_slot 9 "gtsim: render: $scene: the table slot of material 0 is empty; .*" "$scene"
bad empty_table_slot_on_threads 9 "gtsim: render: $scene: the table slot of material 0 is empty; .*" "$scene" --threads 2
check nothing_is_written_on_failure bash -c '! ls "$work" | grep -E "bad|tmp"'
expect output_in_a_missing_folder 3 '' "gtsim: render: .*none/x.png.*" \
    gtsim render "$scene" --model lafortune_phong -o "$work/none/x.png"

# --- run ---
expect exit_code_is_the_programs 42 'out' 'err' gtsim run -- sh -c 'echo out; echo err >&2; exit 42'
expect killed_program_is_128_plus_signal 137 '' '' gtsim run -- sh -c 'kill -KILL $$'
expect dashes_may_be_left_out 0 'gtusb [0-9.]+' '' gtsim run gtusb --version
expect program_that_is_not_there 3 '' 'gtsim: run: .*nonesuch.*; is it on the PATH\?' gtsim run -- nonesuch
expect stdin_reaches_the_program 0 'hello' '' bash -c 'echo hello | gtsim run -- cat'
expect only_the_simulated_bus_is_seen 0 $'1-1\n1-2\nusb1' '' gtsim run --devices 2 -- ls /sys/bus/usb/devices
expect no_device_no_node 0 'usb1' '' gtsim run --devices 0 -- ls /sys/bus/usb/devices
expect descriptors_are_the_firmwares 0 '120101020000004009120100.*09022000.*' '' \
    gtsim run -- sh -c 'od -An -v -tx1 /sys/bus/usb/devices/1-1/descriptors | tr -d " \n"'
check full_speed_is_seen_in_sysfs bash -c '[ "$(gtsim run --full-speed -- cat /sys/bus/usb/devices/1-1/speed)" = 12 ]'
termination() { # SIGTERM to gtsim ends the program first
    gtsim run -- sh -c 'trap "echo ended; exit 7" TERM; echo up; while :; do sleep 0.05; done' >"$work/term" &
    local pid=$! i
    for i in $(seq 100); do grep -q up "$work/term" && break; sleep 0.05; done
    kill -TERM $pid
    wait $pid
    [ $? = 7 ] && grep -q ended "$work/term"
}
check termination_is_passed_on termination
flash_keeps() {
    gtsim run --flash "$work/flash" -- gtusb push "$scene" &&
        gtsim run --flash "$work/flash" -- gtusb info | grep -q '^scene *6 objects'
}
check flash_file_keeps_the_scene flash_keeps
hang_up() { # a terminal that is closed
    local pid i
    gtsim run --flash "$work/hung" -- sh -c "gtusb push '$scene' && echo pushed && exec sleep 20" >"$work/hang" &
    pid=$!
    for i in $(seq 200); do grep -q pushed "$work/hang" && break; sleep 0.05; done
    kill -HUP $pid
    wait $pid
    [ $? = 129 ] && gtsim run --flash "$work/hung" -- gtusb info | grep -q '^scene *6 objects'
}
check flash_file_is_written_on_a_hang_up hang_up
one_at_a_time() {
    local pid i
    gtsim run --flash "$work/flash" -- sh -c 'echo up; exec sleep 20' >"$work/first" &
    pid=$!
    for i in $(seq 100); do grep -q up "$work/first" && break; sleep 0.05; done
    gtsim run --flash "$work/flash" -- true 2>"$work/err"
    i=$?
    kill $pid
    wait $pid
    [ $i = 3 ] && grep -q 'in use by another gtsim' "$work/err" && gtsim run --flash "$work/flash" -- true && [ ! -e "$work/flash.lock" ]
}
check flash_file_is_one_devices one_at_a_time
mkdir "$work/folder"
expect flash_file_that_is_a_folder 3 '' "gtsim: run: $work/folder: .*; give another" gtsim run --flash "$work/folder" -- true
head -c 1000 /dev/zero >"$work/wrong"
expect flash_file_of_another_size 4 '' "gtsim: run: $work/wrong: 1000 bytes where this device's flash has [0-9]+: .*; give another" \
    gtsim run --flash "$work/wrong" -- true
check flash_file_of_another_size_is_untouched bash -c '[ "$(stat -c %s "$work/wrong")" = 1000 ]'
replug() { # unplugged for a moment: gone from the bus, then back
    gtsim run --unplug-after 16 -- sh -c 'gtusb info; gtusb list; sleep 0.6; gtusb list' >"$work/out" 2>"$work/err"
    [ $? = 0 ] && [ "$(wc -l <"$work/out")" = 1 ] && grep -q 'was unplugged' "$work/err" && grep -q 'no device' "$work/err"
}
check unplugged_device_disappears_and_comes_back replug
nothing_left() { # the mocked /sys and /dev are removed
    local dir
    dir=$(gtsim run -- sh -c 'echo $UMOCKDEV_DIR') && [ -n "$dir" ] && [ ! -e "$dir" ]
}
check scratch_folder_is_removed nothing_left

echo 1..$n
