#!/bin/bash
# The demo, called by `make demo`: pushes the scene and six tables through libusb to the simulated device, fetches two frames
# and prints one table. Inputs: $B/demo/*.blob and *.ktx2, made by `make demo-data`.
set -euo pipefail
B=$(realpath "${B:-build}")
D=$B/demo
TABLES="matte_white plastic_red gold plastic_blue_rough copper_satin satin_green" # slots 0 to 5 of the scene

for f in "$D/six_models.blob" $(printf "$D/%s.ktx2 " $TABLES); do
    [ -f "$f" ] || { echo "demo.sh: $f is missing; run 'make demo-data'" >&2; exit 3; }
done

# All of this happens in one life of the device.
export B D TABLES
"$B/gtsim" run -- bash -euo pipefail -c '
    "$B/gtusb" push "$D/six_models.blob"
    slot=0
    for t in $TABLES; do
        "$B/gtusb" push "$D/$t.ktx2" --slot $slot
        slot=$((slot + 1))
    done
    "$B/gtusb" frame -o "$D/frame.png"
    "$B/gtusb" info > "$D/info.txt"
    "$B/gtusb" stats > "$D/stats.txt"
    "$B/gtusb" set model lafortune_phong
    "$B/gtusb" frame -o "$D/frame_lafortune.png"
' > "$D/push.txt"

echo "pushed                       bytes    seconds    MB/s"
awk '/bytes in/ { name = $1; sub(/^.* to [a-z ]*[0-9]*: /, ""); printf "%-22s %11d %10s %7s\n", name, $1, $4, $6 }' "$D/push.txt"
awk '$1 == "scene" && /objects/ { sub(/^scene +/, ""); print "scene: " $0 }' "$D/info.txt"
cat "$D/stats.txt"
echo "pictures: $D/frame.png (measured) and $D/frame_lafortune.png (Lafortune-Phong)"
