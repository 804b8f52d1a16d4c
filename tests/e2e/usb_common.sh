# For the tests of gtusb and gtsim: TAP lines, a scratch folder, the tools on the PATH, a small table.
# Sourced, from the repository's root. The demo's scene and tables come from `make demo-data`.
. tests/tap.sh
B=$(cd "${B:-build}" && pwd) || exit 1
DEMO=$B/demo
PATH=$B:$PATH
export B DEMO PATH work

ok() { # status claim [file to show on failure]...
    claim "$2" "$([ "$1" = 0 ] || { echo "status $1" && for f in "${@:3}"; do sed "s|^|${f##*/}: |" "$f" | head -20; done; })"
}

# The command ends with this exit code; stdout and stderr, whole, match these extended regular expressions ("" = empty).
expect() { # claim code stdout stderr command...
    local claim=$1 code=$2 out=$3 err=$4 got bad=0
    shift 4
    "$@" >"$work/out" 2>"$work/err" </dev/null
    got=$?
    [ $got = "$code" ] || bad=1
    [[ $(<"$work/out") =~ ^($out)$ ]] || bad=1
    [[ $(<"$work/err") =~ ^($err)$ ]] || bad=1
    [ $bad = 0 ] || echo "# exit code $got, expected $code; stdout ^($out)$, stderr ^($err)$"
    ok $bad "$claim" "$work/out" "$work/err"
}
