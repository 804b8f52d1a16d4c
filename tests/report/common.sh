# For the report's chapters: programs, data, plots, tables. Sourced from the repository's root; a chapter then writes Markdown to stdout.
set -eu
B=${B:-build}
OUT=$B/report
QUICK=${QUICK-}
DATA=${GONIOTILE_DATA:-../shared/data}
[ -r "$DATA/brdf/merl_sgd.csv" ] || DATA=
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# quietly COMMAND...: stderr only when it fails
quietly() {
    local log
    log=$(mktemp -p "$work")
    "$@" 2>"$log" || { cat "$log" >&2; return 1; }
}

# table SOURCE OUT.ktx2 [option of gtlut build...]: unless it is there
table() {
    local source=$1 to=$2
    shift 2
    [ -e "$to" ] || quietly "$B/gtlut" build "$source" -o "$to" --kind half_vector "$@"
}

# plot NAME WIDTHxHEIGHT: gnuplot commands on stdin draw $OUT/NAME.svg
plot() {
    {
        echo "set terminal svg size ${2/x/,} font 'Helvetica,13' background '#ffffff'"
        echo "set encoding utf8; set output '$OUT/$1.svg'; set datafile separator ','"
        echo "set grid lc rgb '#dddddd'; set border lc rgb '#444444'; set key top left reverse Left samplen 2"
        cat
    } | LC_ALL=C.UTF-8 gnuplot
}

# Rows of CSV on stdin, the first the heading, as a Markdown table.
markdown_table() {
    awk -F, '{ line = "|"; rule = "|"; for (i = 1; i <= NF; i++) { line = line " " $i " |"; rule = rule (i == 1 ? "---|" : "--:|") }
        print line; if (NR == 1) print rule }'
}

# scene NAME: a scene's JSON on stdin to $work/NAME.blob
scene() {
    cat >"$work/$1.json"
    quietly "$B/gtscene" build "$work/$1.json" -o "$work/$1.blob"
}

# An even floor of 2 N x 2 N units in y = 0 as OBJ.
floor_mesh() { # N
    awk -v n="$1" 'BEGIN { s = 16; print "vn 0 1 0"
        for (i = 0; i <= s; i++) for (k = 0; k <= s; k++) printf "v %g 0 %g\n", n * (2 * i / s - 1), n * (2 * k / s - 1)
        for (i = 0; i < s; i++) for (k = 0; k < s; k++) { a = i * (s + 1) + k + 1; b = a + s + 1
            printf "f %d//1 %d//1 %d//1\nf %d//1 %d//1 %d//1\n", a, a + 1, b, b, a + 1, b + 1 } }'
}

# A cell of a Markdown table, and the bar after it.
cell() { # picture pixels_wide
    printf ' <img src="%s" width="%s" alt=""> |' "$1" "$2"
}

# Names of the data folder's materials and of what gtlut opens, a line each; the demo's without it.
materials() {
    local file name
    if [ -n "$DATA" ]; then
        for file in "$DATA"/brdf/*_rgb.bsdf; do
            name=$(basename "${file%_rgb.bsdf}")
            echo "$name $file"
        done
        tail -n +2 "$DATA/brdf/merl_sgd.csv" | sed -n "s#^\([a-z][^,]*\),.*#\1 $DATA/brdf/merl_sgd.csv:\1#p"
    else
        for file in "$B"/demo/*.csv; do
            name=$(basename "${file%.csv}")
            echo "$name $file"
        done
    fi
}

# For xargs: `each FUNCTION` runs the exported function once per line of stdin, two words, on all processors.
each() {
    export -f "$1" table quietly
    export B OUT QUICK work
    xargs -P "$(nproc)" -L 1 bash -euc "$1"' "$@"' each
}
