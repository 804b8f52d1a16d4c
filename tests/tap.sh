# For tests in shell: TAP lines and a scratch folder. Sourced, from the repository's root; the caller prints the plan.
set -u
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT || exit 1
n=0

claim() { # claim problems: it holds when there are none
    n=$((n + 1))
    if [ -z "$2" ]; then
        echo "ok $n - $1"
    else
        echo "not ok $n - $1"
        head -30 <<<"$2" | sed 's/^/# /'
    fi
}

check() { # claim command...: it holds when the command succeeds
    local claim=$1
    shift
    if "$@" >"$work/log" 2>&1; then claim "$claim" ""; else claim "$claim" "status $?:"$'\n'"$(cat "$work/log")"; fi
}

skip() { # claim why
    n=$((n + 1))
    echo "ok $n - $1 # SKIP $2"
}
