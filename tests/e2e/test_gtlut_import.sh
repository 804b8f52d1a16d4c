#!/usr/bin/env bash
# gtlut formats and import: every format through the command line, and what is refused.
. tests/e2e/gtlut_common.sh

# The values of a measurement's theta_in, as gtlut info sums them up.
values() { "$G" info "$1" | sed -n 's/^values: //p'; }

lists() {
    quiet "$G" formats >out || return 1
    for f in gtm rgl merl ktx2 composite astm zemax cornell sgd csv; do
        grep -qE "^$f +\." out || { echo "$f is not listed"; return 1; }
    done
    quiet "$G" formats --json >out && refused 2 'none is wanted' formats x && refused 2 'leave it out' formats -o x || return 1
    quiet "$G" formats --help | grep -q 'Usage: gtlut formats' || return 1
    command -v node >/dev/null || return 0
    node -e 'const a = JSON.parse(require("fs").readFileSync("out")); process.exit(a.length == 10 && a[1].name == "rgl" && a[1].evaluated ? 0 : 1)'
}
check "formats lists ten formats, as text and as JSON" lists

quiet "$G" measure satin_green -o a.csv && quiet "$G" import a.csv -o a.gtm || exit 1

# The same samples in radians, in any order.
imports_astm() {
    { echo 'ASTM E2387'; echo "NUM_POINTS $(grep -c '^[0-9]' a.csv)"; echo 'VARS theta_i,phi_i,theta_s,phi_s,R,G,B'
      grep '^[0-9]' a.csv | awk -F, -v p=0.017453292519943295 -v OFS=, -v OFMT=%.12g -v CONVFMT=%.12g '{ print $1 * p, 1, $2 * p, 1 + $3 * p, $4, $5, $6 }'; } >a.astm
    quiet "$G" import a.astm --format astm -o b.gtm || return 1
    "$G" build a.gtm --size 91x46 -o a1.ktx2 2>/dev/null && "$G" build b.gtm --size 91x46 -o b1.ktx2 2>/dev/null || return 1
    cmp <(tail -c 60000 a1.ktx2) <(tail -c 60000 b1.ktx2) || { echo "the tables differ"; return 1; }
    refused 2 '--geometry: astm keeps its own' import a.astm --geometry dense -o out.gtm || return 1
    refused 4 'is astm, not csv' import a.astm --format csv -o out.gtm || return 1
    sed '/^VARS/,$ { /^[0-9]/ s/^[^,]*/1.6/ }' a.astm >steep.astm
    refused 4 'theta 1.6 in .*, in radians; theta must be below pi/2' import steep.astm -o out.gtm || return 1
    head -c 1000000 a.astm >cut.astm && refused 4 'NUM_POINTS says|numbers where' import cut.astm -o out.gtm
}
check "an ASTM file of the same samples makes the same table" imports_astm

# A diffuse surface on scattered directions, spectral.
imports_cornell() {
    { echo '# sample'; echo 3; echo 400 550 700
      awk 'BEGIN { for (i = 10; i <= 50; i += 20) for (k = 0; k < 700; k++) { z = 1 - 0.75 * (k + 0.5) / 700; t = atan2(sqrt(1 - z * z), z)
          print i * 0.01745329252, 0, t, (k * 2.39996323) % 6.28318531, 0.2, 0.2, 0.2 } }'; } >c.brdf
    "$G" import c.brdf --illuminant A -o c.gtm 2>err || { cat err; return 1; }
    grep -q 'c.brdf: 2100 samples at 3 angles of incidence resampled to the directions of minidiff' err || { cat err; return 1; }
    [ "$(values c.gtm)" = '0.2..0.2 1/sr' ] || { values c.gtm; return 1; }
    "$G" check c.gtm --json >out
    grep -q '"extrapolated": [1-9]' out || { echo "nothing is marked as extrapolated"; cat out; return 1; }
    "$G" import c.brdf --geometry dense -o c.gtm 2>/dev/null && "$G" info c.gtm | grep -qx 'points: 576720' || return 1
    refused 2 "--illuminant: 'F11' is not D65, E or A" import c.brdf --illuminant F11 -o out.gtm
}
check "scattered spectral samples are resampled, said so, and marked where they end" imports_cornell

# An encoder that reads 30 degrees a little differently each time: no two samples share their angle of incidence.
refuses_jitter() {
    { echo 1; echo 550; awk 'BEGIN { for (k = 0; k < 900; k++) print 30 + k * 0.01 % 0.37 + k * 1e-5, 0, k % 80, k * 7 % 360, 0.2 }'; } >jitter.brdf
    refused 4 'jitter.brdf: 900 samples at [0-9]+ angles of incidence, fewer than 12 at each; round theta_in' import jitter.brdf -o out.gtm &&
        refused 4 'round theta_in' check jitter.brdf || return 1
    awk -v OFS=' ' 'NR > 2 { $1 = 30 } 1' jitter.brdf >steady.brdf && "$G" import steady.brdf -o steady.gtm 2>err || { cat err; return 1; }
}
check "angles of incidence that jitter are refused rather than resampled from next to nothing" refuses_jitter

imports_zemax() {
    { echo '#test'; printf 'Source Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\nSampleRotation 1\n0\n'
      printf 'AngleOfIncidence 2\n0 40\nScatterAzimuth 7\n0 30 60 90 120 150 180\nScatterRadial 6\n0 10 30 50 70 90\n\nMonochrome\nDataBegin\n'
      for i in 1 2; do echo 'TIS 0.3'; for a in 1 2 3 4 5 6 7; do echo 0.1 0.1 0.1 0.1 0.1 0.1; done; done; echo DataEnd; } >z.bsdf
    "$G" import z.bsdf -o z.gtm 2>err && grep -q 'at 2 angles of incidence resampled' err || { cat err; return 1; }
    [ "$(values z.gtm)" = '0.1..0.1 1/sr' ] || { values z.gtm; return 1; }
    sed '$d' z.bsdf >cut.bsdf && refused 4 'where DataEnd is wanted' import cut.bsdf -o out.gtm
}
check "a Zemax file is told from an RGL one of the same extension and resampled" imports_zemax

# A constant 0.5/pi in the scales of the format.
imports_merl() {
    command -v node >/dev/null || return 0
    node -e 'const n = 90 * 90 * 180, b = Buffer.alloc(12 + 24 * n); b.writeInt32LE(90, 0); b.writeInt32LE(90, 4); b.writeInt32LE(180, 8);
        [1500, 1500 / 1.15, 1500 / 1.66].forEach((s, c) => { for (let i = 0; i < n; i++) b.writeDoubleLE(s * 0.5 / Math.PI, 12 + 8 * (c * n + i)); });
        require("fs").writeFileSync("m.binary", b)'
    quiet "$G" import m.binary -o m.gtm || return 1
    [ "$(values m.gtm)" = '0.15915..0.15915 1/sr' ] || { values m.gtm; return 1; }
    head -c 20000000 m.binary >cut.binary && refused 4 '20000000 bytes where this format has 34992012' import cut.binary -o out.gtm
}
check "a MERL file comes back in its scales" imports_merl

"$G" build a.gtm --size 181x91 -o a.ktx2 2>/dev/null && "$G" build a.gtm --kind half_vector --size 16K -o h.ktx2 2>/dev/null || exit 1

imports_tables() {
    local kind
    for kind in a h; do
        quiet "$G" import $kind.ktx2 -o $kind.back.gtm || return 1
        "$G" check $kind.back.gtm --json >out # the same material: albedo at 40 degrees within 2 %
        "$G" check a.gtm --json >want
        command -v node >/dev/null || continue
        node -e 'const r = f => JSON.parse(require("fs").readFileSync(f)).slices[2].albedo; const a = r("out"), b = r("want");
            for (let c = 0; c < 3; c++) if (!(Math.abs(a[c] / b[c] - 1) < 0.02)) { console.log(a, b); process.exit(1) }' || return 1
    done
    quiet "$G" import a.ktx2 --geometry dense -o d.gtm && "$G" check d.gtm --json >out
    # 5 of 18 angles of incidence lie beyond the table's 60 degrees
    grep -q '"extrapolated": 160200,' out || { echo "not the 5 x 89 x 360 samples beyond 60 degrees"; grep -o '"extrapolated": [0-9]*' out; return 1; }
    head -c 30000 a.ktx2 >cut.ktx2 && refused 4 'build the table again' import cut.ktx2 -o out.gtm
}
check "tables of both kinds come back as measurements, marked beyond their last angle of incidence" imports_tables

imports_composite() {
    quiet "$G" export a.ktx2 -o a.exr && quiet "$G" import a.exr --axes 181x91x4 --theta-max 60 -o e.gtm || return 1
    quiet "$G" import a.ktx2 -o k.gtm && cmp -i 88 e.gtm k.gtm || { echo "the image and the table differ"; return 1; }
    refused 2 'does not say its axes; give --axes' import a.exr -o out.gtm || return 1
    refused 4 '362 x 182 pixels do not hold 9 slices of 181 x 91' import a.exr --axes 181x91x9 -o out.gtm || return 1
    refused 4 'do not hold 2 slices' import a.exr --axes 181x91x2 -o out.gtm || return 1
    refused 4 'do not hold 4 slices of 180 x 91' import a.exr --axes 180x91x4 -o out.gtm || return 1
    refused 2 "--axes: '181x91' is not" import a.exr --axes 181x91 -o out.gtm || return 1
    refused 2 "--theta-max: '0'" import a.exr --axes 181x91x4 --theta-max 0 -o out.gtm || return 1
    local bytes
    for bytes in 5 100 350 1000 60000; do
        head -c $bytes a.exr >cut.exr && refused 4 'give an intact image' import cut.exr --axes 181x91x4 -o out.gtm || return 1
    done
}
check "a composite image comes back as its table does, to the bit; cut images and wrong axes are refused" imports_composite

fills() {
    # an arm that hides 5 degrees around the light
    awk -F, '/^[0-9]/ { p = ($3 > 180 ? 360 - $3 : $3) * sin($1 * 0.01745); if ($1 > 0 && ($2 - $1) ^ 2 + p * p < 25) next } { print }' a.csv >blind.csv
    refused 4 'is missing or extra.*or give --geometry to resample' import blind.csv -o out.gtm || return 1
    "$G" import blind.csv --fill-blind-spot -o f.gtm 2>err && grep -qE 'blind spot of [45]\.[0-9] degrees around the light: [0-9]+ samples' err || { cat err; return 1; }
    "$G" info f.gtm | grep -qx 'points: 109440' || return 1
    "$G" check f.gtm >out || { cat out; return 1; }
    grep -qE 'coverage.* [1-9][0-9]* filled in before' out || { cat out; return 1; }
    "$G" import a.csv --fill-blind-spot -o f.gtm 2>err && grep -q 'no blind spot found' err || { cat err; return 1; }
    cmp a.gtm f.gtm
}
check "import --fill-blind-spot interpolates across the spot, says so and marks it; without spot nothing changes" fills

resamples_csv() {
    grep -v '^40,30,' a.csv | sed '/^20,29,17,/d' >hole.csv
    "$G" import hole.csv --geometry minidiff -o h.gtm 2>err && grep -q 'resampled to the directions of minidiff' err || { cat err; return 1; }
    "$G" info h.gtm | grep -qx 'points: 109440' && "$G" check h.gtm >out || { cat out; return 1; }
}
check "a CSV with holes is resampled when --geometry asks for it" resamples_csv

imports_sgd() {
    quiet "$G" import "$DATA/brdf/merl_sgd.csv:gold-paint" -o s.gtm && "$G" info s.gtm | grep -qx 'points: 109440' || return 1
    refused 4 'no-such-material' import "$DATA/brdf/merl_sgd.csv:no-such-material" -o out.gtm
}
if [ -r "$DATA/brdf/merl_sgd.csv" ]; then check "one material of a table of fits is imported by its name" imports_sgd
else skip "one material of a table of fits is imported by its name" "no data folder"; fi

foreign() {
    head -c 5000 "$B/gtlut" >elf && refused 4 'elf: byte' import elf -o out.gtm || return 1
    printf '\x76\x2f\x31\x01' >four.exr && refused 4 'four.exr' import four.exr --axes 2x2x1 -o out.gtm || return 1
    printf 'VARS' >vars && refused 4 'VARS must name' import vars -o out.gtm || return 1
    refused 3 'missing: No such file' import missing -o out.gtm || return 1
    refused 2 "--format: 'x' is no format; see gtlut formats" import a.csv --format x -o out.gtm
}
check "files of no format are refused" foreign

echo 1..$n
