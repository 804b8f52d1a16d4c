# What the tests of gtscene share. To be sourced from the repo root.
. tests/tap.sh
B=${B:-build}
G=$B/gtscene

# refused code pattern command...: that exit code, the pattern in one message on stderr, nothing on stdout, no file and no part of one
refused() {
    local code=$1 pattern=$2 got
    shift 2
    "$@" >"$work/out" 2>"$work/err"
    got=$?
    cat "$work/err"
    [ $got = "$code" ] || { echo "exit code $got, not $code"; return 1; }
    [ "$(wc -l <"$work/err")" = 1 ] && grep -qE -e "$pattern" "$work/err" || { echo "no single message like: $pattern"; return 1; }
    [ ! -s "$work/out" ] || { echo "output on stdout"; return 1; }
    [ ! -e "$work/x.blob" ] && [ -z "$(find "$work" -name '.*tmp*')" ] || { echo "left an output file"; return 1; }
}
