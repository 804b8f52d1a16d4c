#!/usr/bin/env bash
# James 2022, 3.4: 100 point lights, the cost of a frame against the number of triangles.
. tests/report/common.sh
size=1280x720 counts=(1 4 16 64) repeats=3
[ -z "$QUICK" ] || { size=64x48; counts=(1 4); repeats=1; }
models=(blinn_phong ggx measured)
declare -A material=(
    [blinn_phong]='"model": "blinn_phong", "kd": [0.10, 0.06, 0.015], "ks": [0.85, 0.64, 0.28], "exponent": 24'
    [ggx]='"model": "metallic_roughness", "base_color": [1, 0.77, 0.34], "metalness": 1, "roughness": 0.3'
    [measured]='"model": "measured", "slot": 0'
)
# N fixtures (gear wheels) side by side fill the picture; the lights hover before all of them.
objects() { # count
    awk -v n="$1" 'BEGIN { side = int(sqrt(n) + 0.5); s = 6 / side
        for (i = 0; i < n; i++) printf "%s{\"mesh\": \"fixture\", \"material\": \"gold\", \"position\": [%g, %g, 0], \"rotation\": [%d, %d, 0], \"scale\": %g}",
            i ? ",\n" : "", s * (i % side - (side - 1) / 2) * 16 / 9, s * (int(i / side) - (side - 1) / 2), i * 37 % 60 - 30, i * 71 % 60 - 30, s * 0.5 }'
}
lights() {
    awk 'BEGIN { for (i = 0; i < 100; i++) printf "%s{\"type\": \"point\", \"position\": [%g, %g, 1.5], \"power\": [%d, %d, %d], \"radius\": 2}",
        i ? ",\n" : "", 11 * ((i % 10) / 9 - 0.5), 6.4 * (int(i / 10) / 9 - 0.5), 8 + i % 3 * 6, 14, 20 - i % 3 * 6 }'
}
field() { # name, of a board's line or of the statistics on stdin
    awk -v name="$1" '{ gsub(",", ""); for (i = 1; i < NF; i++) if ($i == name) print $(i + 1) }'
}
board() { # model count
    "$B/board/make_image" "$work/$1.img" 256 264 "$work/$1.blob" "$B/demo/gold.ktx2" >&2
    LIMIT=300 tests/board/run.sh cortex-m7 "$B/board/cortex-m7/firmware.elf" "$work/$1.img" >"$work/$2.$1.board" || { cat "$work/$2.$1.board" >&2; return 1; }
}
csv=$OUT/5_complexity.csv
echo 'triangles,set_up,ms_blinn_phong,ms_ggx,ms_measured,m7_blinn_phong,m7_ggx,m7_measured' >"$csv"
for n in "${counts[@]}"; do
    ms= m7=
    for model in "${models[@]}"; do
        scene "$model" <<JSON
{"meshes": [{"name": "fixture", "shape": "gear"}], "materials": [{"name": "gold", ${material[$model]}}],
 "objects": [$(objects "$n")],
 "lights": [$(lights)],
 "camera": {"eye": [0, 0, 12], "target": [0, 0, 0], "fov_y": 30, "near": 0.5},
 "output": {"exposure": 1, "tone_curve": "aces", "background": "#15171a"}}
JSON
    done
    # In turn, so that all meet the machine alike.
    for ((i = 0; i < repeats; i++)); do
        for model in "${models[@]}"; do
            picture=$work/frame.png
            [ $i != 0 ] || picture=$OUT/5_${model}_$n.png
            "$B/gtsim" render "$work/$model.blob" --table "0=$B/demo/gold.ktx2" --size $size --stats -o "$picture" >"$work/stats"
            awk '/^frame hash/ { print $(NF - 1) }' "$work/stats" >>"$work/$n.$model.ms"
            drawn=$(head -2 "$work/stats" | field triangles)
        done
    done
    [ -n "$QUICK" ] || printf '%s\n' "${models[@]/%/ $n}" | each board
    for model in "${models[@]}"; do
        ms+=,$(sort -g "$work/$n.$model.ms" | head -1)
        m7+=,$([ -n "$QUICK" ] || field instructions <"$work/$n.$model.board" | awk '{ printf "%.1f", $1 / 1e6 }')
    done
    echo "$("$B/gtscene" info "$work/measured.blob" | awk '$1 == "drawn" { print $2 }'),$drawn$ms$m7" >>"$csv"
done
plot 5_complexity 900x400 <<GNUPLOT
set multiplot layout 1,2
set logscale x; set xrange [3000:500000]; set yrange [0:*]
set xlabel 'triangles in the scene'; set key bottom right
csv = '$csv'
set title 'x86-64, one thread, $size'; set ylabel 'frame, ms'
plot csv skip 1 using 1:3 with linespoints lw 2 pt 7 lc rgb '#c0392b' title 'Blinn-Phong', '' skip 1 using 1:4 with linespoints lw 2 pt 9 lc rgb '#2471a3' title 'GGX', \
     '' skip 1 using 1:5 with linespoints lw 2 pt 5 lc rgb '#1e8449' title 'measured'
$([ -n "$QUICK" ] || cat <<'BOARD'
set title 'Cortex-M7 (QEMU), 320x240'; set ylabel 'frame, million instructions'
plot csv skip 1 using 1:6 with linespoints lw 2 pt 7 lc rgb '#c0392b' title 'Blinn-Phong', '' skip 1 using 1:7 with linespoints lw 2 pt 9 lc rgb '#2471a3' title 'GGX', \
     '' skip 1 using 1:8 with linespoints lw 2 pt 5 lc rgb '#1e8449' title 'measured'
BOARD
)
GNUPLOT
last=${counts[-1]}
cat <<MARKDOWN

## 5. Scene complexity

100 point lights before ${counts[0]} to $last fixtures of $(sed -n '2s/,.*//p' "$csv") triangles in rows and columns, the smaller the more there are (James 2022, section 3.4; its fixture is not published, ours is a gear wheel).
"Set up" are the triangles of the levels of detail that the frame chose, counted once for every tile that they touch. What costs is light on pixels:
a large fixture reaches up to more lamps than a small one: in instructions, frames with more triangles are the cheaper ones. Milliseconds: the fastest of $repeats frames on one thread of this machine.

$(awk -F, 'NR == 1 { print "triangles,set up,Blinn-Phong: ms,GGX: ms,measured: ms,Blinn-Phong: M7 million instructions,GGX: M7,measured: M7"; next } { print }' "$csv" | markdown_table)

![cost of a frame against triangles](5_complexity.svg)

| Blinn-Phong | GGX | measured |
|---|---|---|
$(for n in "${counts[0]}" "$last"; do echo "|$(for model in "${models[@]}"; do cell "5_${model}_$n.png" 300; done)"; done)

In the paper, figure 3.4, both models "reported average FPS values that were well above the real-time minimum of 30FPS to 60FPS" in three scenes with 100 lights at
1280 x 720 on an Nvidia RTX 3070; the text gives no numbers.

Numbers: [5_complexity.csv](5_complexity.csv).
MARKDOWN
