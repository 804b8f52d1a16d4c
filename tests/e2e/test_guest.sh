#!/usr/bin/env bash
# The real USB stack: in a Linux machine (QEMU), gtusb goes through libusb, usbfs and xHCI to two devices on its bus, the simulated one
# and the firmware on an emulated Cortex-M4, each behind the bridge in tests/guest. What happens there is tests/guest/scenario.sh; this
# starts everything and prints the lines that the machine wrote to its serial line.
. tests/e2e/usb_common.sh

cannot() {
    echo 1..1
    skip "$1" "$2"
    exit 0
}
claim=linux_sees_the_device_through_usbfs_and_xhci
command -v qemu-system-x86_64 >/dev/null || cannot $claim "no qemu-system-x86_64"
kernel=${GUEST_KERNEL:-$B/guest/kernel}
why=$(tests/guest/kernel.sh "$kernel" 2>&1)
case $? in
0) ;;
75) cannot $claim "no kernel: $why" ;;
*) echo "# $why" ;;
esac

tables=() slot=0
for t in matte_white plastic_red gold plastic_blue_rough copper_satin satin_green; do
    tables+=(--table "$slot=$DEMO/$t.ktx2")
    slot=$((slot + 1))
done
"$B/guest/gtsim" render "$DEMO/six_models.blob" "${tables[@]}" -o "$work/expected.png" || exit 1

mkdir -p "$work"/initrd/{bin,host,modules} && chmod 755 "$work"
cp "$(command -v busybox)" "$work/initrd/bin/busybox"
cp "$kernel"/*.ko "$work/initrd/modules/"
install -m 755 tests/guest/init "$work/initrd/init"
printf 'export %s\n' "PATH='$PATH'" "B='$B'" TMPDIR=/mnt LC_ALL=C "EXPECTED='$work/expected.png'" "SOURCE='$PWD'" \
    "PROGRAM='$PWD/tests/guest/scenario.sh'" >"$work/initrd/parameters"
(cd "$work/initrd" && find . | cpio -o -H newc --quiet) >"$work/initrd.cpio"

# The board's flash is erased, and outlives each run of its emulator.
head -c 16777216 /dev/zero | tr '\0' '\377' >"$work/memory"
board=(qemu-system-arm -M mps2-an386,memory-backend=memory -object "memory-backend-file,id=memory,size=16M,mem-path=$work/memory,share=on"
    -display none -monitor none -serial "file:$work/board.log" -semihosting-config enable=on,target=native
    -kernel "$B/board/cortex-m4/mps2.elf")
"$B/guest/bridge" "$work/usb1" "$work/orders1" sim 2>"$work/bridge1.log" </dev/null &
bridges=$!
"$B/guest/bridge" "$work/usb2" "$work/orders2" board "$work/memory" "${board[@]}" 2>"$work/bridge2.log" </dev/null &
bridges="$bridges $!"
for s in usb1 orders1 usb2 orders2; do
    for ((i = 0; i < 200; i++)); do [ -S "$work/$s" ] && break || sleep 0.05; done
done

# Serial lines: what it says, and the orders to the bridges.
machine=(qemu-system-x86_64 -accel tcg -cpu max -M q35 -m 512 -smp 1 -nodefaults -no-user-config -no-reboot -display none
    -kernel "$kernel/vmlinuz" -initrd "$work/initrd.cpio" -append "console=ttyS0 loglevel=3 panic=-1 mitigations=off"
    -fsdev "local,id=host,path=/,security_model=none,readonly=on,multidevs=remap" -device virtio-9p-pci,fsdev=host,mount_tag=host
    -serial "file:$work/said" -device qemu-xhci,id=usb)
for i in 1 2; do
    machine+=(-chardev "socket,id=orders$i,path=$work/orders$i" -serial "chardev:orders$i"
        -chardev "socket,id=usb$i,path=$work/usb$i" -device "usb-redir,chardev=usb$i,bus=usb.0,port=$i")
done
timeout --kill-after=5 280 "${machine[@]}" 2>"$work/machine.log" </dev/null
# shellcheck disable=SC2086
kill $bridges 2>/dev/null # they have ended with the machine, unless it never began
wait

tr -d '\r' <"$work/said" >"$work/lines"
grep -E '^(1\.\.[0-9]|ok [0-9]|not ok [0-9]|#)' "$work/lines"
grep -q '^1\.\.' "$work/lines" || for f in lines machine.log bridge1.log bridge2.log board.log; do
    [ ! -e "$work/$f" ] || tail -20 "$work/$f" | sed "s|^|# $f: |"
done
