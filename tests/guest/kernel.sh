#!/usr/bin/env bash
# Fetches Debian's kernel and those of its modules that the machine needs, numbered in the order of loading: kernel.sh FOLDER
# Exit status 75, and why on stderr, when there is none to be had.
set -eu
modules=(drivers/virtio/virtio_ring drivers/virtio/virtio drivers/virtio/virtio_pci_modern_dev drivers/virtio/virtio_pci_legacy_dev
    drivers/virtio/virtio_pci net/9p/9pnet net/9p/9pnet_virtio fs/netfs/netfs fs/fscache/fscache fs/9p/9p # the host's files
    drivers/usb/common/usb-common drivers/usb/core/usbcore drivers/usb/host/xhci-hcd drivers/usb/host/xhci-pci)
folder=$1
[ ! -e "$folder/vmlinuz" ] || exit 0

cannot() {
    echo "$*" >&2
    exit 75
}
command -v apt-get >/dev/null && [ "$(dpkg --print-architecture)" = amd64 ] || cannot "the kernel is a package of Debian for amd64"
package=$(apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/^ *Depends: \(linux-image-[^ ]*\)$/\1/p' | head -1)
[ -n "$package" ] || cannot "apt knows no package linux-image-amd64: apt-get update"
mkdir -p "$(dirname "$folder")"
work=$(mktemp -d "$folder.XXXXXX") && trap 'rm -rf "$work"' EXIT
chmod 755 "$work"
(cd "$work" && apt-get download -qq "$package" >log 2>&1) || cannot "$package cannot be fetched: $(grep '^E:' "$work/log" | head -1)"
patterns=("${modules[@]/#/*/kernel/}")
dpkg-deb --fsys-tarfile "$work"/*.deb | tar -x -C "$work" --wildcards './boot/vmlinuz*' "${patterns[@]/%/.ko}"
rm "$work"/*.deb "$work/log"
number=10
for m in "${modules[@]}"; do
    mv "$work"/lib/modules/*/kernel/"$m.ko" "$work/$number-${m##*/}.ko"
    number=$((number + 1))
done
mv "$work"/boot/vmlinuz* "$work/vmlinuz"
rm -r "$work/boot" "$work/lib"
rm -rf "$folder"
mv "$work" "$folder"
