#!/usr/bin/env bash
# Runs every fuzz harness from the seeds in tests/fuzz/corpus, FUZZ_SECONDS each (2 in `make check`, 600 in `make fuzz`), JOBS at a time
# (1); then prints how much of the parsers they reached. TAP on stdout. FUZZ_KEEP=1 goes on from the inputs found before and keeps the
# new ones, in $B/fuzz/corpus. What a finding takes is left in $B/fuzz/found.
cd "$(dirname "$0")/../.." || exit 1
B=${B:-build} S=${FUZZ_SECONDS:-2}
programs=$(find "$B/fuzz" -maxdepth 1 -name 'fuzz_*' -type f -executable 2>/dev/null | sort)
if [ -z "$programs" ]; then
    echo 1..1
    echo "ok 1 - fuzzing finds nothing # SKIP clang-14 has no libFuzzer here: libclang-rt-14-dev brings it"
    exit 0
fi
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT || exit 1
mkdir -p "$B/fuzz/found"

fuzz_one() { # program
    local name=${1##*/fuzz_} keep=$work/${1##*/}
    [ -z "${FUZZ_KEEP:-}" ] || keep=$B/fuzz/corpus/$name
    mkdir -p "$keep"
    LLVM_PROFILE_FILE=$work/$name.profraw "$1" -max_total_time="$S" -max_len=6000 -timeout=20 -rss_limit_mb=1500 -seed=1 \
        -close_fd_mask=3 -print_final_stats=1 -artifact_prefix="$B/fuzz/found/$name-" "$keep" "tests/fuzz/corpus/$name" \
        >"$work/$name.log" 2>&1
    echo $? >"$work/$name.rc"
}
export -f fuzz_one
export B S work
# shellcheck disable=SC2086
printf '%s\n' $programs | xargs -P "${JOBS:-1}" -I{} bash -c 'fuzz_one {}'

n=0
echo "1..$(wc -w <<<"$programs")"
for p in $programs; do
    name=${p##*/fuzz_} n=$((n + 1))
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "$work/$name.log")
    if [ "$(cat "$work/$name.rc")" = 0 ] && [ "${runs:-0}" -gt 0 ]; then
        echo "ok $n - fuzzing_${name}_finds_nothing"
    else
        echo "not ok $n - fuzzing_${name}_finds_nothing"
        grep -v '^#[0-9]' "$work/$name.log" | tail -40 | sed 's/^/# /'
    fi
    echo "# $name: ${runs:-no} runs in $S s"
done

parsers="lut/ktx2.c lut/lut.c lut/half_vector.c lut/specular_frame.c raster/scene.c firmware/usb_device.c firmware/protocol.c
    firmware/messages.c firmware/content.c firmware/table_store.c host_tools/host_measurement.c host_tools/host_rgl.c
    host_tools/host_merl.c host_tools/host_composite.c host_tools/host_astm.c host_tools/host_zemax.c host_tools/host_cornell.c
    host_tools/host_source.c host_tools/host_csv.c host_tools/host_text.c host_tools/host_atlas.c"
if command -v llvm-profdata-14 llvm-cov-14 >/dev/null && llvm-profdata-14 merge -o "$work/all" "$work"/*.profraw 2>/dev/null; then
    first=${programs%%$'\n'*}
    # shellcheck disable=SC2046,SC2086
    llvm-cov-14 report "$first" $(printf -- '-object %s ' $programs) -instr-profile="$work/all" $parsers 2>/dev/null |
        awk '$1 ~ /\.c$/ || $1 == "TOTAL" { printf "# coverage %-22s %6s of %4d lines, %s of regions\n", $1, $10, $8, $4 }'
fi
