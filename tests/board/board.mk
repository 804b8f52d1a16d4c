# Programs for the emulated boards and what runs them. One build per target: everything here, whatever it measures, is
# compiled with the same options.
BOARD_OPT   ?= -O2
# Files compiled for size.
BOARD_COLD  := $(shell bash -c '. tests/targets.sh && echo $$COLD')
DEPS_BOARD  := $(CROSS) qemu-system-arm qemu-system-misc
DEPS_CHECK  += $(DEPS_BOARD)
DEPS_BENCH  += $(DEPS_BOARD) llvm-14

BOARD_TARGETS := cortex-m3 cortex-m4 cortex-m7 cortex-m33 cortex-m55 rv32imac
# The core of AN521 has no DSP instructions.
BOARD_CPU_cortex-m33 := cortex-m33+nodsp
BOARD_SCRIPT_cortex-m3  := an385
BOARD_SCRIPT_cortex-m4  := an386
BOARD_SCRIPT_cortex-m7  := an500
BOARD_SCRIPT_cortex-m33 := an521
BOARD_SCRIPT_cortex-m55 := an547
BOARD_TIMER_cortex-m55  := sse

COMMA := ,
BOARD_SHARED := hal/emulated/report.c hal/emulated/memory.c hal/emulated/unplugged.c
# memset's own loops must not become calls of memset
BOARD_FLAGS_hal/emulated/memory := -fno-tree-loop-distribute-patterns

# $(call BOARD_TARGET,target,compiler with machine options,board's sources): objects in $(B)/board/target, the renderer's and the
# board's in BOARD_OBJ_target.
define BOARD_TARGET
BOARD_CC_$(1) := $(2)
BOARD_OBJ_$(1) := $$(patsubst %.c,$(B)/board/$(1)/%.o,$(3) $(BOARD_SHARED) $(wildcard lut/*.c raster/*.c))
BOARD_FIRMWARE_OBJ_$(1) := $$(patsubst %.c,$(B)/board/$(1)/%.o,$(wildcard firmware/*.c))
$(B)/board/$(1)/%.o: %.c
	@mkdir -p $$(@D)
	$(2) -std=c11 $$(if $$(filter $$<,$$(BOARD_COLD)),-Os,$$(BOARD_OPT)) $$(BOARD_FLAGS_$$*) -g $(WARN) -MMD -MP \
	    -ffreestanding -nostdinc -isystem $$(shell $(firstword $(2)) -print-file-name=include) -ffunction-sections -fdata-sections \
	    -fcallgraph-info=su $(CORE_INC) -Ihal/emulated -c $$< -o $$@
endef
# $(call BOARD_PROGRAMS,target,link options)
define BOARD_PROGRAMS
$(B)/board/$(1)/work_a.elf $(B)/board/$(1)/fault.elf $(B)/board/$(1)/calibrate.elf: $(B)/board/$(1)/%.elf: $(B)/board/$(1)/tests/board/%/main.o $(BOARD_OBJ_$(1))
	$(BOARD_CC_$(1)) $(BOARD_LINK) $(2) $$^ -lgcc -o $$@
$(B)/board/$(1)/shade.elf: $(B)/board/$(1)/tests/board/shade/main.o $(B)/board/$(1)/tests/board/shade/sphere.o $(BOARD_OBJ_$(1))
	$(BOARD_CC_$(1)) $(BOARD_LINK) -Wl,--wrap=raster_finish_pixels $(2) $$^ -lgcc -o $$@
$(B)/board/$(1)/budget.elf: $(B)/board/$(1)/tests/board/budget/main.o $(BOARD_OBJ_$(1)) $(patsubst %,$(B)/board/$(1)/firmware/%.o,budget budget_plan budget_choose)
	$(BOARD_CC_$(1)) $(BOARD_LINK) $(2) $$^ -lgcc -o $$@
$(B)/board/$(1)/push.elf: $(B)/board/$(1)/tests/board/push/main.o $(BOARD_OBJ_$(1)) $(BOARD_FIRMWARE_OBJ_$(1))
	$(BOARD_CC_$(1)) $(BOARD_LINK) $(2) $$^ -lgcc -o $$@
$(B)/board/$(1)/firmware.elf: $(B)/board/$(1)/hal/emulated/main.o $(BOARD_OBJ_$(1)) $(BOARD_FIRMWARE_OBJ_$(1))
	$(BOARD_CC_$(1)) $(BOARD_LINK) $(2) $$^ -lgcc -o $$@
$(B)/board/$(1)/amalgamated.elf: $(B)/board/$(1)/hal/emulated/main.o $(B)/amalgamation/$(1).o $(BOARD_FIRMWARE_OBJ_$(1)) \
    $(filter-out $(B)/board/$(1)/lut/% $(B)/board/$(1)/raster/%,$(BOARD_OBJ_$(1)))
	$(BOARD_CC_$(1)) $(BOARD_LINK) $(2) $$^ -lgcc -o $$@
endef
BOARD_LINK := -nostdlib -Wl,--gc-sections -Lhal/emulated
CORTEX_M   := $(filter cortex-%,$(BOARD_TARGETS))
$(foreach t,$(CORTEX_M),$(eval $(call BOARD_TARGET,$(t),arm-none-eabi-gcc -mcpu=$(or $(BOARD_CPU_$(t)),$(t)) -mthumb,\
    hal/emulated/cortex_m.c hal/mps2/board.c hal/mps2/timer_$(or $(BOARD_TIMER_$(t)),cmsdk).c)))
$(foreach t,$(CORTEX_M),$(eval $(call BOARD_PROGRAMS,$(t),-Lhal/mps2 -T $(BOARD_SCRIPT_$(t)).ld)))
$(eval $(call BOARD_TARGET,rv32imac,riscv64-unknown-elf-gcc -march=rv32imac_zicsr -mabi=ilp32 -mcmodel=medany,\
    hal/rv32virt/startup.c hal/rv32virt/board.c))
# The library is filed under the instruction set without its later name for the control registers.
$(eval $(call BOARD_PROGRAMS,rv32imac,-march=rv32imac -Wl$(COMMA)--no-warn-rwx-segments -T hal/rv32virt/rv32virt.ld))

# The amalgamation, compiled as an embedder does: one command and no include path. On three boards
# amalgamated.elf is the firmware with it for lut/ and raster/.
AMALGAMATED_BOARDS := cortex-m3 cortex-m7 rv32imac
BOARD_CC_cortex-m0 := arm-none-eabi-gcc -mcpu=cortex-m0 -mthumb
BOARD_CC_x86-64 = $(CC)
AMALGAMATED := $(patsubst %,$(B)/amalgamation/%.o,cortex-m0 $(AMALGAMATED_BOARDS) x86-64)
$(AMALGAMATED): $(B)/amalgamation/%.o: $(AMALGAMATION).c
	cd $(@D) && $(BOARD_CC_$*) -std=c11 -O2 -ffreestanding -Wall -Wextra -Werror -c goniotile.c -o $(@F)

# The smallest device: the firmware with scene and table built in, tiles of 32 x 32.
$(eval $(call BOARD_TARGET,lm3s6965,arm-none-eabi-gcc -mcpu=cortex-m3 -mthumb -DRASTER_TILE_WIDTH=32 -DRASTER_TILE_HEIGHT=32,\
    hal/emulated/cortex_m.c $(wildcard hal/lm3s6965/*.c)))
# Code and flash image share 256 KB.
$(B)/board/lm3s6965/%.o: BOARD_OPT := -Os
# One level of detail and meshlets not split: the bank is small.
$(B)/board/oled.blob: host_tools/scenes/oled.json $(B)/gtscene
	@mkdir -p $(@D)
	$(B)/gtscene build $< -o $@ --no-lod --normal-error 90
$(B)/board/gold_91x46.ktx2: $(B)/demo/gold.csv $(B)/gtlut
	@mkdir -p $(@D)
	$(B)/gtlut build $< -o $@ --size 91x46
# Banks of 6 and 17 blocks of 4 KB: as hal/lm3s6965/image.h says.
$(B)/board/lm3s6965.img: $(B)/board/make_image $(B)/board/oled.blob $(B)/board/gold_91x46.ktx2
	$(B)/board/make_image $@ 6 17 $(filter-out $<,$^)
$(B)/board/lm3s6965/image.o: hal/lm3s6965/image.S $(B)/board/lm3s6965.img
	@mkdir -p $(@D)
	$(BOARD_CC_lm3s6965) -Wa,-I$(B)/board -c $< -o $@
$(B)/board/lm3s6965/oled.elf: $(B)/board/lm3s6965/image.o $(BOARD_OBJ_lm3s6965) $(BOARD_FIRMWARE_OBJ_lm3s6965)
	$(BOARD_CC_lm3s6965) $(BOARD_LINK) -Lhal/lm3s6965 -T lm3s6965.ld $^ -lgcc -o $@

.PHONY: deps-board work-a work-b work-built
deps-board:
	@tests/install_deps.sh $(DEPS_DEMO) $(DEPS_BOARD)

# The mesh is in the optional data folder.
GONIOTILE_DATA ?= ../shared/data
WORK_MESH  := $(wildcard $(GONIOTILE_DATA)/meshes/torus_knot_7680.obj)
WORK_BLOBS := $(B)/board/work_a.blob $(B)/board/work_b.blob
$(WORK_BLOBS): $(B)/board/%.blob: host_tools/scenes/%.json $(B)/gtscene $(WORK_MESH)
	@mkdir -p $(@D)
	$(B)/gtscene build $< -o $@ --data $(GONIOTILE_DATA)/meshes
# One program renders any blob.
WORK_PROGRAMS := $(WORK_BLOBS) $(B)/board/host_hash-gcc-O2 $(BOARD_TARGETS:%=$(B)/board/%/work_a.elf)
work-a: deps-board ## instructions of the comparison frame: one knot of 7680 triangles, Lambert (needs the data folder)
	$(AGAIN) work-built WORK=work_a
work-b: deps-board ## the same, Blinn-Phong under three lights
	$(AGAIN) work-built WORK=work_b
WORK ?= work_a
work-built: $(WORK_PROGRAMS)
	@B=$(B) tests/board/work.sh $(WORK)

# --- the firmware on the boards: the demo's scene and tables in a flash image ---
$(B)/board/make_image: $(B)/host/tests/board/make_image.o $(LIBS)
	@mkdir -p $(@D)
	$(CC) -o $@ $^ -lz -lm
$(B)/board/six_models_lafortune.json: host_tools/scenes/six_models.json
	@mkdir -p $(@D)
	sed 's/"measured"/"lafortune_phong"/' $< >$@
$(B)/board/six_models_lafortune.blob: $(B)/board/six_models_lafortune.json $(B)/gtscene
	$(B)/gtscene build $< -o $@
BOARD_TABLES := $(MATERIALS:%=$(B)/demo/%.ktx2)
# Banks of 256 and 264 blocks: as hal/emulated/board.h says.
$(B)/board/measured.img: $(B)/demo/six_models.blob
$(B)/board/lafortune_phong.img: $(B)/board/six_models_lafortune.blob
$(B)/board/measured.img $(B)/board/lafortune_phong.img: $(B)/board/make_image $(BOARD_TABLES)
	$(B)/board/make_image $@ 256 264 $(filter %.blob,$^) $(BOARD_TABLES)

# Frames at budgets on the boards.
$(B)/board/make_input: $(B)/host/tests/board/budget/make_input.o $(B)/host/tests/budget/scenes.o $(LIBS)
	@mkdir -p $(@D)
	$(CC) -o $@ $^ -lz -lm
$(B)/host/tests/board/budget/make_input.o: CORE_INC += -Itests/budget
BUDGET_BOARDS := cortex-m3 cortex-m4 cortex-m7
budget-boards: $(B)/board/make_input $(BUDGET_BOARDS:%=$(B)/board/%/budget.elf) $(B)/board/gold_91x46.ktx2 $(BOARD_TABLES)
.PHONY: budget-boards
check-built bench-built: $(if $(wildcard firmware/budget.c),budget-boards)

# Costs of a tile's steps on a target, for budgets.
.PHONY: calibrate calibrate-built
BOARD ?= cortex-m7
calibrate: deps-board ## measure what a tile's steps take on BOARD=cortex-m3|cortex-m4|cortex-m7 and write hal/costs
	$(AGAIN) calibrate-built
# The same pictures on the host: tests/e2e/test_rates_boards.sh.
$(B)/board/calibrate-host: tests/board/calibrate/main.c tests/board/host/board.c hal/emulated/report.c $(wildcard lut/*.[ch] raster/*.[ch])
	@mkdir -p $(@D)
	$(CC) -std=gnu11 -O1 -fsanitize=address,undefined -fno-sanitize-recover=all -Wall -Wextra -Werror $(CORE_INC) -Ihal/emulated -o $@ $(filter %.c,$^)
check-built: $(B)/board/calibrate-host $(foreach t,cortex-m3 cortex-m7 cortex-m33 rv32imac,$(B)/board/$(t)/calibrate.elf) \
    $(B)/board/gold_91x46.ktx2
bench-built: $(foreach t,$(BUDGET_BOARDS),$(B)/board/$(t)/calibrate.elf) $(B)/bench/calibrate $(B)/demo/six_models.blob $(B)/demo/gold.ktx2 $(B)/board/gold_91x46.ktx2
calibrate-built: $(B)/board/$(BOARD)/calibrate.elf $(B)/bench/calibrate $(B)/demo/six_models.blob $(B)/demo/gold.ktx2 $(B)/board/gold_91x46.ktx2
	@B=$(B) tests/board/calibrate.sh $(BOARD) hal/costs/$(subst -,_,$(BOARD)).h

# The pictures' hash on the host: by each compiler, at each level, with sanitizers, with each tile size. All sources at once,
# since no object may be shared.
HOST_HASHES := gcc-O0 gcc-O2 gcc-O3 gcc-Os clang-O2 gcc-sanitized gcc-tiles-32x32 gcc-tiles-64x64 gcc-tiles-16x16
HOST_HASH_CC_clang-O2 := clang-14
HOST_HASH_FLAGS_gcc-O0 := -O0
HOST_HASH_FLAGS_gcc-O2 := -O2
HOST_HASH_FLAGS_gcc-O3 := -O3
HOST_HASH_FLAGS_gcc-Os := -Os
HOST_HASH_FLAGS_clang-O2 := -O2
HOST_HASH_FLAGS_gcc-sanitized := -O1 -fsanitize=address,undefined -fno-sanitize-recover=all
HOST_HASH_FLAGS_gcc-tiles-32x32 := -O2 -DRASTER_TILE_WIDTH=32 -DRASTER_TILE_HEIGHT=32
HOST_HASH_FLAGS_gcc-tiles-64x64 := -O2 -DRASTER_TILE_WIDTH=64 -DRASTER_TILE_HEIGHT=64
HOST_HASH_FLAGS_gcc-tiles-16x16 := -O2 -DRASTER_TILE_WIDTH=16 -DRASTER_TILE_HEIGHT=16
$(HOST_HASHES:%=$(B)/board/host_hash-%): $(B)/board/host_hash-%: tests/board/host_hash.c $(wildcard lut/*.[ch] raster/*.[ch])
	@mkdir -p $(@D)
	$(or $(HOST_HASH_CC_$*),gcc) -std=gnu11 $(HOST_HASH_FLAGS_$*) -Wall -Wextra -Werror $(CORE_INC) -o $@ $(filter %.c,$^)

$(B)/board/compare_oled: $(B)/host/tests/board/compare_oled.o $(B)/libhost.a
	@mkdir -p $(@D)
	$(CC) -o $@ $^ -lm

.PHONY: boards boards-build boards-built profile
boards: deps-board ## run the firmware on the emulated boards: hash, instructions, code, RAM, stack; all hashes must agree
	$(AGAIN) boards-built
boards-build: $(foreach t,$(BOARD_TARGETS),$(B)/board/$(t)/firmware.elf $(B)/board/$(t)/fault.elf) $(B)/board/lm3s6965/oled.elf \
    $(AMALGAMATED) $(AMALGAMATED_BOARDS:%=$(B)/board/%/amalgamated.elf) \
    $(B)/board/measured.img $(B)/board/lafortune_phong.img $(HOST_HASHES:%=$(B)/board/host_hash-%) $(B)/board/compare_oled
boards-built: boards-build
	@B=$(B) tests/board/boards.sh
# The check runs tests/e2e/test_boards.sh, the benchmark tests/board/bench.sh.
check-built: boards-build $(if $(WORK_MESH),$(WORK_BLOBS))
bench-built: boards-build $(B)/board/cortex-m4/push.elf $(if $(WORK_MESH),$(WORK_PROGRAMS))

$(B)/board/profile.so $(B)/board/trace.so: $(B)/board/%.so: tests/board/%.c tests/board/qemu_plugin.h
	@mkdir -p $(@D)
	$(CC) -std=gnu11 -O2 -g $(WARN) -fPIC -shared -o $@ $<
TARGET ?= cortex-m7
profile: $(B)/board/profile.so $(WORK_BLOBS) $(B)/board/$(TARGET)/work_a.elf ## instructions of a comparison frame by function, two frames, for TARGET and WORK=work_a|work_b
	@tests/board/run.sh $(TARGET) $(B)/board/$(TARGET)/work_a.elf $(B)/board/$(WORK).blob -plugin $(B)/board/profile.so

include tests/bench/bench.mk
