#!/usr/bin/env bash
# What the compiler does not check: who may include what, words that have no place in freestanding code,
# format, documents. TAP on stdout.
cd "$(dirname "$0")/.." || exit 1
. tests/tap.sh
CC=${CC:-cc}

# The project's files: what git tracks or would track; in an unpacked archive, everything but the build.
project_files() { # pattern...
    local p
    if git rev-parse --is-inside-work-tree >/dev/null 2>&1; then
        git ls-files -co --exclude-standard -- "$@" | while read -r p; do [ -e "$p" ] && echo "$p"; done
    else
        for p in "$@"; do find . \( -path ./build -o -path ./.git \) -prune -o -name "$p" -type f -print | sed 's|^\./||'; done
    fi
}

without_comments() { # file
    "$CC" -fpreprocessed -dD -E -P -x c "$1" 2>/dev/null
}

# include_problems allowed_regex file...: lines "file: <header>" for includes outside the list. A quoted header is written as
# folder/name when it exists in one of the folders on the include path (beside the file first).
include_problems() {
    local allowed=$1 f header dir where
    shift
    for f in "$@"; do
        while read -r header; do
            where=$header
            for dir in "$(dirname "$f")" lut raster firmware hal hal/emulated hal/sim host_tools tests/reference; do
                case $header in '<'*) break ;; esac
                [ -e "$dir/$header" ] && { where=$dir/$header; break; }
            done
            grep -qxE "$allowed" <<<"$where" || echo "$f includes $where"
        done < <(without_comments "$f" | sed -nE 's/^ *# *include *(<[^>]*>|"[^"]*").*/\1/p' | tr -d '"')
    done
}

sources() { # folder name_regex
    find "$1" -maxdepth 1 -name '*.[ch]' | grep -E "${2:-.}" | sort
}

free='<(stdint|stddef|stdbool)\.h>'
any='<[A-Za-z0-9_/.+-]+>'
free_files=$(sources lut; sources raster; sources firmware)
gtsim_files=$(sources host_tools '/gtsim[^/]*$')
tool_files=$(sources host_tools | grep -v /gtsim)
board_files=$(find hal -mindepth 2 -name '*.[ch]' -not -path 'hal/sim/*' | sort)
tools_may="$any|lut/.*|raster/.*|firmware/usb_protocol\.h|host_tools/.*"

echo 1..15
claim lut_includes_nothing_else "$(include_problems "$free|lut/.*" $(sources lut))"
claim raster_includes_lut_only "$(include_problems "$free|(lut|raster)/.*" $(sources raster))"
claim firmware_includes_lut_raster_and_hal_h "$(include_problems "$free|(lut|raster|firmware)/.*|hal/hal\.h" $(sources firmware))"
claim hal_h_includes_nothing_else "$(include_problems "$free" $(sources hal))"
# sim_device is the simulated board's main: firmware on a board, as a library, since many live in one process.
claim sim_includes_hal_h_and_libc_and_its_main_app_h "$(
    include_problems "$any|hal/hal\.h|hal/sim/sim(_internal)?\.h" $(sources hal/sim | grep -v /sim_device)
    include_problems "$any|hal/hal\.h|hal/sim/.*|hal/costs/.*|firmware/(app|usb_protocol)\.h" $(sources hal/sim /sim_device)
)"
claim boards_include_hal_h_and_main_app_h "$(for f in $board_files; do
    own="$(dirname "$f")/.*|hal/emulated/board\.h" # what the emulated boards share
    case $f in
    */main.c) own="$own|firmware/app\.h|hal/costs/.*" ;;
    hal/costs/*) own="$own|raster/quality\.h" ;;
    esac
    include_problems "$free|hal/hal\.h|$own" "$f"
done)"
claim tools_include_lut_raster_protocol_and_libraries "$(include_problems "$tools_may" $tool_files)"
claim gtsim_includes_app_and_sim_besides "$(include_problems "$tools_may|firmware/app\.h|hal/(sim/.*|hal\.h)" $gtsim_files)"
claim reference_includes_no_product_header "$(include_problems "$any|tests/reference/.*" $(sources tests/reference))"

claim freestanding_code_has_no_float_and_no_malloc "$(for f in $free_files; do
    without_comments "$f" | sed 's/"[^"]*"//g' | grep -nwE 'float|double|malloc|calloc|realloc|free|long double|alloca' | sed "s|^|$f: |"
done)"

claim every_header_compiles_alone "$(for h in lut/*.h raster/*.h firmware/*.h hal/hal.h; do
    "$CC" -std=c11 -ffreestanding -nostdinc -isystem "$("$CC" -print-file-name=include)" -Ilut -Iraster -Ifirmware -Ihal \
        -Wall -Wextra -Werror -fsyntax-only -include "$h" -x c /dev/null 2>&1
done)"

claim c_files_are_formatted "$(project_files '*.c' '*.h' '*.cc' | while read -r f; do
    clang-format-14 --dry-run -Werror "$f" >/dev/null 2>&1 || echo "$f: run make format"
done)"
claim no_file_names_a_machine_path "$(project_files '*' | xargs grep -nIE '(^|[^A-Za-z0-9_.])/(work|root|home)/' 2>&1)"
claim documents_exist "$(for f in README.md DESIGN.md SPEC.md CHANGELOG.md CREDITS.md LICENSE hal/PORTING.md .ci/run; do
    [ -s "$f" ] || echo "missing: $f"
done)"
claim scripts_are_executable "$(for f in .ci/run $(project_files '*.sh' | xargs grep -lE '^#!'); do
    [ -x "$f" ] || echo "$f has no run bit"
done)"

long=$(project_files '*.c' '*.h' '*.cc' | xargs wc -l | awk '$2 != "total" && $1 > 600 { print "# " $1 " lines: " $2 "; does it still have one subject?" }')
[ -z "$long" ] || echo "$long"
