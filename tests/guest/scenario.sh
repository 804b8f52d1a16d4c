#!/bin/bash
# What is tried in the Linux machine, as its only program; the bridges take orders from its serial lines 1 and 2. TAP on stdout.
cd "$SOURCE" || exit
. tests/e2e/usb_common.sh
PATH=$B/guest:$PATH
tables=(matte_white plastic_red gold plastic_blue_rough copper_satin satin_green)
for line in 1 2; do stty -F /dev/ttyS$line raw -echo; done
exec 3<>/dev/ttyS1 4<>/dev/ttyS2

order() { # order: to the bridge of this device; what it answers
    echo "$1" >&$((line + 2))
    read -r -t 90 said <&$((line + 2)) && echo "$said" && [[ $said = ok* ]]
}
count() { # stalls|cancelled|resets
    order counts | sed "s/.* $1 \([0-9]*\).*/\1/"
}
device() { # the device's folder in /sys, if it is there
    grep -lsx "$serial" /sys/bus/usb/devices/*/serial | sed 's|/serial$||'
}
appears() {
    for ((i = 0; i < 600; i++)); do [ -e "$(device)/bConfigurationValue" ] && return || sleep 0.05; done
    return 1
}
disappears() {
    for ((i = 0; i < 600; i++)); do [ -z "$(device)" ] && return || sleep 0.05; done
    return 1
}
usb() { # gtusb command... with this device
    gtusb "$@" --serial "$serial"
}
says() { # claim code stderr command...: stdout is $work/out
    expect "${1}_$who" "$2" '.*' "$3" "${@:4}"
}
holds() { # claim command...
    check "${1}_$who" "${@:2}"
}

# What lsusb reads, without the names of its data base.
described() {
    lsusb -v -s "$(cat "$(device)/busnum"):$(cat "$(device)/devnum")" | sed -E '/^Bus|^$/d; s/^ +//; s/ +/ /g; s/ $//
        s/^(id(Vendor|Product)|b(Device|Interface)(Class|SubClass|Protocol)) ([^ ]*).*/\1 \5/'
}
described_as_the_descriptors_are() {
    [ "$(cat "$(device)/speed")" = $speed ] &&
        sed "s/SERIAL/$serial/; s/PACKET/$(printf '0x%04x 1x %d' $packet $packet)/" tests/guest/lsusb.txt >"$work/expected" &&
        described >"$work/described" && diff "$work/expected" "$work/described"
}
resumed() { # the last push's JSON
    grep -qE '"resumed_after": [1-9]' "$work/out"
}
suspends() {
    local power
    power=$(device)/power
    echo 0 >"$power/autosuspend_delay_ms" && echo auto >"$power/control"
    for ((i = 0; i < 100; i++)); do [ "$(cat "$power/runtime_status")" = suspended ] && break || sleep 0.05; done
    [ "$(cat "$power/runtime_status")" = suspended ]
}

# The same for both devices.
session() { # line who serial speed packet
    line=$1 who=$2 serial=$3 speed=$4 packet=$5
    holds a_device_is_plugged_in order plug
    holds it_is_enumerated appears
    holds lsusb_reads_device_configuration_bos_and_strings described_as_the_descriptors_are
    says it_is_listed 0 '' gtusb list
    holds list_tells_its_serial_number grep -q "1209:0001  $serial$" "$work/out"

    says a_scene_is_pushed 0 '' usb push "$DEMO/six_models.blob"
    for slot in 0 1 2 3 4 5; do
        table=${tables[slot]}
        [ $slot != 2 ] || table=satin_green
        says table_${slot}_is_pushed 0 '' usb push "$DEMO/$table.ktx2" --slot $slot
    done
    says a_table_is_verified 0 '' usb verify "$DEMO/copper_satin.ktx2" --slot 4
    says another_table_is_told_from_it 10 '.*differs.*' usb verify "$DEMO/gold.ktx2" --slot 4

    stalls=$(count stalls)
    order "damage_after 100000" >"$work/log"
    says a_message_damaged_on_its_way_ends_a_push 8 'gtusb: push: USB: .*' usb push "$DEMO/gold.ktx2" --slot 2
    holds by_a_stall [ "$(count stalls)" -gt "$stalls" ]
    says the_device_is_usable_after_a_stall 0 '' usb info

    order "unplug_after 100000" >"$work/log"
    says unplugged_in_mid_push 8 'gtusb: push: USB: .*' usb push "$DEMO/gold.ktx2" --slot 2 --json
    holds an_unplugged_device_disappears disappears
    says no_push_without_device 5 '.*no device.*' usb push "$DEMO/gold.ktx2" --slot 2
    order plug >"$work/log"
    holds a_device_plugged_in_again_is_enumerated appears
    says the_old_table_is_live 0 '' usb verify "$DEMO/satin_green.ktx2" --slot 2
    says the_push_is_repeated 0 '' usb push "$DEMO/gold.ktx2" --slot 2 --json
    holds and_goes_on_where_it_was resumed
    says the_new_table_is_live 0 '' usb verify "$DEMO/gold.ktx2" --slot 2

    cancelled=$(count cancelled)
    order freeze >"$work/log"
    says a_silent_device_is_given_up 8 'gtusb: info: USB: no answer within .*' usb info --timeout 0.5
    holds its_transfers_are_cancelled [ "$(count cancelled)" -gt "$cancelled" ]
    order thaw >"$work/log"
    says the_device_is_usable_after_a_silence 0 '' usb info

    resets=$(count resets)
    says the_port_is_reset 0 '' usbreset "$(printf %03d/%03d "$(cat "$(device)/busnum")" "$(cat "$(device)/devnum")")"
    holds which_reaches_the_device [ "$(count resets)" -gt "$resets" ]
    says the_device_is_usable_after_a_reset 0 '' usb info
    holds the_device_is_suspended suspends
    says the_device_wakes_up_for_a_request 0 '' usb info

    says a_frame_is_fetched 0 '' usb frame -o "$work/frame.png"
    holds the_frame_is_the_simulators_to_the_bit cmp "$work/frame.png" "$EXPECTED"
    said=$(order counts)
    echo "# $who: ${said#ok }, $(cut -d' ' -f1 /proc/uptime) s after the machine was switched on"
}

session 1 with_the_simulator GT-SIM-0001 480 512
session 2 with_a_cortex_m4 GT-MPS2-0001 12 64
expect two_devices_are_told_apart 6 '' '.*2 devices match; choose one by --serial or --port.*' gtusb info
echo "1..$n"
