#!/bin/sh
# lut/ and raster/ as one header and one source, goniotile.h and goniotile.c, for those who embed them.
#   host_tools/amalgamate.sh FOLDER PUBLIC_HEADER...
# Every #include "..." gives way to the file, once. What only the library's own files share becomes static: functions that the
# other headers declare, and tables. A function declared as `extern` is one in assembly and stays as it is. That names of static
# functions and types are unique, and that nothing else is visible, tests/e2e/test_amalgamation.sh sees to.
set -eu
out=$1
shift

program='
function name_of(path) { sub(/.*\//, "", path); return path }

# The first line of a declaration in a header. Sources are formatted: nothing else begins so in the first column.
function declares(line) {
    return line ~ /^[a-z]/ && line !~ /^(static|typedef|extern|enum) |^struct [a-z0-9_]+( \{|;)/
}

function expand(path, internal,    line, part) {
    if (done[path]++) return
    print "\n/* --- " path " --- */"
    while ((getline line < path) > 0) {
        if (line ~ /^#include "/) {
            split(line, part, "\"")
            expand(header[part[2]], internal)
            continue
        }
        if (internal && path ~ /h$/ && declares(line)) line = "static " line
        if (internal && line ~ /^(extern )?const [a-z0-9_]+ [a-z0-9_]+\[/) {
            sub(/^extern /, "", line)
            line = "static " line
        }
        print line
    }
    close(path)
}

BEGIN {
    for (i = 1; i < ARGC; i++) if (ARGV[i] ~ /h$/) header[name_of(ARGV[i])] = ARGV[i]
    count = split(public_headers, public, " ")
    if (what == "goniotile.h") {
        for (i = 1; i <= count; i++) expand(public[i], 0)
        exit
    }
    for (i = 1; i <= count; i++) done[public[i]] = 1
    print "#include \"goniotile.h\""
    print "\n/* Variants for other processors are declared, too. */\n#pragma GCC diagnostic ignored \"-Wunused-function\""
    for (i = 1; i < ARGC; i++) expand(ARGV[i], 1)
}'

mkdir -p "$out"
for what in goniotile.h goniotile.c; do
    {
        echo '/*'
        echo ' * Goniotile: all of lut/ and raster/ in one file, made by `make amalgamation`. Not to be edited.'
        echo ' *'
        sed 's/^/ * /; s/ *$//' LICENSE
        echo ' */'
        awk -v what=$what -v public_headers="$*" "$program" lut/*.h raster/*.h lut/*.c raster/*.c
    } >"$out/$what.new"
    mv "$out/$what.new" "$out/$what"
done
