#!/usr/bin/env bash
# Runs the firmware of the LM3S6965 board until it reports its first frame, takes the emulator's picture of the display and prints the
# report.
#   tests/board/screenshot.sh PROGRAM.elf OUT.ppm
# Exit status: 0, or 1 when no frame came within LIMIT seconds.
set -u
program=$1 picture=$2
work=$(mktemp -d) && trap 'rm -rf "$work"' EXIT
mkfifo "$work/monitor"
: >"$work/uart"
# -icount as hal/lm3s6965/board.c says
timeout --kill-after=5 "${LIMIT:-60}" qemu-system-arm -M lm3s6965evb -display none -monitor stdio -serial "file:$work/uart" \
    -semihosting-config enable=on,target=native -icount shift=7,align=off,sleep=off -kernel "$program" \
    <"$work/monitor" >"$work/log" 2>&1 &
emulator=$!
exec 9>"$work/monitor"
until grep -q '^frame .*stack [0-9][0-9]*$' "$work/uart" || ! kill -0 $emulator 2>/dev/null; do sleep 0.1; done
echo "screendump $work/picture.ppm" >&9
echo quit >&9
exec 9>&-
wait $emulator
cat "$work/uart"
[ -s "$work/picture.ppm" ] && mv "$work/picture.ppm" "$picture" && exit
cat "$work/log" >&2
exit 1
