#!/usr/bin/env bash
# Runs a program for an emulated board and prints what it writes to its UART.
#   tests/board/run.sh TARGET PROGRAM.elf [INPUT [EMULATOR OPTION...]]
# INPUT is put into external memory, where the program finds it as board_input. Exit status: the program's; 124 when it does not end
# within LIMIT seconds.
set -u
target=$1 program=$2 input=${3-}
shift $(($# < 3 ? $# : 3))
# An instruction takes 64 ns of the ARM boards' timers; minstret of QEMU 7 counts these nanoseconds, thus 1 there.
case $target in
rv32imac) nm=riscv64-unknown-elf-nm shift=0 ;;
*) nm=arm-none-eabi-nm shift=6 ;;
esac
options=(-display none -monitor none -icount shift=$shift,align=off,sleep=off -serial stdio "$@")
if [ -n "$input" ]; then
    address=$($nm "$program" | awk '$3 == "board_input" { print "0x" $1 }')
    options+=(-device "loader,file=$input,addr=$address,force-raw=on")
fi
arm=(qemu-system-arm -semihosting-config "enable=on,target=native")
case $target in
cortex-m3) emulator=("${arm[@]}" -M mps2-an385) ;;
cortex-m4) emulator=("${arm[@]}" -M mps2-an386) ;;
cortex-m7) emulator=("${arm[@]}" -M mps2-an500) ;;
cortex-m33) emulator=("${arm[@]}" -M mps2-an521) ;;
cortex-m55) emulator=("${arm[@]}" -M mps3-an547) ;;
rv32imac) emulator=(qemu-system-riscv32 -M virt -bios none) ;;
*) echo "run.sh: no board for target $target" >&2; exit 2 ;;
esac
exec timeout --kill-after=5 "${LIMIT:-60}" "${emulator[@]}" "${options[@]}" -kernel "$program" </dev/null
