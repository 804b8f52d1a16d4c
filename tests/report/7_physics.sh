#!/usr/bin/env bash
# Reciprocity, energy and image slices of every material: source, its 64 KB half-vector table, difference.
. tests/report/common.sh
materials >"$work/all"
[ -z "$QUICK" ] || sed -n 1p "$work/all" >"$work/one"
[ -z "$QUICK" ] || mv "$work/one" "$work/all"

one() { # name source
    table "$2" "$work/$1.ktx2" --size 64K --json >"$work/$1.json"
    quietly "$B/gtlut" preview "$2" --against "$work/$1.ktx2" --what image_slices -o "$OUT/7_$1.svg"
    node -e 'const r = JSON.parse(require("fs").readFileSync(process.argv[2])), luminance = (c) => 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
        const at = (t, who) => luminance(r.albedo.find((a) => a.theta_in === t)[who]).toFixed(4);
        const most = (who) => Math.max(...r.albedo.flatMap((a) => a[who])).toFixed(4);
        console.log([process.argv[1], r.reciprocity.source.toFixed(4), r.reciprocity.table.toFixed(4), at(0, "source"), at(0, "table"), at(60, "source"), at(60, "table"),
            at(85, "source"), at(85, "table"), most("source"), most("table"), r.de_mean.toFixed(4)].join(","))' "$1" "$work/$1.json" >"$work/$1.row"
}
each one <"$work/all"
csv=$OUT/7_physics.csv
echo 'material,reciprocity_source,reciprocity_table,albedo_0_source,albedo_0_table,albedo_60_source,albedo_60_table,albedo_85_source,albedo_85_table,largest_albedo_source,largest_albedo_table,de_mean' >"$csv"
while read -r name _; do cat "$work/$name.row"; done <"$work/all" >>"$csv"
count=$(wc -l <"$work/all")
plot 7_energy 720x420 <<GNUPLOT
set multiplot layout 1,2
set xlabel 'albedo of the source'; set ylabel 'albedo of the table'; set key off; set size square
set title 'albedo at θ_{in} = 60°'
set xrange [0:1.05]; set yrange [0:1.05]
plot x with lines lc rgb '#aaaaaa', '$csv' skip 1 using 6:7 with points pt 7 ps 0.5 lc rgb '#2471a3'
set title 'largest albedo of any channel'
set xrange [0:*]; set yrange [0:*]
plot x with lines lc rgb '#aaaaaa', '$csv' skip 1 using 10:11 with points pt 7 ps 0.5 lc rgb '#c0392b'
GNUPLOT
shown=$(head -4 "$work/all" | cut -d' ' -f1)
cat <<MARKDOWN

## 7. Reciprocity, energy, image slices

Every material $([ -n "$DATA" ] && echo 'of the data folder' || echo 'of the demo (there is no data folder)'), $count in all: the source, its half-vector table of 64 KB, and the difference.
A half-vector table is reciprocal by construction; the source's error is the root mean square of f(l,v) - f(v,l) over that of f, both weighted with
n.v. Albedo is luminance, the share of the light from θ_in that is reflected; "largest" is that of any channel at 0, 20, 40, 60, 75 and 85 degrees: above 1 a
source gives back more light than it gets, and a table that follows it does, too. Links lead to the image slices (Burley 2012; θ_h to the right, θ_d upwards) of source and table and
ten times their difference.

$(awk -F, 'NR > 1 && $10 > 1 { n++; names = names (n > 1 ? ", " : "") $1 } NR > 1 && $2 > r { r = $2; worst = $1 } NR > 1 && $3 > t { t = $3 }
    END { printf "Sources that reflect more than they get: %d%s. Largest reciprocity error of a source: %.3f%s; of a table: %.4f.\n", n, n ? " (" names ")" : "", r, r ? " (" worst ")" : "", t }' "$csv")

![energy of source and table](7_energy.svg)

$(for name in $shown; do printf '**%s**\n\n![image slices of %s](7_%s.svg)\n\n' "$name" "$name" "$name"; done)

$(awk -F, 'NR == 1 { print "material,reciprocity error: source,table,albedo at 0°: source,table,at 60°: source,table,at 85°: source,table,largest: source,table,mean dE"; next }
    { sub(/^[^,]*/, "[" $1 "](7_" $1 ".svg)"); print }' "$csv" | markdown_table)

Numbers: [7_physics.csv](7_physics.csv).
MARKDOWN
