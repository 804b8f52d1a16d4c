#!/usr/bin/env bash
# gtlut check and fit: the command line of what tests/unit/test_check.c and test_fit.c prove.
. tests/e2e/gtlut_common.sh

# sound file: exit code 0 and no line that is wanting
sound() {
    "$G" check "$@" >sound_out 2>sound_err || { echo "exit code $?: check $*"; cat sound_out sound_err; return 1; }
    ! grep '^WANTING' sound_out && [ ! -s sound_err ]
}

# wanting subject pattern file...: exit code 11 and a line of that subject
wanting() {
    local subject=$1 pattern=$2 code
    shift 2
    "$G" check "$@" >wanting_out 2>wanting_err
    code=$?
    [ $code = 11 ] || { echo "exit code $code: check $*"; cat wanting_out wanting_err; return 1; }
    grep -qE "^WANTING +$subject +.*$pattern" wanting_out || { echo "no $subject like $pattern: check $*"; cat wanting_out; return 1; }
}

"$G" measure plastic_yellow -o y.csv || exit 1
edit() { awk -F, -v OFS=, "/^[0-9]/ { $1 } { print }" y.csv; }

passes() {
    local m
    for m in $("$G" measure --list | cut -d' ' -f1); do
        "$G" measure "$m" -o m.csv && sound m.csv || { echo "material $m"; return 1; }
    done
    sound - <y.csv
}
check "no fault is found in any material of the virtual instrument" passes

finds() {
    edit '$2 == 30 && $3 == 200 && $1 == 40 { }' >/dev/null
    edit 'if ($1 == 40 && $2 == 30 && $3 == 200) $5 = "nan"; if ($1 == 40 && $2 == 31 && $3 == 200) $5 = "-inf"' >bad.csv
    wanting finite '1 samples not a number, 1 infinite' bad.csv || return 1
    edit 'if ($1 == 40 && $2 == 30 && $3 >= 200 && $3 < 210) $6 = -0.1' >bad.csv && wanting negative '10 samples' bad.csv || return 1
    edit 'if ($1 == 20 && $2 == 60 && $3 == 77) $5 = 9' >bad.csv && wanting outliers '1 samples' bad.csv || return 1
    edit 'if ($1 == 20 && $2 == 60 && $3 == 77) next' >bad.csv && wanting coverage '1 samples missing' bad.csv || return 1
    edit 'if ($1 == 20 && $2 == 60) next' >bad.csv && wanting coverage '360 samples missing' bad.csv || return 1
    edit 'if ($1 == 20) next' >bad.csv && wanting coverage 'theta_in 40 stands where equal steps' bad.csv || return 1
    { cat y.csv; tail -1 y.csv; } >bad.csv && wanting coverage '0 samples missing, 1 twice' bad.csv || return 1
    edit '$4 *= 2; $5 *= 2; $6 *= 2' >bad.csv && wanting energy 'theta_in 60: albedo 1\.' bad.csv || return 1
    edit 'if ($1 == 20) $5 *= 3' >bad.csv && wanting reciprocity 'relative error 0\.[3-9]' bad.csv || return 1
    edit 'if ($3 % 180) next' >bad.csv && wanting coverage 'phi_out lie up to 180 degrees apart' bad.csv || return 1
    edit 'if ($1 > 0 && ($2 - $1) ^ 2 + (($3 > 180 ? 360 - $3 : $3) * sin($1 * 0.01745)) ^ 2 < 25) $4 = $5 = $6 = 0' >bad.csv
    wanting blind_spot '[45]\.[0-9] degrees around the light hold nothing' bad.csv
}
check "gaps, doubles, NaN, negative values, outliers, too much energy, broken reciprocity and the blind spot are found" finds

cosines() {
    edit 'c = cos($2 * 0.01745329252); $4 *= c; $5 *= c; $6 *= c' >times.csv
    edit 'c = cos($2 * 0.01745329252); $4 /= c; $5 /= c; $6 /= c' >over.csv
    wanting quantity 'times cos.theta_out.: divide' times.csv && wanting quantity 'once too often' over.csv || return 1
    for f in times over; do
        "$G" check $f.csv --repair -o $f.gtm >/dev/null 2>err
        [ $? = 11 ] && grep -qE 'values (divided|multiplied) by cos' err || { cat err; return 1; }
        sound $f.gtm || return 1
        "$G" build $f.gtm --size 46x46 -o $f.ktx2 2>/dev/null || return 1
    done
    "$G" build y.csv --size 46x46 -o y.ktx2 2>/dev/null
    # the same table but for the last bit of a few texels
    cmp -l <(tail -c 30000 y.ktx2) <(tail -c 30000 times.ktx2) | awk '{ n++ } END { print n + 0, "bytes differ"; exit n > 300 }'
}
check "a cosine too much or too little is told apart and undone by --repair" cosines

cosines_real() {
    local m
    for m in paper_white cc_ibiza_sunset satin_rosaline colodur_napoli_4f; do
        "$G" check "$DATA/brdf/${m}_rgb.bsdf" --json >real.json
        grep -q '"quantity": "brdf"' real.json || { echo "$m"; cat real.json; return 1; }
    done
}
if [ -r "$DATA/brdf/paper_white_rgb.bsdf" ]; then
    check "real materials are taken for the BRDFs that they are" cosines_real
else
    skip "real materials are taken for the BRDFs that they are" "no data folder"
fi

repairs() {
    edit 'if ($1 > 0 && ($2 - $1) ^ 2 + (($3 > 180 ? 360 - $3 : $3) * sin($1 * 0.01745)) ^ 2 < 25) next
        if ($1 == 40 && $2 == 30 && $3 == 200) $5 = "nan"; if ($1 == 20 && $2 == 60 && $3 == 77) $5 = 9; if ($1 == 20 && $2 == 60 && $3 == 78) $6 = -9' >bad.csv
    "$G" check bad.csv --repair -o fixed.gtm >out 2>err
    [ $? = 11 ] && grep -qE '[0-9]+ samples filled by interpolation and marked' err || { cat err; return 1; }
    sound fixed.gtm && grep -qE 'coverage +0 samples missing.* [1-9][0-9]+ filled in before' sound_out || { cat sound_out; return 1; }
    "$G" check bad.csv --repair -o - 2>/dev/null | cmp - fixed.gtm || return 1
    refused 2 'no output file; give -o' check y.csv --repair && refused 2 '-o: only with --repair' check y.csv -o x.gtm || return 1
    refused 2 'stdout holds the JSON' check y.csv --json --repair -o -
}
check "--repair writes a measurement without the faults, filled samples marked" repairs

as_json() {
    "$G" check y.csv --json >good.json 2>err || { cat err; return 1; }
    "$G" check times.csv --json >bad.json 2>err
    [ $? = 11 ] && [ ! -s err ] || { cat err; return 1; }
    node -e 'const r = f => JSON.parse(require("fs").readFileSync(f)), a = r("good.json"), b = r("bad.json");
        const ok = a.wanting.length == 0 && a.points == 109440 && a.slices.length == 4 && a.slices[3].theta_in == 60 && a.quantity == "brdf" &&
            b.wanting.includes("quantity") && b.quantity == "times_cosine" && Math.abs(b.exponent - 1) < 0.1;
        if (!ok) { console.log(a, b); process.exit(1) }'
}
if command -v node >/dev/null; then check "--json says the same" as_json; else skip "--json says the same" "no node"; fi

plots() {
    "$G" check bad.csv --plot page.svg >/dev/null 2>err
    [ $? = 11 ] && [ ! -s err ] || { cat err; return 1; }
    head -1 page.svg | grep -q '^<?xml' && grep -q '</svg>' page.svg || return 1
    for text in 'Plane of incidence' 'Albedo over the angle of incidence' 'Reciprocity error' 'blind spot' 'bad.csv'; do
        grep -q "$text" page.svg || { echo "no '$text' on the page"; return 1; }
    done
    mkdir -p "it's" && "$G" check y.csv --plot "it's" >/dev/null && [ -s "it's/check.svg" ] || return 1
    no_page 2 "'page.png' is neither a folder nor" page.png || return 1
    no_page 3 'none/p.svg: No such file' none/p.svg || return 1
    mkdir -p no_gnuplot && for c in sh head; do ln -sf "$(command -v $c)" no_gnuplot/; done
    PATH=$PWD/no_gnuplot no_page 3 'install gnuplot' kept.svg && [ ! -e kept.svg ]
}
no_page() { # code message file: the report, but no page; with the caller's PATH for gtlut only
    "$G" check y.csv --plot "$3" >refused_out 2>refused_err
    local got=$? text
    text=$(<refused_err)
    [ $got = "$1" ] && [[ $text == *"$2"* ]] || { echo "exit code $got: $text"; return 1; }
}
if command -v gnuplot >/dev/null; then check "--plot draws a page, into a folder too" plots; else skip "--plot draws a page" "no gnuplot"; fi

usage() {
    refused 2 '0 arguments where one' check && refused 2 'unknown option' check y.csv --melt || return 1
    refused 2 "--max-reciprocity: '3' is not a number from 0 to 2" check y.csv --max-reciprocity 3 || return 1
    edit 'if ($1 == 20) $5 *= 1.1' >skewed.csv && sound skewed.csv && wanting reciprocity 'relative error 0.0' skewed.csv --max-reciprocity 0.01 || return 1
    refused 3 'missing: No such file' check missing && refused 4 'no samples' check /dev/null || return 1
    "$G" check --help | grep -q 'Usage: gtlut check' && "$G" fit --help | grep -q 'Usage: gtlut fit' || return 1
    refused 2 'no model; give --model' fit y.csv && refused 2 "--model: 'x' is not" fit y.csv --model x || return 1
    refused 2 'leave it out' fit y.csv --model ggx -o x && refused 4 'no samples' fit /dev/null --model ggx
}
check "wrong arguments are refused, limits are obeyed, help is given" usage

# One model's fit goes into a scene as it is printed.
fits() {
    local model
    for model in lafortune_phong blinn_phong ggx; do
        "$G" fit y.csv --model $model >fit.out 2>err && [ ! -s err ] || { cat err; return 1; }
        head -1 fit.out >material && grep -qE '^error: 0\.[0-9]+$' fit.out && grep -qE '^mean dE: ' fit.out || { cat fit.out; return 1; }
        "$G" fit y.csv --model $model | cmp - fit.out || { echo "not the same again"; return 1; }
        cat >scene.json <<S
{"meshes": [{"name": "ball", "shape": "sphere"}], "materials": [$(cat material)],
 "objects": [{"mesh": "ball", "material": "y"}], "lights": [{"direction": [0, 0, 1], "irradiance": [3, 3, 3]}],
 "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "fov_y": 40}}
S
        "$B/gtscene" build scene.json -o scene.blob || { cat material; return 1; }
        [ $model != ggx ] || grep -qE '^error: 0\.0' fit.out || { cat fit.out; return 1; }
    done
    "$G" fit y.csv --model ggx --json | grep -q '"material": {"name": "y", "model": "metallic_roughness"'
}
check "fit prints a material that a scene takes, the same every time; GGX comes nearest to a GGX plastic" fits

echo 1..$n
