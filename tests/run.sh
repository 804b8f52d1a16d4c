#!/usr/bin/env bash
# Runs every test program and script, as many at a time as there are processors, and counts their TAP lines.
# Environment: B (build folder), GONIOTILE_DATA (folder of real measurements; tests that need it skip without).
# Arguments: path fragments; only tests whose path contains one are run. Example: tests/run.sh unit/test_func
# Last line: "N passed, N failed, N skipped"; exit status 1 when something failed or nothing ran.
set -u
LIMIT=${LIMIT:-600} # seconds per program

# Counts the TAP lines of one program's output: "passed failed skipped". Each test that the plan promised and that
# was not reported failed; so did a program without plan, or one that ended badly without saying why.
tap_count() { # output_file exit_code
    awk -v code="$2" '
        /^1\.\.[0-9]+/ { plan += substr($1, 4); plans++; next }
        /^(not )?ok [0-9]+.*# *SKIP/ { skipped++; next }
        /^ok [0-9]+/ { passed++; next }
        /^not ok [0-9]+/ { failed++ }
        END {
            seen = passed + failed + skipped
            if (plan > seen) failed += plan - seen
            if (!failed && (!plans || seen != plan || code != 0)) failed = 1
            print passed + 0, failed + 0, skipped + 0
        }' "$1"
}

run_one() { # test
    local test=$1 out=$OUT/${1//\//_} program=$1 start code passed failed skipped line
    case $test in
    *.sh) ;;
    *.c) program=$B/${test%.c} ;;
    esac
    start=$(date +%s%N)
    { timeout --kill-after=5 $LIMIT "$program" >"$out.log" 2>"$out.err" </dev/null; } 2>/dev/null
    code=$?
    read -r passed failed skipped < <(tap_count "$out.log" $code)
    line=$(awk -v t="$test" -v p="$passed" -v f="$failed" -v s="$skipped" -v ns=$(($(date +%s%N) - start)) \
        'BEGIN { printf "%-44s %4d passed %3d failed %3d skipped %7.1f s", t, p, f, s, ns / 1e9 }')
    echo "$passed $failed $skipped" >"$out.count"
    {
        flock 9
        echo "$line"
        grep -E '^(not )?ok [0-9]+.*# *SKIP' "$out.log" | sed 's/^/    /'
        if [ "$failed" != 0 ]; then
            case $code in
            0) ;;
            124 | 137) echo "    ended by the time limit of $LIMIT s" ;;
            *) echo "    exit status $code" ;;
            esac
            sed 's/^/    | /' "$out.log" | tail -60
            sed 's/^/    ! /' "$out.err" | tail -60
        fi
    } 9>"$OUT/lock"
}

if [ "${1-}" = --one ]; then
    run_one "$2"
    exit 0
fi

cd "$(dirname "$0")/.." || exit 1
mkdir -p "${B:=build}" && B=$(cd "$B" && pwd) || exit 1
GONIOTILE_DATA=${GONIOTILE_DATA:-../shared/data}
[ ! -d "$GONIOTILE_DATA" ] || GONIOTILE_DATA=$(cd "$GONIOTILE_DATA" && pwd)
export B GONIOTILE_DATA GONIOTILE_SIX_MODELS=$B/demo/six_models.blob GONIOTILE_DEMO=$B/demo
export CMOCKA_MESSAGE_OUTPUT=TAP LC_ALL=C UBSAN_OPTIONS=print_stacktrace=1
OUT=$(mktemp -d) && trap 'rm -rf "$OUT"' EXIT || exit 1
export OUT

# Longest first, so that the end is not spent waiting for one of them.
tests=()
for t in tests/e2e/test_*.sh tests/fuzz/test_*.sh tests/cross.sh tests/exhaustive/test_*.c tests/golden/test_*.c tests/budget/test_*.c \
    tests/fault/test_*.c tests/hard_cases/test_*.c tests/unit/test_*.c tests/lint.sh; do
    [ -e "$t" ] || continue
    [ $# = 0 ] && tests+=("$t")
    for fragment in "$@"; do
        case $t in *"$fragment"*) tests+=("$t") && break ;; esac
    done
done
[ ${#tests[@]} = 0 ] || printf '%s\0' "${tests[@]}" | xargs -0 -n 1 -P "${JOBS:-$(nproc)}" tests/run.sh --one

summary=$(cat "$OUT"/*.count 2>/dev/null | awk '{ p += $1; f += $2; s += $3; n++ }
    END { printf "%d passed, %d failed, %d skipped", p, f, s; exit f || !n || !(p + s) }')
bad=$?
[ "$(ls "$OUT"/*.count 2>/dev/null | wc -l)" = ${#tests[@]} ] || { echo "some tests did not report"; bad=1; }
echo "$summary" | tee "$B/check.summary"
exit $bad
