#!/usr/bin/env bash
# `make install` into an empty folder: what is installed works from there, without the source tree.
set -u
B=${B:-build}
B=$(cd "$B" && pwd) || exit 1
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT
n=0

check() { # claim command...
    n=$((n + 1))
    local claim=$1
    shift
    if "$@" >"$work/log" 2>&1; then
        echo "ok $n - $claim"
    else
        echo "not ok $n - $claim"
        sed 's/^/# /' "$work/log"
    fi
}

echo 1..6
root=$work/root
check install_succeeds env -u MAKEFLAGS -u MAKELEVEL make install B="$B" DESTDIR="$root" PREFIX=/usr

files_are_there() {
    local f missing=0
    for f in bin/gtlut bin/gtscene bin/gtusb bin/gtsim lib/libgoniotile.a lib/goniotile/goniotile_oiio.so include/goniotile/raster.h \
        include/goniotile/lut.h include/goniotile/app.h include/goniotile/hal.h lib/udev/rules.d/60-goniotile.rules \
        share/doc/goniotile/README.md; do
        [ -s "$root/usr/$f" ] || { echo "missing: $f"; missing=1; }
    done
    return $missing
}
check every_kind_of_file_is_installed files_are_there

nothing_outside_destdir() { # everything written lies under PREFIX
    [ "$(ls "$root")" = usr ]
}
check nothing_is_installed_outside_the_prefix nothing_outside_destdir

tools_say_their_version() {
    local t version
    version=$(sed -n 's/^#define GONIOTILE_VERSION  *"\(.*\)"/\1/p' "$root/usr/include/goniotile/goniotile_version.h")
    for t in gtlut gtscene gtusb gtsim; do
        "$root/usr/bin/$t" --version | grep -F "$version" || return 1
    done
}
check installed_tools_say_the_installed_version tools_say_their_version

image_is_written() { # the image library is found beside the program, not in the source tree
    cd "$work" && "$root/usr/bin/gtlut" measure matte_white -o m.csv && "$root/usr/bin/gtlut" build m.csv -o m.ktx2 &&
        "$root/usr/bin/gtlut" export m.ktx2 -o m.exr && [ -s m.exr ]
}
check installed_gtlut_writes_an_image image_is_written

cat >"$work/embed.c" <<'C'
#include "app.h"
#include "raster.h"
int main(void)
{
    struct scene s;
    struct lut_table t;
    static const uint32_t nothing[64];
    return scene_open(&s, nothing, sizeof nothing) == SCENE_OK || lut_open(&t, nothing, sizeof nothing) == LUT_OK;
}
C
program_embeds_the_library() {
    ${CC:-cc} -std=c11 -Wall -Wextra -Werror -I"$root/usr/include/goniotile" "$work/embed.c" -L"$root/usr/lib" -lgoniotile \
        -o "$work/embed" && "$work/embed"
}
check a_program_builds_against_the_installed_headers_and_library program_embeds_the_library
