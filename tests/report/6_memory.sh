#!/usr/bin/env bash
# What a material's memory buys: error of every representation from 1 MB to 1 KB, and of three fitted models.
. tests/report/common.sh
materials >"$work/all"
[ -z "$QUICK" ] || { sed -n 1p "$work/all" >"$work/one"; mv "$work/one" "$work/all"; }

one() { # name source
    # As the instrument of the paper sees it: theta_in 0, 20, 40, 60, theta_out up to 75 degrees.
    quietly "$B/gtlut" import "$2" --geometry minidiff -o "$work/$1.gtm"
    quietly "$B/report_memory" "$2" "$work/$1.gtm" ${QUICK:+quick} >"$work/$1.errors"
    sed "s/^/$1,/" "$work/$1.errors" >"$work/$1.rows"
    rm "$work/$1.gtm"
}
each one <"$work/all"
csv=$OUT/6_memory.csv
{
    echo 'material,representation,size,bytes,de_mean,de_p99,psnr'
    while read -r name _; do cat "$work/$name.rows"; done <"$work/all"
} >"$csv"
# Over the materials. Bytes: the mean, as a half-vector table takes no more than it was given.
summary() { # regex of materials
    awk -F, -v OFS=, -v re="$1" 'NR > 1 && $1 ~ re { print $2 " " $3, $4, $5 }' "$csv" | sort -t, -k1,1 -k3,3g | awk -F, '
        function out() { if (n) { split(name, f, " "); printf "%s,%s,%d,%.4f,%.4f,%.4f,%.4f\n", f[1], f[2], bytes / n, sum / n, v[int((n + 1) / 2)], v[int(0.9 * n + 0.999)], v[n] } }
        $1 != name { out(); name = $1; n = sum = bytes = 0 } { v[++n] = $3; sum += $3; bytes += $2 } END { out() }' | sort -t, -k1,1 -k3,3gr
}
{ echo 'representation,size,bytes,de_mean,de_median,de_p90,de_worst'; summary .; } >"$OUT/6_summary.csv"
plot 6_memory 980x440 <<GNUPLOT
set multiplot layout 1,2
set logscale xy; set xrange [32:2e6]; set xlabel 'bytes per material'; set ylabel 'mean dE (CIE 1976) of pictures of a sphere'
set xtics ('32' 32, '256' 256, '1 K' 1024, '4 K' 4096, '16 K' 16384, '64 K' 65536, '256 K' 262144, '1 M' 1048576)
set format y '%g'; set yrange [0.003:100]; set key top right noreverse Right font ',11'
csv = '$OUT/6_summary.csv'
array name[6] = ['half-vector', 'specular frame', 'specular frame with swap', 'Lafortune-Phong', 'Blinn-Phong', 'GGX']
array style[6] = [7, 5, 4, 8, 10, 6]
array colour[6] = [0x08306b, 0xd68910, 0x8a5a00, 0x1e8449, 0xc0392b, 0x7d3c98]
kinds = 'half_vector specular_frame specular_frame_swap lafortune_phong blinn_phong ggx'
do for [k = 0:1] {
    set title (k ? '90th percentile of the materials' : 'median of the materials')
    c = 5 + k
    plot for [i = 1:6] csv skip 1 using (strcol(1) eq word(kinds, i) ? \$3 : NaN):c with linespoints lw 2 pt style[i] ps 0.9 lc rgb colour[i] title name[i]
}
GNUPLOT
count=$(wc -l <"$work/all")
cat <<MARKDOWN

## 6. Memory against error

$count materials $([ -n "$DATA" ] && echo 'of the data folder (EPFL RGL measurements, fits to MERL)' || echo 'of the demo (there is no data folder)'), each in tables from 1 MB down to 1 KB, and as fitted models. Error: mean colour
difference (CIE 1976) on three pictures of a sphere under one light each, in double precision from the texels, against the source's reciprocal part. Half-vector tables are fitted to the
source itself; specular frames and models see what the paper's instrument does, θ_in 0, 20, 40 and 60 degrees and θ_out up to 75, and extrapolate the rest;
"swap" exchanges light and viewer where that is nearer to what was measured.

$(awk -F, -v OFS=, 'BEGIN { name["half_vector"] = "half-vector"; name["specular_frame"] = "specular frame"; name["specular_frame_swap"] = "specular frame, swap"
        name["lafortune_phong"] = "Lafortune-Phong"; name["blinn_phong"] = "Blinn-Phong"; name["ggx"] = "GGX" }
    NR == 1 { print "representation,size,bytes,mean of the materials,median,90th percentile,worst"; next } { $1 = name[$1]; gsub(", ", " with ", $1); print }' "$OUT/6_summary.csv" | markdown_table)

$(awk -F, '$2 == "1K" { small = $4 } $2 == "361x181" { frame = $4 < frame || !frame ? $4 : frame } $2 == "fit" { fit = $4 < fit || !fit ? $4 : fit }
    END { printf "On average a half-vector table of 1 KB errs %.2f", small; if (frame) printf ", the better of the specular frames of 1 MB %.2f", frame; printf ", the best of the models %.2f.", fit }' "$OUT/6_summary.csv")

![memory against error](6_memory.svg)

Cezner and Havran 2024 give one point, "around 1 MB of VRAM (361 · 181 · 4 pixels in RGB9_E5 format)", without an error: the specular frame 361x181 above.

Numbers: [6_memory.csv](6_memory.csv) for every material, [6_summary.csv](6_summary.csv).
MARKDOWN
