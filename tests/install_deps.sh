#!/bin/sh
# Installs those of the given Debian packages that are missing; says what, and that sudo is used when not root.
# A command of the package's name counts as installed: nodejs and npm often come from elsewhere.
missing=
for p in "$@"; do
    dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || command -v "$p" >/dev/null ||
        missing="$missing $p"
done
[ -n "$missing" ] || exit 0
command -v apt-get >/dev/null || { echo "missing packages:$missing; install them with your package manager" >&2; exit 1; }
sudo=
[ "$(id -u)" = 0 ] || sudo=sudo
echo "installing missing packages:${missing}${sudo:+ (with sudo)}"
$sudo apt-get update -qq || echo "apt-get update failed; trying with the lists at hand" >&2
$sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq -o DPkg::Lock::Timeout=120 --no-install-recommends $missing
