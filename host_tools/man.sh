#!/bin/sh
# Manual pages out of --help: one for each program and for each of its commands (gtlut.1, gtlut-build.1, ...).
#   host_tools/man.sh FOLDER PROGRAM...
set -eu
# Pages are as old as the last change, so that equal sources give equal pages.
export LC_ALL=C SOURCE_DATE_EPOCH="${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || stat -c %Y CHANGELOG.md)}"
out=$1
shift
mkdir -p "$out"
rm -f "$out"/*.1
see=$out/see_also.tmp
trap 'rm -f "$see"' EXIT

# Lines "name purpose" of the commands that a help text lists.
commands() { # command line
    $1 --help | awk '/^Commands:/ { on = 1; next } /^$/ { on = 0 } on { name = $1; sub(/^ .*[^ ]  +/, ""); print name, $0 }'
}

page() { # command line, name of the page, purpose, page above
    commands "$1" >"$out/$2.tmp"
    {
        echo '[see also]'
        awk -v page="$2" -v above="$4" '
            { list = list sep ".BR " page "-" $1 " (1)"; sep = ",\n" }
            END { print above == "" ? list : ".BR " above " (1)" (list == "" ? "" : ",\n" list) }' "$out/$2.tmp"
    } >"$see"
    help2man --no-info --include="$see" --source="Goniotile $version" --version-string="$version" --name="$3" "$1" |
        sed "s/^\.TH [^0-9]* \"1\"/.TH $(echo "$2" | tr a-z A-Z) \"1\"/; /^\.SH NAME/{n;s/.* \\\\-/$2 \\\\-/}" >"$out/$2.1"
    while read -r name purpose <&3; do
        page "$1 $name" "$2-$name" "$purpose" "$2"
    done 3<"$out/$2.tmp"
    rm "$out/$2.tmp"
}

for program; do
    version=$("$program" --version | cut -d' ' -f2)
    # The first sentence after the usage.
    purpose=$("$program" --help | sed -n '2,${/./{s/\.$//;s/^./\l&/;p;q}}')
    page "$program" "${program##*/}" "$purpose" ''
done
