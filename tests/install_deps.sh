#!/bin/sh
# Installs the Debian packages given that are missing; says what and why sudo is used.
missing=
for p in "$@"; do
    dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing="$missing $p"
done
[ -n "$missing" ] || exit 0
command -v apt-get >/dev/null || { echo "missing packages:$missing; install them with your package manager" >&2; exit 1; }
sudo=
[ "$(id -u)" = 0 ] || sudo=sudo
echo "installing missing packages:${missing}${sudo:+ (with sudo)}"
$sudo apt-get update -qq || echo "apt-get update failed; trying with the lists at hand" >&2
DEBIAN_FRONTEND=noninteractive $sudo apt-get install -y -qq --no-install-recommends $missing
