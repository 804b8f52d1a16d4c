#!/usr/bin/env bash
# gtsim window: a real window on a virtual screen, real key and mouse events, its pixels compared.
. tests/e2e/usb_common.sh

scene=$DEMO/six_models.blob
gtlut build "$DEMO/gold.csv" -o "$work/gold.ktx2" --size 46x23 || exit 1
tables=(); for s in 0 1 2 3 4 5; do tables+=(--table $s="$DEMO/gold.ktx2"); done
tables+=(--table 1="$DEMO/plastic_red.ktx2")
mkdir "$work/pictures"

for p in Xvfb xdotool node; do
    command -v $p >/dev/null || { skip window "$p is not installed"; echo 1..$n; exit; }
done

# --- usage: ends before there is a window ---
unset DISPLAY WAYLAND_DISPLAY
bad() { # claim code stderr arguments...
    local claim=$1 code=$2 err=$3
    shift 3
    expect "$claim" "$code" '' "$err" gtsim window "$@"
}
expect help_lists_the_keys 0 'Usage: gtsim window .*Keys:.*arrows +turn .*Examples:.*' '' gtsim window --help
bad unknown_option 2 'gtsim window: .*--unknown.*' --unknown
bad second_scene 2 "gtsim: window: 'b.blob': a second scene; .*" a.blob b.blob
bad zoom_out_of_range 2 "gtsim: window: --zoom: '0' is not .*" --zoom 0
bad table_without_slot 2 "gtsim: window: --table: 'a.ktx2' has no slot; .*" --table a.ktx2
bad no_device 2 'gtsim: window: --devices: 0, .*' --devices 0
bad model_without_scene 9 'gtsim: window: --model: the device has no scene; .*' --model blinn_phong
bad missing_scene 3 "gtsim: window: $work/none: No such file.*" "$work/none"
head -c 1000 "$scene" >"$work/short.blob"
bad truncated_scene 4 "gtsim: window: $work/short.blob: not a valid scene: .*" "$work/short.blob"
bad scene_as_table 4 "gtsim: window: $work/short.blob: not a valid table: .*" "$scene" --table 0="$work/short.blob"
bad missing_folder_of_pictures 3 "gtsim: window: $work/none: No such file.*; .*" --screenshot-dir "$work/none"
bad file_as_folder_of_frames 3 "gtsim: window: $work/short.blob: not a folder; .*" --record "$work/short.blob"
bad no_screen 5 '(error: XDG_RUNTIME_DIR .*)?gtsim: window: no screen; set DISPLAY.*' "$scene"

# --- a screen ---
Xvfb -displayfd 3 -fbdir "$work" -screen 0 1024x768x24 -nolisten tcp 3>"$work/display" 2>/dev/null &
screen=$!
trap 'kill $screen; wait $screen; rm -rf "$work"' EXIT
until [ -s "$work/display" ]; do sleep 0.02; done
export DISPLAY=:$(cat "$work/display")

# Starts a window whose program is a shell that reads commands from file descriptor 4.
window_open() { # arguments...
    rm -f "$work/commands" "$work/pictures"/*
    mkfifo "$work/commands"
    (cd "$work/pictures" && exec gtsim window "$@" -- bash) <"$work/commands" >"$work/out" 2>"$work/err" &
    pid=$!
    exec 4>"$work/commands"
    id=$(timeout 20 xdotool search --sync --onlyvisible --name '^gtsim \|' 2>/dev/null | tail -1)
    [ -n "$id" ] && xdotool windowfocus --sync "$id"
}
window_close() { # exit code of the shell, which is the window's
    echo "exit $1" >&4
    exec 4>&-
    wait $pid
    [ $? = "$1" ]
}
until_true() { # command...: within a minute
    local end=$((SECONDS + 60))
    until "$@"; do
        [ $SECONDS -lt $end ] || return 1
        sleep 0.02
    done
}
title() { # extended regular expression: what the title comes to be
    until_true bash -c '[[ $(xdotool getwindowname '"$id"') =~ $0 ]]' "$1" || { xdotool getwindowname "$id"; return 1; }
}
press() { xdotool key --delay 5 "$@"; }
picture() { # file: what the key p writes
    local old=("$work"/pictures/gtsim-*.png)
    [ -e "${old[0]}" ] || old=()
    local new
    printf -v new '%s/pictures/gtsim-%04d.png' "$work" $((${#old[@]} + 1))
    press p
    until_true test -e "$new" && cp "$new" "$work/$1.png"
}
inside() { # commands: run by the shell behind the window, with its exit code
    rm -f "$work/done"
    echo "$1; echo \$? >$work/done.new; mv $work/done.new $work/done" >&4
    until_true test -e "$work/done" && [ "$(cat "$work/done")" = 0 ]
}
on_screen() { # file zoom: every pixel of the window shows the picture
    local w=$((320 * $2)) h=$((240 * $2))
    node tests/e2e/read_image.mjs "$work/$1.png" 0,0,$(awk "BEGIN { printf \"%.9f\", 1 / $2 + 1e-6 }"),$w,$h >"$work/wanted" || return 1
    shown() {
        local X Y WIDTH HEIGHT
        eval "$(xdotool getwindowgeometry --shell "$id" | grep -E '^(X|Y|WIDTH|HEIGHT)=')"
        node tests/e2e/read_image.mjs "$work/Xvfb_screen0" $((X + (WIDTH - w) / 2)),$((Y + (HEIGHT - h) / 2)),1,$w,$h | cmp -s - "$work/wanted"
    }
    until_true shown
}
render() { gtsim render "$scene" "${tables[@]}" "$@"; }
same() { cmp "$work/$1.png" "$work/$2.png"; }
differ() { ! same "$1" "$2"; }

# --- the picture ---
render -o "$work/measured.png" && render -o "$work/lafortune.png" --model lafortune_phong &&
    render -o "$work/blinn.png" --model blinn_phong && render -o "$work/ggx.png" --model metallic_roughness || exit 1
check window_opens window_open "$scene" "${tables[@]}" --record "$work/frames"
check title_tells_the_state title '^gtsim \| 0 matte_white: measured, slot 0 \| exposure 1\.00 \| lights 1 2 3 \| [0-9.]+ M ticks, dearest tile [0-9.]+ M \| [0-9.]+ ms, [0-9]+ fps$'
check keys_are_printed grep -q 'drag, arrows' "$work/err"
as_rendered() { picture first && same first measured; }
check picture_is_renders as_rendered
check screen_shows_it_twice_as_large on_screen measured 2
resized() {
    xdotool windowmove "$id" 0 0 windowsize "$id" 1000 760 && on_screen measured 3 && xdotool windowsize "$id" 640 480 && on_screen measured 2
}
check larger_window_shows_it_three_times resized

# --- keys ---
shows() { # [key...] file
    local file=${*: -1}
    [ $# = 1 ] || press "${@:1:$#-1}"
    picture now && same now "$file"
}
check n_is_the_next_model shows n lafortune
check n_again_is_blinn_phong shows n blinn
check n_again_is_metallic_roughness shows n ggx
check n_comes_around_to_the_scenes shows n measured
check shift_n_goes_back shows N ggx
check r_forgets_it shows r measured
cat >"$work/set.sh" <<'EOF'
gtusb select 1 2 && gtusb frame -o "$work/selected.png" && gtusb reset &&
    gtusb set output --exposure 1.5874010520 --tone aces --background 21,23,26 && gtusb frame -o "$work/exposed.png" && gtusb reset
EOF
check host_agrees inside '. "$work/set.sh"'
material() { press m && title '^gtsim \| 1 plastic_red: measured, slot 1 ' && press t && title ' slot 2 ' && picture now && same now selected; }
check m_and_t_select_a_table material
table_back() { press T && title ' slot 1 ' && press M && title ' 0 matte_white:' && picture now && same now measured; }
check shift_goes_back table_back
exposure() { press e e && title 'exposure 1\.59' && picture now && same now exposed && press E E && title 'exposure 1\.00'; }
check e_exposes_longer exposure
light() { press 2 && title '\| lights 1 3 \|' && picture dark && differ dark measured && shows 2 measured && title '\| lights 1 2 3 \|'; }
check digits_switch_lights light
all_dark() { press 1 2 3 9 && title '\| lights off \|' && shows 3 2 1 measured; }
check all_lights_may_be_off all_dark
turned() { press l && picture turned && differ turned measured && shows L measured; }
check l_turns_the_lights turned
arrows() { for k in Left Up Prior; do press r $k && picture $k && differ $k measured || return 1; done && differ Left Up && differ Up Prior; }
check arrows_move_the_eye arrows
pixels() { node tests/e2e/read_image.mjs "$work/$1.png" 0,0,1,320,240 >"$work/$1.txt"; }
whole_turn() { # but for rounding: the mean of all differences
    press r $(yes Right | head -72) && picture turn && pixels turn && pixels measured && differ turn measured &&
        paste "$work/turn.txt" "$work/measured.txt" | awk '{ for (i = 1; i < 4; i++) d += ($i - $(i + 3)) ^ 2 }
            END { print "mean square", d / NR / 3; exit d / NR / 3 > 1 }'
}
check whole_turn_comes_back whole_turn
pole() { press r $(yes Up | head -40) && picture top && differ top measured && shows Up top; }
check eye_stops_at_the_pole pole
drag() {
    press r && xdotool mousemove --window "$id" 300 200 mousedown 1 mousemove_relative 60 20 mouseup 1 && sleep 0.1 &&
        picture dragged && differ dragged measured && xdotool mousemove_relative 50 50 && sleep 0.1 && shows dragged
}
check mouse_drags_the_eye drag
wheel() { press r Prior && picture near && press r && xdotool click 4 && sleep 0.1 && shows near; }
check wheel_moves_nearer wheel

# --- cost of tiles ---
tile_pixel() { # tile: middle of it on the screen, "R G B"
    local X Y
    eval "$(xdotool getwindowgeometry --shell "$id" | grep -E '^[XY]=')"
    node tests/e2e/read_image.mjs "$work/Xvfb_screen0" $((X + $1 % 5 * 128 + 34)),$((Y + $1 / 5 * 64 + 16))
}
costs() {
    press r && picture plain && on_screen plain 2 && press c && title '\| ticks, bright is ' && shows plain || return 1
    inside 'gtusb stats --json --tiles >"$work/stats.json"' || return 1
    read -r dear cheap < <(node -e "const t = JSON.parse(require('fs').readFileSync('$work/stats.json')).tiles.map(t => t.ticks);
        console.log(t.indexOf(Math.max(...t)), t.indexOf(Math.min(...t)))")
    coloured() { read -r r g b < <(tile_pixel $dear); read -r r2 g2 b2 < <(tile_pixel $cheap); [ $r -gt 160 ] && [ $b2 -gt $r2 ] && [ $r2 -lt 60 ]; }
    until_true coloured || { echo "tile $dear: $r $g $b, tile $cheap: $r2 $g2 $b2"; return 1; }
    press c && title 'rate of shading' && press c && title 'predicted error' && press c && title 'fps$' && on_screen plain 2
}
check c_colours_tiles_by_what_they_took costs
budget() { # what b sets is what the host reads, down to the least; B takes it back
    press r b && title ', budget 0\.[0-9]+ M: [1-9][0-9]* of 40 tiles reduced' && picture reduced && differ reduced plain || return 1
    inside 'gtusb stats --json >"$work/stats.json"' || return 1
    local set=$(node -p "(JSON.parse(require('fs').readFileSync('$work/stats.json')).budget.tile / 1e6).toFixed(3)")
    title "budget ${set/./[.]} M" && press $(yes b | head -20) && picture least && title ' of 40 tiles reduced' || return 1
    xdotool getwindowname "$id" >"$work/least" && press b && picture again && [ "$(grep -o 'budget [0-9.]*' "$work/least")" = "$(xdotool getwindowname "$id" | grep -o 'budget [0-9.]*')" ] &&
        press $(yes B | head -20) && title 'M ticks, dearest tile [0-9.]+ M \|' && shows plain
}
check b_sets_a_budget budget
rate() { # every tile with a surface is at the rate that s asks for; a budget set meanwhile counts
    press r s s s && title ', all surfaces at rate 4x2 \|' && picture coarse && differ coarse plain && inside 'gtusb frame -o "$work/usb.png" && gtusb stats --json --tiles >"$work/stats.json"' &&
        same usb coarse || return 1
    node -e "const t = JSON.parse(require('fs').readFileSync('$work/stats.json')).tiles.filter(t => t.covered);
        process.exit(t.length < 20 || t.some(t => t.rate !== 3) ? 1 : 0)" || { head -c 600 "$work/stats.json"; return 1; }
    press s s s s && title 'rate flat' && picture flat && differ flat coarse && press S S && shows coarse && press b && title 'budget [0-9.]+ M: ' && press s && title 'rate 2x1' && press S && shows plain
}
check s_shades_all_surfaces_at_one_rate rate

# --- the program's side ---
live_push() { # while the window goes on
    render --table 0="$work/gold.ktx2" -o "$work/pushed.png" && inside 'gtusb push "$work/gold.ktx2" --slot 0' &&
        picture now && same now pushed && differ now measured && on_screen pushed 2
}
check pushed_table_appears live_push
live_set() { inside 'gtusb set camera --eye 0,2,9 --target 0,0.5,0 --fov 35 --near 0.1; gtusb frame -o "$work/moved.png"' && picture now && same now moved; }
check camera_set_over_usb_appears live_set
goes_on() { press Right && picture right && differ right moved && inside 'gtusb frame -o "$work/usb.png"' && same usb right; }
check keys_go_on_from_there_and_usb_sees_it goes_on
scene_push() {
    inside 'gtusb push "$DEMO/points.blob"' && title '^gtsim \| 0 ' && picture points &&
        inside 'gtusb frame -o "$work/usb.png"' && same usb points && differ usb right
}
check pushed_scene_appears scene_push
check exit_code_is_the_programs window_close 7

# --- recording ---
recorded() { # the first frame, and one for each change
    rm -rf "$work/frames"
    window_open "$scene" "${tables[@]}" --record "$work/frames" && shows measured && shows m measured && shows n lafortune &&
        shows n blinn && press c && shows r measured && window_close 0 || return 1
    [ "$(ls "$work/frames" | tr '\n' ' ')" = 'frame-000001.png frame-000002.png frame-000003.png frame-000004.png ' ] &&
        cmp "$work/frames/frame-000001.png" "$work/measured.png" && cmp "$work/frames/frame-000003.png" "$work/blinn.png"
}
check each_new_frame_is_recorded recorded

# --- what is not there ---
empty() {
    window_open && title '^gtsim \| no scene \| the device has no scene; ' && press n e l 1 m t Right Prior &&
        inside 'gtusb push "$DEMO/six_models.blob"' && title 'slot 0 \| .* the table slot of material 0 is empty; give ' &&
        shows n lafortune && title 'lafortune_phong \| .* fps$' && window_close 0 &&
        [ "$(grep -c '^gtsim: window: the device has no scene' "$work/err")" = 1 ] &&
        [ "$(grep -c '^gtsim: window: the table slot of material 0 is empty' "$work/err")" = 1 ]
}
check empty_device_waits_for_a_scene empty

# --- other boards; a program that dies; other ends ---
budgeted() {
    local least=$(render --budget 1 -o "$work/none.png" 2>&1 | grep -oE 'needs [0-9]+' | cut -d ' ' -f 2)
    render --budget $((least * 9 / 8)) -o "$work/budget.png" && differ budget measured && window_open "$scene" "${tables[@]}" --budget $((least * 9 / 8)) &&
        title 'budget 0\.[0-9]+ M: [1-9]' && shows budget && window_close 0
}
check budget_of_the_board_is_renders budgeted
smooth() {
    gtsim render "$scene" "${tables[@]}" --size 101x67 --samples 4 --format rgb565 -o "$work/smooth.png" &&
        window_open "$scene" "${tables[@]}" --size 101x67 --samples 4 --format rgb565 --zoom 3 --full-speed &&
        [ "$(xdotool getwindowgeometry "$id" | grep -c ' 303x201')" = 1 ] && press c && shows smooth
}
check board_of_another_size_format_and_samples smooth
check it_ends_too window_close 0
dies() { # killed with requests under way: a second later the window goes on
    window_open "$scene" "${tables[@]}" --freeze-after 30000 && shows measured &&
        inside 'timeout -s KILL 0.4 gtusb push "$DEMO/six_models.blob"; [ $? = 137 ]' && shows n lafortune
}
check program_that_dies_does_not_stop_the_window dies
closed() { # q ends the program, too
    inside 'echo $$ >"$work/shell"' && press q && wait $pid
    [ $? = 0 ] && exec 4>&- && ! kill -0 "$(cat "$work/shell")" 2>/dev/null
}
check q_closes_and_ends_the_program closed
alone() { # signal exit_code: a window without program
    gtsim window "$scene" "${tables[@]}" 2>/dev/null &
    pid=$!
    xdotool search --sync --onlyvisible --name '^gtsim \|' >/dev/null
    kill -$1 $pid
    wait $pid
    [ $? = $2 ]
}
check interrupt_ends_a_window_without_program alone TERM 143

echo 1..$n
