# What the test with a Linux machine runs besides the tools: see tests/e2e/test_guest.sh.
DEPS_CHECK += qemu-system-x86 libusbredirparser-dev busybox-static cpio usbutils
# Where kernels are kept that were fetched; the same for all builds of one command.
GUEST_KERNEL ?= $(B)/guest/kernel
export GUEST_KERNEL

GUEST_C := $(wildcard tests/guest/bridge.c tests/guest/port_*.c)
$(GUEST_C:%.c=$(B)/host/%.o): HOST += -Ihal/mps2 $(call pkgflags,libusbredirparser-0.5)
$(B)/guest/bridge: $(GUEST_C:%.c=$(B)/host/%.o) $(LIBS)
	@mkdir -p $(@D)
	$(CC) -o $@ $^ $(call pkglibs,libusbredirparser-0.5) -lz -lm -ldl

# The machine's processor is QEMU's, whatever HOST_ARCH this one's may do.
$(B)/guest/core/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CORE) -c $< -o $@
$(B)/guest/libgoniotile.a: $(patsubst %.c,$(B)/guest/core/%.o,$(wildcard lut/*.c raster/*.c))
$(B)/guest/gtusb: $(patsubst %.c,$(B)/host/%.o,$(wildcard host_tools/gtusb*.c)) $(B)/libhost.a $(B)/guest/libgoniotile.a
	$(CC) -o $@ $^ $(LIBS_gtusb)
$(B)/guest/goniotile_oiio.so: tests/guest/pictures.c host_tools/oiio_shim.h
	@mkdir -p $(@D)
	$(CC) $(HOST) -fPIC -shared -o $@ $<
$(B)/guest/gtsim: $(B)/gtsim # with the pictures beside it
	@mkdir -p $(@D)
	cp $< $@

# The firmware with a cable: the mailbox is MPS2's.
$(B)/board/cortex-m4/mps2.elf: $(patsubst %,$(B)/board/cortex-m4/hal/mps2/%.o,main mailbox_usb) $(BOARD_OBJ_cortex-m4) \
    $(BOARD_FIRMWARE_OBJ_cortex-m4)
	$(BOARD_CC_cortex-m4) $(BOARD_LINK) -Lhal/mps2 -T an386.ld $^ -lgcc -o $@

.PHONY: guest guest-build
guest-build: $(addprefix $(B)/guest/,bridge gtusb gtsim goniotile_oiio.so) $(B)/board/cortex-m4/mps2.elf demo-data
check-built: guest-build
guest: deps-check ## the tools in a Linux machine against real usbfs and xHCI: the simulated device, and firmware on a Cortex-M4
	$(AGAIN) guest-build
	@B=$(B) tests/run.sh e2e/test_guest
