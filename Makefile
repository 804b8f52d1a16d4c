# Goniotile. `make help` lists the targets; no configure step.
B       ?= build
CC      ?= cc
CXX     ?= c++
OPT     ?= -O2
# Added for the freestanding library that this machine's tools link: empty for one that runs on any. Not with sanitizers, nor with
# another OPT. Pictures are the same.
# With AVX2 where this processor has it, and no more: so counts of instructions are the same on all that do, and valgrind knows them.
ifeq ($(origin HOST_ARCH),undefined)
HOST_ARCH := -O3 $(if $(shell grep -om1 avx2 /proc/cpuinfo 2>/dev/null),-march=x86-64-v3)
endif
PREFIX  ?= /usr/local
JOBS    ?= $(shell nproc)
WARN    := -Wall -Wextra -Wshadow -Wconversion -Wno-sign-conversion -Wstrict-prototypes -Werror
CORE_INC:= -I. -Ilut -Iraster -Ifirmware -Ihal
# The freestanding folders are compiled with nothing but the compiler's own headers.
CORE     = -std=c11 $(OPT) -g $(WARN) -MMD -MP -ffreestanding -nostdinc -isystem $(CC_INCLUDE) $(CORE_INC)
# Hosted code may use what POSIX adds.
HOST     = -std=gnu11 $(OPT) -g $(WARN) -MMD -MP $(CORE_INC) -Ihal/sim -Ihost_tools
TEST     = $(HOST) -Itests/reference
# The reference renderer sees no header of the product.
REF      = -std=gnu11 $(OPT) -g $(WARN) -MMD -MP -Itests/reference
SAN     ?= -fsanitize=address,undefined -fno-sanitize-recover=all

CORE_C  := $(wildcard lut/*.c raster/*.c firmware/*.c)
SIM_C   := $(wildcard hal/sim/*.c)
# Modules shared by the tools; gtX.c and gtX_*.c belong to one tool.
HOSTM_C := $(wildcard host_tools/common.c host_tools/host_*.c)
REF_C   := $(wildcard tests/reference/*.c)
TOOLS   := gtlut gtscene gtusb gtsim
SUITES  := unit hard_cases golden budget exhaustive fault
TEST_C  := $(wildcard $(SUITES:%=tests/%/test_*.c))
BENCH_C := $(wildcard tests/bench/*.c)

# Asked for when a recipe runs, not before: the packages may have been installed by a target just finished.
CC_INCLUDE = $(shell $(CC) -print-file-name=include)
pkgflags   = $(shell pkg-config --cflags $(1))
pkglibs    = $(shell pkg-config --libs $(1))
GLIB_PKGS := umockdev-1.0 glib-2.0 gobject-2.0
CFLAGS_gtusb  = $(call pkgflags,libusb-1.0)
CFLAGS_gtsim  = $(call pkgflags,$(GLIB_PKGS) sdl2)
LIBS_gtlut    = $(call pkglibs,assimp) -lgsl -lgslcblas -lm -ldl
LIBS_gtscene  = $(call pkglibs,assimp) -lmeshoptimizer -lcjson -lm
LIBS_gtusb    = $(call pkglibs,libusb-1.0) -lz -lm -ldl
LIBS_gtsim    = $(call pkglibs,$(GLIB_PKGS) sdl2) -lz -lm -ldl
LIBS_test     = -lcmocka -lcjson -lgsl -lgslcblas -lz -lm -ldl

# Runs make again, in parallel unless -j was given, so that what was just installed is seen.
AGAIN = @$(MAKE) --no-print-directory $(if $(findstring -j,$(MAKEFLAGS)),,-j$(JOBS))

.PHONY: all deps-demo deps-check deps-bench demo demo-data tests check check-built check-long bench bench-built size \
        lint format install clean help
.DELETE_ON_ERROR:
.SECONDARY:

all: $(B)/libgoniotile.a $(TOOLS:%=$(B)/%) $(B)/goniotile_oiio.so ## build the freestanding library, the simulator and the host tools

help: ## list the targets
	@grep -hE '^[a-z-]+:.*##' Makefile tests/fuzz/fuzz.mk tests/prove/prove.mk tests/board/board.mk tests/guest/guest.mk tests/report/report.mk | sed -E 's/:[^#]*## /\t/' | expand -t 14

# --- packages: each target installs what it needs itself ---
DEPS_DEMO  := gcc g++ pkg-config gnuplot-nox libopenimageio-dev libusb-1.0-0-dev libassimp-dev libmeshoptimizer-dev libcjson-dev \
              zlib1g-dev libgsl-dev libumockdev-dev umockdev libglib2.0-dev libsdl2-dev
CROSS      := gcc-arm-none-eabi gcc-riscv64-unknown-elf clang-14
DEPS_FUZZ  := $(DEPS_DEMO) clang-14 libclang-rt-14-dev llvm-14
DEPS_CHECK := $(DEPS_FUZZ) $(CROSS) libcmocka-dev clang-format-14 nodejs npm gnuplot-nox help2man xvfb xdotool
DEPS_BENCH := $(DEPS_DEMO) $(CROSS) valgrind

deps-demo: ## install what `make demo` needs (Debian packages)
	@tests/install_deps.sh $(DEPS_DEMO)
deps-check: ## install what `make check` needs
	@tests/install_deps.sh $(DEPS_CHECK)
deps-bench: ## install what `make bench` needs
	@tests/install_deps.sh $(DEPS_BENCH)

# --- what people run ---
demo: deps-demo ## measure six materials, push them to the simulated device, write build/demo/frame*.png
	$(AGAIN) all demo-data
	@B=$(B) host_tools/demo.sh

check: deps-check ## build and run every test; ends with `N passed, N failed, N skipped`
	$(AGAIN) check-built
check-built: all demo-data tests fuzz-programs
	@B=$(B) CC=$(CC) tests/run.sh

check-long: deps-check ## check with ten times the random cases, then built by clang -O3 and by gcc -O0, without sanitizers
	$(AGAIN) check-built GONIOTILE_LONG=1 LIMIT=1800
	$(AGAIN) check-built B=$(B)/clang-O3 CC=clang-14 OPT=-O3 WARN=-Wall SAN= LIMIT=1800
	$(AGAIN) check-built B=$(B)/gcc-O0 CC=gcc OPT=-O0 SAN= LIMIT=1800

bench: deps-bench ## measure; writes build/bench/results.csv
	$(AGAIN) bench-built
bench-built: all demo-data $(BENCH_C:tests/%.c=$(B)/%)
	@B=$(B) tests/bench/run.sh

size: deps-bench ## print code size per folder and target, and what products link
	@B=$(B) tests/bench/size.sh

lint: ## include rules, format, documents
	@CC=$(CC) tests/lint.sh

format: ## rewrite every C file in the project's style
	clang-format-14 -i $$(git ls-files -co --exclude-standard '*.c' '*.h' '*.cc')

# --- libraries ---
$(B)/core/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CORE) $(if $(filter -O2,$(OPT)),$(HOST_ARCH)) -c $< -o $@
$(B)/san/core/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(CORE) $(SAN) -c $< -o $@
# gtusb_list.c is compiled with what the packages of gtusb ask for.
$(B)/host/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(HOST) $(CFLAGS_$(firstword $(subst _, ,$(notdir $*)))) -c $< -o $@
$(B)/san/host/%.o: %.c
	@mkdir -p $(@D)
	$(CC) $(HOST) $(SAN) -c $< -o $@
$(B)/host/tests/%.o: tests/%.c
	@mkdir -p $(@D)
	$(CC) $(TEST) -c $< -o $@
$(B)/san/host/tests/%.o: tests/%.c
	@mkdir -p $(@D)
	$(CC) $(TEST) $(SAN) -c $< -o $@
$(B)/host/tests/reference/%.o: tests/reference/%.c
	@mkdir -p $(@D)
	$(CC) $(REF) -c $< -o $@
$(B)/san/host/tests/reference/%.o: tests/reference/%.c
	@mkdir -p $(@D)
	$(CC) $(REF) $(SAN) -c $< -o $@

# $(call LIBRARIES,prefix): the four archives, once plain and once for the sanitized tests.
define LIBRARIES
$(1)/libgoniotile.a: $$(CORE_C:%.c=$(1)/core/%.o)
$(1)/libsim.a: $$(SIM_C:%.c=$(1)/host/%.o)
$(1)/libhost.a: $$(HOSTM_C:%.c=$(1)/host/%.o)
$(1)/libreference.a: $$(REF_C:%.c=$(1)/host/%.o)
endef
$(eval $(call LIBRARIES,$(B)))
$(eval $(call LIBRARIES,$(B)/san))
LIBS     := $(B)/libhost.a $(B)/libsim.a $(B)/libgoniotile.a
LIBS_SAN := $(LIBS:$(B)/%=$(B)/san/%)
%.a:
	@mkdir -p $(@D)
	@rm -f $@
	$(AR) rcs $@ $^

# --- tools ---
define TOOL
$(B)/$(1): $$(patsubst %.c,$(B)/host/%.o,$$(wildcard host_tools/$(1).c host_tools/$(1)_*.c)) $(LIBS)
	$$(CC) -o $$@ $$^ $$(LIBS_$(1))
endef
$(foreach t,$(TOOLS),$(eval $(call TOOL,$(t))))

# OpenImageIO costs a quarter of a second and 131 MB at start-up: a shared object of its own, opened on demand.
$(B)/goniotile_oiio.so: host_tools/oiio_shim.cc host_tools/oiio_shim.h
	@mkdir -p $(@D)
	$(CXX) -std=c++17 $(OPT) -g -Wall -Wextra -Werror -fPIC -shared -o $@ $< $(call pkglibs,OpenImageIO)

# --- the demo's scene and tables, also what golden and budget tests and the benchmark render ---
MATERIALS := matte_white plastic_red gold plastic_blue_rough copper_satin satin_green
demo-data: $(B)/demo/six_models.blob $(B)/demo/points.blob $(B)/demo/material.blob $(MATERIALS:%=$(B)/demo/%.ktx2)
$(B)/demo/%.blob: host_tools/scenes/%.json $(B)/gtscene
	@mkdir -p $(@D)
	$(B)/gtscene build $< -o $@
$(B)/demo/%.csv: $(B)/gtlut
	@mkdir -p $(@D)
	$(B)/gtlut measure $* -o $@
$(B)/demo/%.ktx2: $(B)/demo/%.csv
	$(B)/gtlut build $< -o $@ --kind half_vector --packed 2>$@.log || { cat $@.log >&2; exit 1; }

# --- test and benchmark programs ---
tests: $(TEST_C:%.c=$(B)/%)
$(B)/tests/%: $(B)/san/host/tests/%.o $(B)/san/libreference.a $(LIBS_SAN)
	@mkdir -p $(@D)
	$(CC) $(SAN) -o $@ $^ $(LIBS_test)
# Modules that several tests of a kind share.
BUDGET_C := $(filter-out tests/budget/test_%,$(wildcard tests/budget/*.c))
$(B)/tests/budget/%: $(B)/san/host/tests/budget/%.o $(BUDGET_C:%.c=$(B)/san/host/%.o) $(B)/san/libreference.a $(LIBS_SAN)
	@mkdir -p $(@D)
	$(CC) $(SAN) -o $@ $^ $(LIBS_test)
FAULT_C := $(filter-out tests/fault/test_%,$(wildcard tests/fault/*.c))
$(B)/tests/fault/%: $(B)/san/host/tests/fault/%.o $(FAULT_C:%.c=$(B)/san/host/%.o) $(B)/san/libreference.a $(LIBS_SAN)
	@mkdir -p $(@D)
	$(CC) $(SAN) -o $@ $^ $(LIBS_test)
# Sweeps over millions of cases run at full speed.
$(B)/tests/exhaustive/%: $(B)/host/tests/exhaustive/%.o $(B)/libreference.a $(LIBS)
	@mkdir -p $(@D)
	$(CC) -o $@ $^ $(LIBS_test)
$(B)/bench/%: $(B)/host/tests/bench/%.o $(LIBS)
	@mkdir -p $(@D)
	$(CC) -o $@ $^ -lz -lm -ldl
$(B)/bench/bench_usb: $(B)/host/tests/bench/bench_usb.o $(FAULT_C:%.c=$(B)/host/%.o) $(B)/libreference.a $(LIBS)
	@mkdir -p $(@D)
	$(CC) -o $@ $^ -lz -lm -ldl
$(B)/host/tests/bench/bench_usb.o: HOST += -Itests/fault

include tests/fuzz/fuzz.mk
include tests/prove/prove.mk

# --- the library in two files ---
AMALGAMATION := $(B)/amalgamation/goniotile
.PHONY: amalgamation
amalgamation: $(AMALGAMATION).c ## lut/ and raster/ as one header and one source, for embedding
$(AMALGAMATION).c: host_tools/amalgamate.sh LICENSE $(wildcard lut/*.[ch] raster/*.[ch])
	host_tools/amalgamate.sh $(@D) $(filter lut/% raster/%,$(PUBLIC_H))

# --- installation ---
VERSION = $(shell grep -oE '[0-9]+[.][0-9]+[.][0-9]+' lut/goniotile_version.h)
BIN := $(DESTDIR)$(PREFIX)/bin
INC := $(DESTDIR)$(PREFIX)/include/goniotile
PUBLIC_H := $(addprefix lut/,fixed.h func.h goniotile_version.h ktx2.h lut.h rgb9e5.h) raster/parts.h raster/quality.h raster/raster.h raster/scene.h hal/hal.h \
            $(addprefix firmware/,app.h budget.h crc32.h protocol.h table_store.h usb_device.h usb_protocol.h)
MAN := $(DESTDIR)$(PREFIX)/share/man/man1
.PHONY: man deps-man
deps-man:
	@tests/install_deps.sh help2man
man: $(B)/man/gtlut.1 ## manual pages, from --help
$(B)/man/gtlut.1: host_tools/man.sh $(TOOLS:%=$(B)/%) | deps-man
	host_tools/man.sh $(@D) $(TOOLS:%=$(B)/%)
install: all man ## install under DESTDIR/PREFIX: tools, manual pages, library, headers, pkg-config file, udev rules
	install -d $(BIN) $(INC) $(MAN) $(DESTDIR)$(PREFIX)/lib/goniotile $(DESTDIR)$(PREFIX)/lib/pkgconfig \
	    $(DESTDIR)$(PREFIX)/lib/udev/rules.d $(DESTDIR)$(PREFIX)/share/doc/goniotile
	install $(TOOLS:%=$(B)/%) $(BIN)
	install -m 644 $(B)/libgoniotile.a $(DESTDIR)$(PREFIX)/lib
	install -m 644 $(B)/goniotile_oiio.so $(DESTDIR)$(PREFIX)/lib/goniotile
	install -m 644 $(PUBLIC_H) $(INC)
	install -m 644 $(B)/man/*.1 $(MAN)
	sed 's|@PREFIX@|$(PREFIX)|; s|@VERSION@|$(VERSION)|' host_tools/goniotile.pc.in >$(DESTDIR)$(PREFIX)/lib/pkgconfig/goniotile.pc
	install -m 644 host_tools/60-goniotile.rules $(DESTDIR)$(PREFIX)/lib/udev/rules.d
	install -m 644 README.md SPEC.md LICENSE $(DESTDIR)$(PREFIX)/share/doc/goniotile

include tests/board/board.mk
include tests/guest/guest.mk
include tests/report/report.mk

clean: ## remove everything built
	rm -rf $(B)

-include $(shell test -d $(B) && find $(B) -name '*.d')
