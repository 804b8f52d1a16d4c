#!/usr/bin/env bash
# gtlut's command line: what each subcommand writes, what it refuses, and how it says so.
. tests/e2e/gtlut_common.sh

# built arguments of gtlut build...: exit code 0, no message, but a report on stderr; it stays in built_err
built() {
    "$G" build "$@" 2>built_err || { echo "exit code $?: build $*"; cat built_err; return 1; }
    ! grep '^gtlut:' built_err || { echo "message of: build $*"; return 1; }
    grep -q '^mean dE ' built_err && grep -q '^reciprocity error: ' built_err || { echo "no report: build $*"; cat built_err; return 1; }
}

# figure pattern: the number after it in the last report
figure() { sed -nE "s/.*$1 ([0-9.e+-]+).*/\\1/p" built_err | sed 's/[,.]$//'; }

# holds 'awk condition'
holds() { awk "BEGIN { exit !($1) }" || { echo "does not hold: $1"; return 1; }; }

# says pattern command...: exit code 0 and the pattern in a message on stderr
says() {
    local pattern=$1
    shift
    "$@" 2>says_err || { echo "exit code $?: $*"; cat says_err; return 1; }
    grep -qE "^gtlut: [a-z]+: .*$pattern" says_err || { echo "no message like: $pattern"; cat says_err; return 1; }
}

# --- help ---
helps() {
    quiet "$G" --help >out && grep -q 'Usage: gtlut' out || return 1
    quiet "$G" --version >out && grep -qxE 'gtlut [0-9]+\.[0-9]+\.[0-9]+' out || return 1
    for s in measure import build info export; do
        grep -q "^  $s " <("$G" --help) || { echo "$s is not in gtlut --help"; return 1; }
        quiet "$G" $s --help >out && grep -q "Usage: gtlut $s" out || return 1
    done
}
check "help and version go to stdout with exit code 0, for every subcommand" helps

# --- measure ---
lists() {
    quiet "$G" measure --list >list || return 1
    [ "$(wc -l <list)" -ge 10 ] || { echo "fewer than 10 materials"; return 1; }
}
check "measure --list names at least ten materials" lists

measures_white() {
    quiet "$G" measure matte_white -o white.csv || return 1
    grep -v '^#' white.csv | head -1 | grep -qx 'theta_in,theta_out,phi_out,R,G,B' || return 1
    grep -v '^[#t]' white.csv | awk -F, '
        { angles[$1]++; if ($2 > t) t = $2; if ($3 > p) p = $3; d = $4 * 3.14159265 / 0.8 - 1; if (d * d > 1e-12 || $4 != $6) bad++ }
        END { exit !(NR == 109440 && angles[0] == 27360 && angles[60] == 27360 && t == 75 && p == 359 && !bad) }'
}
check "measure writes 4 x 76 x 360 directions; matte_white is 0.8/pi in each" measures_white

prints_nowhere() { # standard output is a full disk
    local command
    for command in --help --version 'build --help' formats 'check white.csv' 'measure gold -o -' 'info white.csv'; do
        "$G" $command >/dev/full 2>err
        [ $? = 3 ] && [ "$(wc -l <err)" = 1 ] || { echo "$command"; cat err; return 1; }
    done
}
check "what cannot be printed is exit code 3, of help as of reports" prints_nowhere

measures_noise() {
    quiet "$G" measure plastic_red --noise 2 --seed 7 -o a.csv && quiet "$G" measure plastic_red --noise 2 --seed 7 -o - >b.csv || return 1
    quiet "$G" measure plastic_red --noise 2 --seed 8 -o c.csv && quiet "$G" measure plastic_red -o d.csv || return 1
    cmp a.csv b.csv || return 1
    ! cmp -s a.csv c.csv || { echo "the seed changes nothing"; return 1; }
    paste -d, a.csv d.csv | grep -v '^[#t]' | awk -F, '{ d = $4 / $10 - 1; s += d; ss += d * d }
        END { m = s / NR; r = sqrt(ss / NR); print m, r; exit !(m * m < 1e-6 && r > 0.0195 && r < 0.0205) }'
}
check "measure --noise is Gaussian of that percentage, repeats with the seed and goes to stdout as to a file" measures_noise

conserves_energy() {
    local m
    for m in $(cut -d' ' -f1 list); do
        quiet "$G" measure "$m" -o m.csv && built m.csv --size 181x91 -o m.ktx2 || return 1
        quiet "$G" info m.ktx2 >out && [ "$(grep -c '^albedo' out)" = 4 ] || return 1
        awk -v m="$m" '/^albedo/ { for (i = 5; i <= 7; i++) if ($i <= 0.01 || $i > 1) { print m, $0; bad = 1 } } END { exit bad }' out || return 1
    done
}
check "no built-in material creates energy, not even the one narrower than the aperture" conserves_energy

measures_dense() {
    quiet "$G" measure matte_red --geometry dense -o dense.csv && built dense.csv --size 46x46 -o dense.ktx2 || return 1
    quiet "$G" info dense.ktx2 | grep -qx 'theta_in: 0 5 10 15 20 25 30 35 40 45 50 55 60 65 70 75 80 85'
}
check "measure --geometry dense gives 18 angles of incidence" measures_dense

# --- import, build, info ---
imports_csv() {
    quiet "$G" import white.csv -o white.gtm && quiet "$G" info white.gtm >out || return 1
    grep -qx 'source: white.csv' out && grep -qx 'points: 109440' out && grep -qx 'extrapolated: 0' out && grep -qx 'filled in: 0' out &&
        grep -qx 'theta_in 60: theta_out 0..75 (76), phi_out 0..359 (360)' out || { cat out; return 1; }
    built white.gtm -o a.ktx2 && built white.csv -o b.ktx2 && cmp a.ktx2 b.ktx2
}
check "import keeps a CSV as it is: the table is the same from either" imports_csv

builds() {
    quiet "$G" info a.ktx2 >out || return 1
    for line in 'kind: table, specular frame' "bytes: $(stat -c %s a.ktx2)" 'texels: 361 x 181 x 4 (phi_d, theta_d, theta_in)' 'theta_in: 0 20 40 60' 'swap: no' \
        'goniotile.kind: specular_frame' 'goniotile.theta_max: 60000' 'goniotile.version: 1' 'goniotile.source: white.csv' \
        'goniotile.extrapolation: p=1,l=0.3,theta_b=75' 'albedo at theta_in 40: 0.8007 0.8007 0.8007'; do
        grep -qxF "$line" out || { echo "info lacks: $line"; cat out; return 1; }
    done
    built a.csv --size 91x46 --p 0.2 -o - >small.ktx2 && quiet "$G" info small.ktx2 >out &&
        grep -q '^texels: 91 x 46 x 4 ' out && grep -q 'p=0.2,l=0.3' out || return 1
    [ "$(stat -c %s a.ktx2)" -lt $((1045456 + 600)) ] && [ "$(stat -c %s small.ktx2)" -lt $((66976 + 600)) ]
}
check "build writes 361 x 181 x 4 texels by default and any size on request" builds

one_slice() {
    { echo theta_in,theta_out,phi_out,R,G,B; for t in 0 30 60 80; do echo "0,$t,0,0.1,0.2,0.3"; done; } >one.csv
    built one.csv --size 19x10 -o one.ktx2 && quiet "$G" info one.ktx2 | grep -qx 'goniotile.theta_max: 90000'
}
check "a single slice makes a table for all angles of incidence" one_slice

reports() {
    { echo theta_in,theta_out,phi_out,R,G,B; for t in 0 30 60 80; do echo "0,$t,0,7e4,-2,0.3"; done; } >hot.csv
    says '4 negative values set to 0, the first in line 2' "$G" import hot.csv -o hot.gtm || return 1
    says 'texels above 65408 1/sr clipped, the largest 70000' "$G" build hot.gtm -o hot.ktx2 || return 1
    says 'theta_in 0: albedo .* above 1' "$G" build hot.gtm -o hot.ktx2 && [ -s hot.ktx2 ]
}
check "negative, clipped and energy-creating values are reported and go on" reports

# scaled FACTOR: white.csv with values times that
scaled() { awk -F, -v OFS=, -v f="$1" '/^[0-9]/ { $4 *= f; $5 *= f; $6 *= f } { print }' white.csv >scaled.csv; }
out_of_range() {
    local kind
    for kind in half_vector specular_frame; do
        for factor in 1e30 1e12 1e-8; do
            scaled $factor
            echo keep >range.ktx2
            "$G" build scaled.csv --kind $kind -o range.ktx2 2>err
            [ $? = 4 ] && grep -q 'values do not fit into texels.*is the unit 1/sr' err || { echo "$kind, times $factor"; cat err; return 1; }
            grep -qx keep range.ktx2 || return 1
        done
        scaled 3e-6
        says 'values are rounded coarsely' "$G" build scaled.csv --kind $kind -o range.ktx2 || return 1
    done
    scaled 2e10
    says 'texels clipped at 4.28658e.09' "$G" build scaled.csv --kind half_vector --size 1K -o range.ktx2
}
check "values that no texel holds are refused, those that texels hold badly reported" out_of_range

doubtful() {
    awk -F, -v OFS=, '/^[0-9]/ { if ($3 % 180) next } { print }' white.csv >plane.csv
    says 'phi_out lie up to 180 degrees apart' "$G" build plane.csv --size 19x10 -o doubt.ktx2 || return 1
    awk -F, -v OFS=, '/^[0-9]/ { c = cos($2 * 0.01745329252); $4 *= c; $5 *= c; $6 *= c } { print }' white.csv >times.csv
    says 'seem to be BRDF times cos.theta_out.; gtlut check --repair' "$G" build times.csv --size 19x10 -o doubt.ktx2 || return 1
    holds "$(sed -nE 's/^reciprocity error: source ([0-9.e-]+),.*/\1/p' says_err) > 0.2" && grep -q 'against the source made reciprocal' says_err || return 1
    built white.csv --size 19x10 -o doubt.ktx2 && holds "$(figure "reciprocity error: source") < 0.001" && ! grep "made reciprocal" built_err
}
check "build says that a measurement lacks azimuths, holds a cosine, is not reciprocal by its own samples" doubtful

imports_rgl() {
    local f=$DATA/brdf/$1_rgb.bsdf
    quiet "$G" import "$f" -o r.gtm && built r.gtm -o r.ktx2 && quiet "$G" info r.ktx2 >out || return 1
    grep -qx "goniotile.source: $1_rgb.bsdf" out && grep -q '^texels: 361 x 181 x 4 ' out || return 1
    quiet "$G" import "$f" --format rgl --geometry dense -o r.gtm && quiet "$G" info r.gtm | grep -qx 'points: 576720' || return 1
    refused 4 'not a measurement, a specular_frame table needs one; gtlut import' build "$f" --kind specular_frame -o out.ktx2 || return 1
    "$G" build "$f" --size 4K -o direct.ktx2 2>built_err && quiet "$G" info direct.ktx2 >out || return 1
    grep -qx 'kind: table, half vector' out && grep -qx "goniotile.source: $1_rgb.bsdf" out || { cat out; return 1; }
    holds "$(figure 'reciprocity error: source') > 0.01 && $(figure 'table') < 1e-9 && $(figure 'mean dE') < 1" || return 1
    refused 4 'RGL material file; gtlut import it first' info "$f" || return 1
    refused 4 'is rgl, not csv' import "$f" --format csv -o out.gtm || return 1
    head -c 300000 "$f" >cut.bsdf
    refused 4 'truncated' import cut.bsdf -o out.gtm
}
if [ -r "$DATA/brdf/paper_white_rgb.bsdf" ]; then
    check "import evaluates a real material, at the instrument's angles and densely; a cut file is refused" imports_rgl paper_white
else
    skip "import evaluates a real material" "no data folder"
fi

# --- half-vector tables ---
half_vector() {
    built white.csv --kind half_vector -o hv.ktx2 --json >report.json || return 1
    quiet "$G" info hv.ktx2 >out || return 1
    for line in 'kind: table, half vector' 'scale: 0' 're-packed copy: 0 bytes' 'goniotile.kind: half_vector' 'goniotile.version: 1' \
        'goniotile.source: white.csv' 'goniotile.warph: (258 bytes)' 'goniotile.warpd: (130 bytes)'; do
        grep -qxF "$line" out || { echo "info lacks: $line"; cat out; return 1; }
    done
    # 0.8 / pi wherever white was measured; towards the horizon an extrapolation
    awk '/^albedo/ { n++; for (i = 5; i <= 7; i++) if ($i < (n < 5 ? 0.79 : 0.7) || $i > 0.805) { print; bad = 1 } }
        /^texels:/ { nodes = $2 * $4 * $6; if (nodes > 16384 || nodes < 4096) { print; bad = 1 } }
        END { exit bad || n != 6 }' out || return 1
    holds "$(figure 'mean dE') < 0.2 && $(figure 'PSNR') > 50 && $(figure 'table') < 1e-9"
}
check "build --kind half_vector fits a reciprocal table of 64 KB to a measurement" half_vector

half_vector_sizes() {
    local size bytes
    for size in 1K 16K; do
        built white.gtm --kind half_vector --size $size -o s.ktx2 || return 1
        bytes=$(sed -nE 's/.*nodes \(h, d, t\): ([0-9]+) bytes.*/\1/p' built_err)
        [ "$bytes" -gt $((${size%K} * 512)) ] && [ "$bytes" -le $((${size%K} * 1024 + 388)) ] || { echo "$size: $bytes bytes"; return 1; }
    done
    built white.gtm --kind half_vector --size 21x16x3 -o s.ktx2 && quiet "$G" info s.ktx2 >out && grep -qx 'texels: 3 x 21 x 16 (t, h, d)' out || return 1
    [ "$(sed -n 's/^theta_h: //p' out | wc -w)" = 21 ] && [ "$(sed -n 's/^theta_d: //p' out | wc -w)" = 16 ] || return 1
    sed -nE 's/^theta_[hd]: //p' out | awk '{ if ($1 != 0 || $NF < 89) bad = 1; for (i = 2; i <= NF; i++) if ($i < $(i - 1)) bad = 1 } END { exit bad }'
}
check "build --size gives a half-vector table the bytes or nodes asked for" half_vector_sizes

half_vector_sources() {
    built hv.ktx2 --size 4K -o again.ktx2 && quiet "$G" info again.ktx2 | grep -qx 'kind: table, half vector' || return 1
    holds "$(figure 'mean dE') < 0.2" || return 1
    built a.ktx2 --size 4K -o again.ktx2 && quiet "$G" info again.ktx2 | grep -qx 'kind: table, half vector' || return 1
    built a.ktx2 --size 4K -o - >stdout.ktx2 && cmp stdout.ktx2 again.ktx2
}
check "a table of either kind is built anew as a half-vector table; the same input gives the same bytes" half_vector_sources

# 7e4 is more than a texel holds
half_vector_scales() {
    "$G" build hot.gtm --kind half_vector --size 1K -o hot.ktx2 2>built_err && grep -q 'albedo .* is above 1, the source.s is' built_err || return 1
    ! grep clipped built_err && quiet "$G" info hot.ktx2 >out && grep -qxE 'scale: [1-9]' out || { cat built_err out; return 1; }
    holds "$(sed -nE 's/^albedo at theta_in 40: ([0-9.]+) .*/\1/p' out) / 3.14159265 / 70000 > 0.9"
}
check "values beyond RGB9_E5 are scaled, not clipped, in a half-vector table" half_vector_scales

fits() {
    local f=$DATA/brdf/merl_sgd.csv
    built "$f:red-phenolic" --size 16K -o fit.ktx2 && quiet "$G" info fit.ktx2 | grep -q '^kind: table, half vector' || return 1
    holds "$(figure 'mean dE') < 0.2 && $(figure 'reciprocity error: source') < 1e-9" || return 1
    refused 4 'no-such-paint' build "$f:no-such-paint" -o out.ktx2
}
if [ -r "$DATA/brdf/merl_sgd.csv" ]; then
    check "FITS.csv:NAME builds one material of a table of fits" fits
else
    skip "FITS.csv:NAME builds one material of a table of fits" "no data folder"
fi

packed() {
    built hv.ktx2 --size 32x24x5 -o plain.ktx2 && built hv.ktx2 --size 32x24x5 --packed -o packed.ktx2 || return 1
    quiet "$G" info packed.ktx2 >out || return 1
    local bytes
    bytes=$(sed -nE 's/^re-packed copy: ([0-9]+) bytes$/\1/p' out)
    # a record and one or two rows of 5 x 12 bytes for each of 31 x 23 cells
    holds "$bytes >= 31 * 23 * (4 + 60) && $bytes <= 31 * 23 * (4 + 120)" || return 1
    [ $(($(stat -c %s packed.ktx2) - $(stat -c %s plain.ktx2))) -ge "$bytes" ] || return 1
    cmp <(tail -c $((4 * 32 * 24 * 5)) plain.ktx2) <(tail -c $((4 * 32 * 24 * 5)) packed.ktx2)
}
check "build --packed adds the re-packed copy and changes no texel" packed

max_de() {
    local smaller
    built hv.ktx2 --max-de 50 -o loose.ktx2 && quiet "$G" info loose.ktx2 >out || return 1
    awk '/^texels:/ { exit $2 * $4 * $6 > 256 }' out || { echo "not the smallest"; return 1; }
    smaller=$(figure 'mean dE') && built hv.ktx2 --max-de "$(awk "BEGIN { print 0.9 * $smaller }")" -o tight.ktx2 || return 1
    holds "$(figure 'mean dE') <= 0.9 * $smaller" && quiet "$G" info tight.ktx2 | awk '/^texels:/ { exit $2 * $4 * $6 <= 256 }' || return 1
    "$G" measure plastic_red -o plastic.csv && built plastic.csv --size 91x46 -o plain.ktx2 || return 1
    refused 11 'max-de: 0.001 is not reached, the smallest mean dE is [0-9.e-]+ at 256K' build plain.ktx2 --max-de 0.001 -o out.ktx2
}
check "build --max-de takes the smallest size that meets it; when none does, exit code 11 and no file" max_de

swaps() {
    local plain
    built plastic.csv --size 91x46 -o plain.ktx2 && plain=$(figure 'mean dE') || return 1
    holds "$(figure 'table') > 0.01" || return 1
    built plastic.csv --size 91x46 --swap -o swap.ktx2 && quiet "$G" info swap.ktx2 >out || return 1
    grep -qx 'swap: yes' out && grep -qx 'goniotile.swap: 1' out && holds "$(figure 'mean dE') < $plain && $(figure 'table') < 1e-9"
}
check "build --swap makes a specular frame reciprocal and closer to its source" swaps

reads_json() { # file expression: the JSON parses and the expression on `x` is true
    node -e "const x = JSON.parse(require('fs').readFileSync('$1')); if (!($2)) { console.log(JSON.stringify(x)); process.exit(1) }"
}
json() {
    reads_json report.json "x.kind == 'half_vector' && x.source == 'white.csv' && x.nodes.length == 3 && x.de_mean < 0.2 && x.psnr > 50 &&
        x.e_75_87 < 0.1 && x.albedo.length == 6 && Math.abs(x.albedo[2].table[1] - 0.8) < 0.01 && x.reciprocity.table < 1e-9 &&
        x.measured.theta_in == 60 && x.table_bytes <= 65536 + 388 && x.file_bytes == $(stat -c %s hv.ktx2)" || return 1
    quiet "$G" info hv.ktx2 --json >out && reads_json out "x.kind == 'half_vector' && x.texels.reduce((a, b) => a * b) <= 16384 && x.scale == 0 &&
        x.packed_bytes == 0 && x.theta_h.length == x.texels[1] && x.theta_d.length == x.texels[2] && x.albedo.length == 6 &&
        x.metadata.find((m) => m.key == 'goniotile.warph').bytes == 258" || return 1
    quiet "$G" info a.ktx2 --json >out && reads_json out "x.kind == 'specular_frame' && x.theta_in[3] == 60 && x.albedo.length == 4 &&
        x.metadata.find((m) => m.key == 'goniotile.source').value == 'white.csv'" || return 1
    quiet "$G" info white.gtm --json >out && reads_json out "x.kind == 'measurement' && x.points == 109440 && x.slices.length == 4"
}
if command -v node >/dev/null; then
    check "build and info write JSON that says the same" json
else
    skip "build and info write JSON" "no node"
fi

half_vector_refusals() {
    refused 2 "--kind: 'x' is not half_vector or specular_frame" build white.gtm --kind x -o out.ktx2 || return 1
    for size in 0K 257K 64k K 1x2x2 129x2x2 2x2x33 128x128x5 64x32 64x32x8x1 361x181 -4K; do
        refused 2 "--size: '$size' is neither 1K to 256K nor HxDxT" build white.gtm --kind half_vector --size=$size -o out.ktx2 || return 1
    done
    refused 2 "--max-de: '0' is not a number from 0.001 to 100" build white.gtm --kind half_vector --max-de 0 -o out.ktx2 || return 1
    refused 2 'max-de: chooses the size itself; leave --size out' build white.gtm --kind half_vector --max-de 1 --size 4K -o out.ktx2 || return 1
    for option in '--packed' '--max-de 1'; do
        refused 2 "${option% *}: only for half_vector, this is a specular_frame table" build white.gtm $option -o out.ktx2 || return 1
    done
    for option in '--swap' '--p 0.5' '--l 0.5'; do
        refused 2 "${option% *}: only for specular_frame, this is a half_vector table" build white.gtm --kind half_vector $option -o out.ktx2 || return 1
    done
    refused 2 'json: stdout is taken' build white.gtm --json -o - || return 1
    refused 4 'not a measurement, a specular_frame table needs one' build hv.ktx2 --kind specular_frame -o out.ktx2 || return 1
    printf 'Source Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\n' >zemax.bsdf
    refused 4 'zemax.bsdf: is zemax; gtlut import it first' build zemax.bsdf -o out.ktx2 || return 1
    refused 4 'zemax.bsdf: is zemax; gtlut import it first' info zemax.bsdf || return 1
    refused 4 'white.csv:1: not a table of shifted-gamma fits' build white.csv:gold -o out.ktx2 || return 1
    refused 3 'missing.csv:gold: No such file' build missing.csv:gold -o out.ktx2 || return 1
    refused 3 'none/out.ktx2: No such file' build hv.ktx2 --size 1K -o none/out.ktx2
}
check "options out of range or of the other kind are refused before anything is written" half_vector_refusals

# patched key offset octal: a copy of hv.ktx2 with one byte of a key's value changed
patched() {
    local at
    at=$(grep -abo "goniotile.$1" hv.ktx2 | head -1 | cut -d: -f1) || return 1
    at=$((at + 10 + ${#1} + 1 + $2))
    cp hv.ktx2 damaged.ktx2 && printf "\\$3" | dd of=damaged.ktx2 bs=1 seek=$at conv=notrunc status=none
}
damaged_tables() {
    local s
    for s in "info damaged.ktx2" "export damaged.ktx2 -o out.png" "build damaged.ktx2 -o out.ktx2"; do
        patched warph 0 001 && refused 4 'damaged.ktx2: a warp is missing, not monotone' $s || return 1
        patched warpd 129 377 && refused 4 'damaged.ktx2: a warp is missing, not monotone' $s || return 1
        patched cells 3 040 && refused 4 'damaged.ktx2: the cell exponents' $s || return 1
        patched kind 0 170 && refused 4 'damaged.ktx2: the kind of table' $s || return 1
        patched version 0 071 && refused 4 "damaged.ktx2: the table's version" $s || return 1
        head -c -4 hv.ktx2 >damaged.ktx2 && refused 4 'damaged.ktx2: ' $s || return 1
    done
}
check "half-vector tables with damaged metadata are refused with exit code 4" damaged_tables

# --- export ---
png_size() { od -An -tu1 -j16 -N8 "$1" | awk '{ print ($3 * 256 + $4) "x" ($7 * 256 + $8) }'; }
exports() {
    quiet "$G" export a.ktx2 -o a.png && [ "$(png_size a.png)" = 722x362 ] || return 1
    quiet "$G" export dense.ktx2 -o dense.png && [ "$(png_size dense.png)" = 230x184 ] || return 1
    quiet "$G" export a.ktx2 --exposure 3.2 -o bright.png && ! cmp -s a.png bright.png || return 1
    quiet "$G" export a.ktx2 -o a.exr && [ "$(od -An -tx1 -N4 a.exr | tr -d ' ')" = 762f3101 ]
}
check "export arranges the slices as PNG and EXR" exports

# 12 planes of 2 x 8 texels: ceil(sqrt(12 * 8 / 2)) = 7 columns, 2 rows
exports_half_vector() {
    built hv.ktx2 --size 8x12x2 -o planes.ktx2 && quiet "$G" export planes.ktx2 -o planes.png && [ "$(png_size planes.png)" = 14x16 ] || return 1
    quiet "$G" export planes.ktx2 -o planes.exr
}
check "export arranges the planes of a half-vector table" exports_half_vector

# Five slices, each of one colour, exact in RGB9_E5: 3 x 2 images of 7 x 5 pixels, the last one empty.
exports_values() {
    { echo theta_in,theta_out,phi_out,R,G,B; for i in 0 1 2 3 4; do for t in 0 80; do echo "$((15 * i)),$t,0,0.$((125 * i)),0.25,8"; done; done; } >five.csv
    "$G" build five.csv --size 7x5 -o five.ktx2 2>log5 || { cat log5; return 1; }
    quiet "$G" export five.ktx2 -o five.exr && quiet "$G" export five.ktx2 --exposure 2 -o five.png || return 1
    node "$READ_IMAGE" five.exr 0,0 6,4 7,0 20,4 0,5 13,9 14,5 20,9 >out &&
        printf '%s 0.25 8\n' 0 0 0.125 0.25 0.375 0.5 >want && printf '0 0 0\n0 0 0\n' >>want && diff out want || return 1
    # sRGB of 0.25, 0.5, 0.75 and 1: 136.96, 187.52, 224.60, 255
    node "$READ_IMAGE" five.png 0,0 7,0 20,4 0,5 13,9 14,5 >out &&
        printf '%s 188 255\n' 0 137 188 225 255 >want && echo 0 0 0 >>want && diff out want
}
if command -v node >/dev/null; then
    check "exported pixels are the table's values, linear in EXR, exposed and sRGB-encoded in PNG, slices row by row" exports_values
else
    skip "exported pixels are the table's values" "no node"
fi

without_shim() {
    mkdir -p bin && cp "$G" bin/ || return 1
    local keep=$G
    G=$work/bin/gtlut
    refused 3 'goniotile_oiio.so.*run .make' export a.ktx2 -o out.png
    local code=$?
    G=$keep
    return $code
}
check "export without its OpenImageIO part says so" without_shim

# --- refusals ---
usage() {
    refused 2 'no subcommand' && refused 2 "'melt': no such subcommand" melt && refused 2 "'-x': no such" -x || return 1
    for s in measure import build info export; do
        refused 2 '0 arguments where one' $s || return 1
        refused 2 '2 arguments where one' $s a b || return 1
        refused 2 '--melt: unknown option' $s a --melt || return 1
        refused 2 '-o: no value' $s a -o || return 1
    done
    for s in "measure gold" "import a.csv" "build a.csv" "export a.ktx2"; do refused 2 'no output file; give -o' $s || return 1; done
    refused 2 'leave it out' info a.ktx2 -o out.csv || return 1
    refused 2 "'goldd': no such material" measure goldd -o out.csv || return 1
    refused 2 "--noise: '51' is not a number from 0 to 50" measure gold --noise 51 -o out.csv || return 1
    refused 2 "--noise: 'nan'" measure gold --noise nan -o out.csv || return 1
    refused 2 "--seed: '-1'" measure gold --seed -1 -o out.csv || return 1
    refused 2 "--geometry: 'x' is not minidiff or dense" measure gold --geometry x -o out.csv || return 1
    refused 2 "--geometry: (CSV|csv) keeps its own" import a.csv --geometry dense -o out.gtm || return 1
    refused 2 "--format: 'x' is (no format|not csv or rgl)" import a.csv --format x -o out.gtm || return 1
    for size in 1x181 361x1 5000x5 10 361x181x4 x 0x0 -5x5; do refused 2 "--size: '$size' is not" build a.csv --size=$size -o out.ktx2 || return 1; done
    refused 2 '4096 x 4096 x 4 texels, the limits' build a.csv --size 4096x4096 -o out.ktx2 || return 1
    refused 2 "--p: '1.5'" build a.csv --p 1.5 -o out.ktx2 && refused 2 "--l: '-0.1'" build a.csv --l=-0.1 -o out.ktx2 || return 1
    refused 2 "--exposure: '0'" export a.ktx2 --exposure 0 -o out.png || return 1
    refused 2 "'out.jpg' does not end in" export a.ktx2 -o out.jpg && refused 2 "'out' does not end in" export a.ktx2 -o out
}
check "wrong arguments and options out of range are refused with exit code 2, naming the range" usage

files() {
    refused 3 'missing: No such file' import missing -o out.gtm && refused 3 'missing: No such file' build missing -o out.ktx2 || return 1
    refused 3 'missing: No such file' info missing && refused 3 'missing: No such file' export missing -o out.png || return 1
    refused 3 'none/out.csv: No such file' measure gold -o none/out.csv && refused 3 'none/out.gtm: No such' import one.csv -o none/out.gtm || return 1
    refused 3 'none/out.ktx2: No such file' build one.csv -o none/out.ktx2 && refused 3 'none/out.png' export a.ktx2 -o none/out.png || return 1
    mkdir -p folder.ktx2 && refused 3 'folder.ktx2: Is a directory' build one.csv -o folder.ktx2 || return 1
    refused 3 'Is a directory' build . -o out.ktx2
}
check "unreadable input and unwritable output are refused with exit code 3" files

foreign() {
    local f
    head -c 50000 "$B/gtlut" >elf
    : >empty
    head -c 5000 a.png >picture
    head -c 100000 white.gtm >cut.gtm
    head -c 100000 a.ktx2 >cut.ktx2
    { cat white.gtm; echo; } >long.gtm
    { head -c 5000 white.gtm; printf x; tail -c +5002 white.gtm; } >changed.gtm
    for f in elf empty picture cut.gtm long.gtm changed.gtm cut.ktx2 a.ktx2; do
        [ $f = cut.gtm ] || [ $f = long.gtm ] || [ $f = changed.gtm ] || [ $f = a.ktx2 ] || refused 4 "$f: " import $f -o out.gtm || return 1
        [ $f = a.ktx2 ] || refused 4 "$f: " build $f -o out.ktx2 || return 1
        [ $f = a.ktx2 ] || refused 4 "$f: " info $f || return 1
        [ $f = a.ktx2 ] || refused 4 "$f: " export $f -o out.png || return 1
    done
    refused 4 'already a measurement file' import white.gtm -o out.gtm || return 1
    refused 4 'CRC-32 is' build changed.gtm -o out.ktx2 && refused 4 'truncated or has a tail' build cut.gtm -o out.ktx2 || return 1
    refused 4 "file's size is not" export cut.ktx2 -o out.exr && refused 4 'not a KTX 2.0' export white.csv -o out.exr || return 1
    refused 4 'is (csv|not an RGL file), not rgl' import white.csv --format rgl -o out.gtm || return 1
    truncate -s 80M big && refused 4 'big: longer than the limit' export big -o out.png
}
check "truncated, damaged, oversized and foreign files are refused with exit code 4" foreign

malformed() {
    head -2000 white.csv | sed '1000s/,[^,]*$/,x/' >bad.csv
    for s in "import bad.csv -o out.gtm" "build bad.csv -o out.ktx2" "info bad.csv"; do
        refused 4 "bad.csv:1000: B is 'x', not a number; write" $s || return 1
    done
    grep -v '^40,30,' white.csv | sed '/^40,29,17,/d' >hole.csv
    refused 4 'at theta_in 40, theta_out 29' import hole.csv -o out.gtm || return 1
    grep -v '^20,' white.csv >uneven.csv
    refused 4 'theta_in 40 stands where equal steps from 0 to 60 want 30' build uneven.csv -o out.ktx2
}
misread() { # what the message must say to help
    refused 4 'no format.*|nor of a format that gtlut formats lists' import picture -o out.gtm || return 1
    printf 'material,rhoD_r,rhoD_g\n' >fits.csv
    refused 4 'fits.csv: a table of shifted-gamma fits; name one .*: FILE.csv:NAME' build fits.csv -o out.ktx2 || return 1
    refused 4 'want 30; measure at equal steps, or resample: gtlut import --geometry' build uneven.csv -o out.ktx2 || return 1
    # Nothing is known of light from elsewhere; it is the source that creates energy, whatever --p is.
    "$G" build one.csv -o one.ktx2 2>&1 | grep -q '^measured up to theta_in 0, theta_out 80: beyond' || return 1
    says 'theta_in 0: albedo .* above 1.*; check the source$' "$G" build hot.gtm -o hot.ktx2
}
check "malformed CSV is refused naming the line, an irregular grid naming the direction" malformed
check "messages of files that are read as something else, or lack something, say what to do" misread

echo 1..$n
