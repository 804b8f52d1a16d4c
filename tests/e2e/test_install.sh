#!/usr/bin/env bash
# `make install` into an empty folder: what is installed works from there, without the source tree.
. tests/tap.sh
B=$(cd "${B:-build}" && pwd) || exit 1

echo 1..7
root=$work/root
prefix=$root/opt/goniotile
check install_succeeds env -u MAKEFLAGS -u MAKELEVEL make install B="$B" DESTDIR="$root" PREFIX=/opt/goniotile

files_are_there() {
    local f missing=0
    for f in bin/gtlut bin/gtscene bin/gtusb bin/gtsim lib/libgoniotile.a lib/goniotile/goniotile_oiio.so include/goniotile/raster.h \
        include/goniotile/lut.h include/goniotile/app.h include/goniotile/hal.h lib/udev/rules.d/60-goniotile.rules \
        lib/pkgconfig/goniotile.pc share/man/man1/gtlut.1 share/man/man1/gtlut-build.1 share/doc/goniotile/README.md; do
        [ -s "$prefix/$f" ] || { echo "missing: $f"; missing=1; }
    done
    return $missing
}
check every_kind_of_file_is_installed files_are_there

nothing_outside_destdir() { # everything written lies under PREFIX
    [ "$(cd "$root" && echo * */*)" = "opt opt/goniotile" ]
}
check nothing_is_installed_outside_the_prefix nothing_outside_destdir

tools_say_their_version() {
    local t version
    version=$(sed -n 's/^#define GONIOTILE_VERSION  *"\(.*\)"/\1/p' "$prefix/include/goniotile/goniotile_version.h")
    for t in gtlut gtscene gtusb gtsim; do
        "$prefix/bin/$t" --version | grep -F "$version" || return 1
    done
}
check installed_tools_say_the_installed_version tools_say_their_version

image_is_written() ( # the image library is found beside the program, not in the source tree
    cd "$work" && "$prefix/bin/gtlut" measure matte_white -o m.csv && "$prefix/bin/gtlut" build m.csv -o m.ktx2 &&
        "$prefix/bin/gtlut" export m.ktx2 -o m.exr && [ -s m.exr ]
)
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
program_embeds_the_library() { # pkg-config from within DESTDIR, as packagers use it
    local flags
    flags=$(PKG_CONFIG_LIBDIR="$prefix/lib/pkgconfig" PKG_CONFIG_SYSROOT_DIR="$root" pkg-config --cflags --libs goniotile) &&
        ${CC:-cc} -std=c11 -Wall -Wextra -Werror "$work/embed.c" $flags -o "$work/embed" && "$work/embed" &&
        [ "$(PKG_CONFIG_LIBDIR="$prefix/lib/pkgconfig" pkg-config --variable=prefix goniotile)" = /opt/goniotile ] &&
        "$prefix/bin/gtlut" --version | grep -qwF "$(PKG_CONFIG_LIBDIR="$prefix/lib/pkgconfig" pkg-config --modversion goniotile)"
}
check pkg_config_leads_a_program_to_the_installed_headers_and_library program_embeds_the_library

pages_are_whole() { # one for each program and command, each with the sections of a page, dated by the sources
    local p
    [ "$(ls "$prefix/share/man/man1" | wc -l)" -gt 25 ] || return 1
    for p in "$prefix"/share/man/man1/*.1; do
        [ "$(grep -cE '^\.SH (NAME|SYNOPSIS|DESCRIPTION|EXAMPLES|"SEE ALSO")$' "$p")" = 5 ] &&
            sed -n '/^\.SH NAME/{n;p}' "$p" | grep -qE "^$(basename "$p" .1) .- [a-z]" || { echo "$p"; return 1; }
    done
    SOURCE_DATE_EPOCH=0 host_tools/man.sh "$work/man" "$B/gtscene" && grep -q '^\.TH GTSCENE-INFO "1" "January 1970"' "$work/man/gtscene-info.1"
}
check manual_pages_are_whole_and_reproducible pages_are_whole
