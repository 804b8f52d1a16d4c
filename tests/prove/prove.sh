#!/usr/bin/env bash
# Runs Frama-C's Eva over the parsers and the evaluation, from drivers of unknown inputs, and compares its alarms with those that
# explained.txt accounts for: an alarm that it does not name, or a name that no longer occurs, fails. Prints the counts.
cd "$(dirname "$0")/../.." || exit 1
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT || exit 1
bad=0 total=0

prove() { # driver precision file...
    local driver=$1 precision=$2 n
    shift 2
    if ! frama-c -c11 -machdep gcc_x86_32 \
        -cpp-extra-args="-Ilut -Iraster -Ifirmware -Ihal -Itests/prove -include tests/prove/prove.h" \
        -eva -eva-precision "$precision" "tests/prove/prove_$driver.c" "$@" -then -report-csv "$work/$driver.csv" >"$work/$driver.log" 2>&1; then
        tail -20 "$work/$driver.log"
        bad=1
        return
    fi
    # One line per driver, file, function and kind: inlining's copies (_2) count as the function.
    awk -F'\t' -v d="$driver" 'NR > 1 && ($6 == "Unknown" || $6 ~ /nvalid/) && $2 != "__fc_gcc_builtins.h" {
        sub(/_[0-9]+$/, "", $4); gsub(/ /, "_", $5); print d, $2, $4, $5 }' "$work/$driver.csv" >"$work/$driver.alarms"
    sort -u "$work/$driver.alarms" >>"$work/found"
    n=$(wc -l <"$work/$driver.alarms") total=$((total + n))
    echo "$driver: $(grep -oE '[0-9]+ statements reached.*' "$work/$driver.log" | head -1 | tr -d .), $n alarms"
}

# Frama-C reads no u"" strings: their characters do not matter here.
sed 's/= u"[^"]*"/= {0}/' firmware/usb_device.c >"$work/usb_device.c"
lut="lut/lut.c lut/ktx2.c lut/half_vector.c lut/specular_frame.c lut/interpolate.c lut/func.c lut/func_tables.c"
# shellcheck disable=SC2086
{
    prove open 5 $lut
    prove eval 3 $lut
}
prove usb 4 "$work/usb_device.c"
prove protocol 3 firmware/protocol.c

sort -u "$work/found" >"$work/found.sorted"
grep -vE '^(#|$|  )' tests/prove/explained.txt | sort -u >"$work/explained"
comm -23 "$work/found.sorted" "$work/explained" | sed 's/^/not explained: /' >"$work/difference"
comm -13 "$work/found.sorted" "$work/explained" | sed 's/^/explained, but does not occur: /' >>"$work/difference"
cat "$work/difference"
[ ! -s "$work/difference" ] || bad=1
echo "$total alarms in all, $(grep -c 'not explained' "$work/difference") places not explained"
exit $bad
