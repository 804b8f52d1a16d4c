# Goniotile. `make help` lists the targets; no configure step.
B       ?= build
CC      ?= cc
CXX     ?= c++
OPT     ?= -O2
WARN    := -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wstrict-prototypes -Werror
CORE_INC:= -I. -Ilut -Iraster -Ifirmware -Ihal
# The freestanding folders are compiled with nothing but the compiler's own headers.
CORE    := -std=c11 $(OPT) -g $(WARN) -ffreestanding -nostdinc -isystem $(shell $(CC) -print-file-name=include) $(CORE_INC)
HOST    := -std=c11 $(OPT) -g $(WARN) $(CORE_INC) -Ihal/sim -Ihost_tools -MMD -MP
SAN     := -fsanitize=address,undefined -fno-sanitize-recover=all
PREFIX  ?= /usr/local

CORE_C  := $(wildcard lut/*.c raster/*.c firmware/*.c)
SIM_C   := $(wildcard hal/sim/*.c)
# Modules shared by the tools; gtX.c and gtX_*.c belong to one tool.
HOSTM_C := $(wildcard host_tools/common.c host_tools/host_*.c)
REF_C   := $(wildcard tests/reference/*.c)
TOOLS   := gtlut gtscene gtusb gtsim

pkgflags = $(shell pkg-config --cflags $(1) 2>/dev/null)
pkglibs  = $(shell pkg-config --libs $(1) 2>/dev/null)
LIBS_gtlut   := -lm -ldl
LIBS_gtscene := $(call pkglibs,assimp) -lmeshoptimizer -lcjson -lm
LIBS_gtusb   := $(call pkglibs,libusb-1.0) -lz -lm -ldl
LIBS_gtsim   := $(call pkglibs,umockdev-1.0 glib-2.0 gobject-2.0) -lz -lm -ldl
CFLAGS_gtusb := $(call pkgflags,libusb-1.0)
CFLAGS_gtsim := $(call pkgflags,umockdev-1.0 glib-2.0 gobject-2.0)

.PHONY: all deps-demo deps-check deps-bench demo check check-long bench size lint format install clean help
.DELETE_ON_ERROR:
.SECONDARY:

all: $(TOOLS:%=$(B)/%) $(B)/goniotile_oiio.so ## build the freestanding library, the simulator and the host tools

help: ## list the targets
	@grep -hE '^[a-z-]+:.*##' Makefile | sed -E 's/:[^#]*## /\t/' | expand -t 14

# --- packages: each target installs what it needs itself ---
DEPS_DEMO  := gcc g++ pkg-config libopenimageio-dev libusb-1.0-0-dev libassimp-dev libmeshoptimizer-dev libcjson-dev \
              zlib1g-dev libumockdev-dev umockdev libglib2.0-dev
DEPS_CHECK := $(DEPS_DEMO) libcmocka-dev gcc-arm-none-eabi clang npm nodejs
DEPS_BENCH := $(DEPS_DEMO) gcc-arm-none-eabi valgrind

deps-demo: ## install what `make demo` needs (Debian packages)
	@tests/install_deps.sh $(DEPS_DEMO)
deps-check: ## install what `make check` needs
	@tests/install_deps.sh $(DEPS_CHECK)
deps-bench: ## install what `make bench` needs
	@tests/install_deps.sh $(DEPS_BENCH)

# --- libraries ---
$(B)/core/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CORE) -MMD -MP -c $< -o $@
$(B)/host/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(HOST) -c $< -o $@
$(B)/san/core/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CORE) $(SAN) -MMD -MP -c $< -o $@
$(B)/san/host/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(HOST) $(SAN) -c $< -o $@

$(B)/libgoniotile.a: $(CORE_C:%.c=$(B)/core/%.o)
	@rm -f $@
	$(AR) rcs $@ $^
$(B)/libsim.a: $(SIM_C:%.c=$(B)/host/%.o)
	@rm -f $@
	$(AR) rcs $@ $^
$(B)/libhost.a: $(HOSTM_C:%.c=$(B)/host/%.o)
	@rm -f $@
	$(AR) rcs $@ $^
$(B)/libreference.a: $(REF_C:%.c=$(B)/host/%.o)
	@rm -f $@
	$(AR) rcs $@ $^
$(B)/san/libgoniotile.a: $(CORE_C:%.c=$(B)/san/core/%.o)
	@rm -f $@
	$(AR) rcs $@ $^
$(B)/san/libsim.a: $(SIM_C:%.c=$(B)/san/host/%.o)
	@rm -f $@
	$(AR) rcs $@ $^
$(B)/san/libhost.a: $(HOSTM_C:%.c=$(B)/san/host/%.o)
	@rm -f $@
	$(AR) rcs $@ $^
$(B)/san/libreference.a: $(REF_C:%.c=$(B)/san/host/%.o)
	@rm -f $@
	$(AR) rcs $@ $^

# --- tools ---
define TOOL
$(B)/host/host_tools/$(1).o $(B)/host/host_tools/$(1)_%.o: HOST += $$(CFLAGS_$(1))
$(B)/$(1): $$(patsubst %.c,$(B)/host/%.o,$$(wildcard host_tools/$(1).c host_tools/$(1)_*.c)) \
		$(B)/libhost.a $(B)/libsim.a $(B)/libgoniotile.a
	$$(CC) -o $$@ $$^ $$(LIBS_$(1))
endef
$(foreach t,$(TOOLS),$(eval $(call TOOL,$(t))))

# OpenImageIO costs a quarter of a second and 131 MB at start-up: a shared object of its own, opened on demand.
$(B)/goniotile_oiio.so: host_tools/oiio_shim.cc host_tools/oiio_shim.h
	@mkdir -p $(@D)
	$(CXX) -std=c++17 $(OPT) -g -Wall -Wextra -Werror -fPIC -shared -o $@ $< $(call pkglibs,OpenImageIO)

-include $(shell test -d $(B) && find $(B) -name '*.d')

clean: ## remove everything built
	rm -rf $(B)
