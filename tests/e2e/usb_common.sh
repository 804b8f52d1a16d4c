# For the tests of gtusb and gtsim: TAP lines, a scratch folder, the tools on the PATH, a small table.
# Sourced, from the repository's root. The demo's scene and tables come from `make demo-data`.
set -u
B=$(cd "${B:-build}" && pwd) || exit 1
DEMO=$B/demo
PATH=$B:$PATH
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT
export B DEMO PATH work
n=0

ok() { # status claim [file to show on failure]...
    local status=$1 claim=$2
    shift 2
    n=$((n + 1))
    if [ "$status" = 0 ]; then
        echo "ok $n - $claim"
    else
        echo "not ok $n - $claim"
        for f in "$@"; do sed "s|^|# ${f##*/}: |" "$f" | head -20; done
    fi
}

skip() { # claim why
    n=$((n + 1))
    echo "ok $n - $1 # SKIP $2"
}

check() { # claim command...
    local claim=$1
    shift
    "$@" >"$work/log" 2>&1
    ok $? "$claim" "$work/log"
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
