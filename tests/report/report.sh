#!/usr/bin/env bash
# Runs the report's chapters, tests/report/[0-9]*.sh, or those whose numbers are given, and joins all that there are in
# $B/report/REPORT.md. Each takes common.sh, prints its Markdown, and leaves pictures, plots and CSV in $B/report under names that begin
# with its number. Environment: B (build folder), GONIOTILE_DATA, QUICK (non-empty: as small as a test needs).
#   tests/report/report.sh [NUMBER...]
set -eu
cd "$(dirname "$0")/../.."
export B=${B:-build}
out=$B/report
for program in "$B/gtlut" "$B/report_pixels" "$B/demo/gold.ktx2"; do
    [ -e "$program" ] || { echo "report: $program is not there; make report builds what chapters call" >&2; exit 1; }
done
mkdir -p "$out"
for chapter in tests/report/[0-9]*.sh; do
    name=$(basename "${chapter%.sh}")
    number=${name%%_*}
    [ $# = 0 ] || [[ " $* " == *" $number "* ]] || continue
    rm -f "$out/$number"_* "$out/$number.md"
    TIMEFORMAT='%R %U %S'
    { time "$chapter" >"$out/$number.new"; } 2>"$out/$number.log" || { cat "$out/$number.log" >&2; echo "report: $chapter failed" >&2; exit 1; }
    took=$(tail -1 "$out/$number.log" | awk '{ printf "%.0f s (%.0f s of processors)", $1, $2 + $3 }')
    head -n -1 "$out/$number.log" >&2
    rm "$out/$number.log"
    printf '\n*This chapter: `tests/report/report.sh %s`, %s.*\n' "$number" "$took" >>"$out/$number.new"
    mv "$out/$number.new" "$out/$number.md"
    echo "report: chapter $name: $took"
done
{
    echo '# Experiments'
    echo
    echo "Goniotile $("$B/gtlut" --version | awk 'NR == 1 { print $NF }'), on $(awk -F': ' '/^model name/ { print $2; exit }' /proc/cpuinfo | tr -s ' '), $(nproc) processors; boards emulated by QEMU, which counts instructions."
    echo 'The papers: Cezner and Havran, *Utilizing Measured Reflectance for Real-time Rendering in Game Engines* (2024); James, *Physically'
    echo 'Based Shading Models in Real-time Rendering* (2022). Their figures stand beside ours as numbers or, where only a plot was printed, as the text that describes it.'
    cat $(ls "$out"/[0-9]*.md | sort -V)
} >"$out/REPORT.new"
mv "$out/REPORT.new" "$out/REPORT.md"
echo "written: $out/REPORT.md"
