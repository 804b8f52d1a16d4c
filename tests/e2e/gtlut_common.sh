# For the tests of gtlut, which run in the scratch folder: the program, TAP lines, what it writes and refuses. Sourced, from the
# repository's root.
. tests/tap.sh
B=$(cd "${B:-build}" && pwd) || exit 1
G=$B/gtlut
DATA=$(cd "${GONIOTILE_DATA:-../shared/data}" 2>/dev/null && pwd)
READ_IMAGE=$PWD/tests/e2e/read_image.mjs
cd "$work" || exit 1

# command...: exit code 0 and nothing on stderr
quiet() {
    "$@" 2>quiet_err || { echo "exit code $?: $*"; cat quiet_err; return 1; }
    [ ! -s quiet_err ] || { echo "stderr of $*:"; cat quiet_err; return 1; }
}

# refused code pattern arguments of gtlut...: that exit code, one message with the pattern, nothing on stdout, no new file,
# and a file of the output's name as it was
refused() {
    local code=$1 pattern=$2 got before after name
    shift 2
    for name in out.csv out.gtm out.ktx2 out.png out.exr; do echo keep >$name; done
    before=$(ls -A)
    "$G" "$@" >refused_out 2>refused_err
    got=$?
    for name in out.csv out.gtm out.ktx2 out.png out.exr; do
        [ "$(cat $name 2>&1)" = keep ] || { echo "$name was changed by: $*"; return 1; }
    done
    [ $got = "$code" ] || { echo "exit code $got, not $code: $*"; cat refused_err; return 1; }
    grep -qE "^gtlut: ([a-z]+: )?.*$pattern" refused_err || { echo "no message like '$pattern': $*"; cat refused_err; return 1; }
    [ "$(wc -l <refused_err)" = 1 ] || { echo "not one line: $*"; cat refused_err; return 1; }
    [ ! -s refused_out ] || { echo "output on stdout: $*"; return 1; }
    after=$(ls -A)
    [ "$(printf '%s\n' "$before" refused_out refused_err | sort -u)" = "$(printf '%s\n' "$after" refused_out refused_err | sort -u)" ] ||
        { echo "left a file: $*"; echo "$after"; return 1; }
}
