#!/usr/bin/env bash
# Cezner and Havran 2024, figures 6 and 3: interpolation between slices, extrapolation beyond the measured angles.
. tests/report/common.sh
: >"$work/errors"
angles=(5 10 15 25 30 35 45 50 55)
[ -z "$QUICK" ] || angles=(30)
for angle in "${angles[@]}"; do
    "$B/report_lobes" interpolation "$angle" >"$work/lobe_$angle.csv" 2>>"$work/errors"
done
cp "$work/lobe_30.csv" "$OUT/2_interpolation.csv"
plot 2_interpolation 900x400 <<GNUPLOT
set multiplot layout 1,2
x(t, f) = f * sin(t * pi / 180)
y(t, f) = f * cos(t * pi / 180)
set size ratio -1
set xrange [-0.15:1.4]; set yrange [0:1.1]; set key bottom right
set xlabel 'value times sin θ_{out}'; set ylabel 'value times cos θ_{out}'
csv = '$OUT/2_interpolation.csv'
do for [k = 0:1] {
    set title (k ? 'fixed outgoing direction, θ_{in} = 30°' : 'specular frame (this project), θ_{in} = 30°')
    plot csv skip 1 using (x(\$1,\$5)):(y(\$1,\$5)) with lines lw 1.5 lc rgb '#2471a3' title 'slice 20°', \
         '' skip 1 using (x(\$1,\$6)):(y(\$1,\$6)) with lines lw 1.5 lc rgb '#1e8449' title 'slice 40°', \
         '' skip 1 using (x(\$1,\$2)):(y(\$1,\$2)) with lines lw 4 lc rgb '#cccccc' title 'true lobe', \
         '' skip 1 using (x(\$1,column(3+k))):(y(\$1,column(3+k))) with lines lw 2 dt 2 lc rgb '#c0392b' title 'interpolated'
}
GNUPLOT
{ echo 'theta_in,specular_frame,fixed_direction'; cat "$work/errors"; } >"$OUT/2_errors.csv"

# Truth for the extrapolated part: the same material as an instrument would see it that goes to 88 degrees.
"$B/gtlut" measure gold -o "$work/dense.csv" --geometry dense 
awk -F, '$1 == 40 && $3 == 180 { print $2 "," $5 }' "$work/dense.csv" >"$work/truth.csv"
for p in 1 0.5 0.2 0; do
    "$B/report_lobes" extrapolation "$B/demo/gold.csv" $p 0.3 >"$work/p_$p.csv"
done
for l in 0 0.3 0.7 1; do
    "$B/report_lobes" bezier $l >"$work/b_$l.csv"
done
{ echo 'theta,p_1,p_0.5,p_0.2,p_0'; paste -d, "$work"/p_{1,0.5,0.2,0}.csv | tail -n +2 | cut -d, -f1,2,4,6,8; } >"$OUT/2_extrapolation.csv"
{ echo 'x,l_0,l_0.3,l_0.7,l_1'; paste -d, "$work"/b_{0,0.3,0.7,1}.csv | tail -n +2 | cut -d, -f1,2,4,6,8; } >"$OUT/2_bezier.csv"
plot 2_extrapolation 900x400 <<GNUPLOT
set multiplot layout 1,2
set title 'extrapolated values, l = 0.3'
set xlabel 'θ_{out}, degrees (φ_{out} = 180°, θ_{in} = 40°)'; set ylabel 'BRDF (green), 1/sr'
set xrange [50:90]; set yrange [0:*]; set key top right noreverse Right
set arrow 1 from 75, graph 0 to 75, graph 1 nohead dt 3 lc rgb '#888888'
set label 1 'measured up to 75°' at 74.5, graph 0.06 right textcolor rgb '#666666'
csv = '$OUT/2_extrapolation.csv'
plot csv skip 1 using 1:2 with lines lw 2 title 'p = 1', '' skip 1 using 1:3 with lines lw 2 title 'p = 0.5', \
     '' skip 1 using 1:4 with lines lw 2 title 'p = 0.2', '' skip 1 using 1:5 with lines lw 2 title 'p = 0', \
     '$work/truth.csv' using 1:2 with points pt 6 ps 0.5 lc rgb '#444444' title 'truth'
unset arrow 1; unset label 1
set title 'fade b(x, l) from the measured edge to the horizon'
set xlabel 'x = (θ_{out} - 75°) / 15°'; set ylabel 'b'
set xrange [0:1]; set yrange [0:1]; set key outside right center
csv = '$OUT/2_bezier.csv'
plot csv skip 1 using 1:2 with linespoints lw 2 pt 7 ps 0.4 title 'l = 0', '' skip 1 using 1:3 with linespoints lw 2 pt 7 ps 0.4 title 'l = 0.3', \
     '' skip 1 using 1:4 with linespoints lw 2 pt 7 ps 0.4 title 'l = 0.7', '' skip 1 using 1:5 with linespoints lw 2 pt 7 ps 0.4 title 'l = 1'
GNUPLOT
cat <<MARKDOWN

## 2. Interpolation and extrapolation

**Between slices** (Cezner and Havran 2024, figure 6): the cosine lobe (r.v)^20 is measured at 0, 20, 40 and 60 degrees and looked up in between, in the
plane of incidence. The table holds the values around the mirror direction, so the lobe turns with the light; with the outgoing direction held fixed there are two
smaller lobes instead of one, "which does not represent the correct behavior".

![lobe between slices](2_interpolation.svg)

Root mean square error over the plane of incidence, relative to the lobe's own root mean square:

$(awk -F, 'NR == 1 { print "θ_in,specular frame,fixed outgoing direction" } NR > 1 { printf "%s°,%.1f %%,%.1f %%\n", $1, 100 * $2, 100 * $3 }' "$OUT/2_errors.csv" | markdown_table)

**Beyond the measured angles** (figure 3, drawn there for p = 0.2 and l = 0.3): the last measured value, at 75 degrees, fades to its share p at the horizon along a quadratic
Bezier curve with the control point (l, 1-l). Left: gold of the demo, as the instrument measures it up to 75 degrees, and as it is. Right: the fade, read
back from tables of a constant material with p = 0.

![extrapolation](2_extrapolation.svg)

Numbers: [2_interpolation.csv](2_interpolation.csv), [2_errors.csv](2_errors.csv), [2_extrapolation.csv](2_extrapolation.csv), [2_bezier.csv](2_bezier.csv).
MARKDOWN
