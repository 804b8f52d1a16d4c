# What the benchmarks of shading are built from and with.

# Its pixels get no tone curve: see tests/board/shade/sphere.h.
$(B)/host/tests/bench/bench_shade.o: CORE_INC += -Itests/board/shade
$(B)/bench/bench_shade: $(B)/host/tests/bench/bench_shade.o $(B)/host/tests/board/shade/sphere.o $(B)/libreference.a $(LIBS)
	@mkdir -p $(@D)
	$(CC) -Wl,--wrap=raster_finish_pixels -o $@ $^ -lz -lm -ldl
# The same for any processor of its kind, whatever HOST_ARCH says.
$(B)/bench/bench_shade_portable: $(B)/host/tests/bench/bench_shade.o $(B)/host/tests/board/shade/sphere.o $(B)/libreference.a $(B)/libhost.a \
    $(wildcard lut/*.[ch] raster/*.[ch])
	@mkdir -p $(@D)
	$(CC) -std=gnu11 -O2 -Wall -Wextra -Werror $(CORE_INC) -Wl,--wrap=raster_finish_pixels -o $@ $(filter %.c %.o,$^) \
	    $(filter %.a,$^) -lz -lm -ldl

# Tables of the demo's materials. $(call BENCH_TABLES,suffix,options of gtlut build)
define BENCH_TABLES
$(B)/bench/%_$(1).ktx2: $(B)/demo/%.csv $(B)/gtlut
	@mkdir -p $$(@D)
	$(B)/gtlut build $$< -o $$@ $(2) 2>$$@.log || { cat $$@.log >&2; exit 1; }
endef
BENCH_SIZES := 64K 16K 4K
$(foreach s,$(BENCH_SIZES),$(eval $(call BENCH_TABLES,$(s),--kind half_vector --size $(s))))
$(foreach s,$(BENCH_SIZES),$(eval $(call BENCH_TABLES,$(s)_packed,--kind half_vector --size $(s) --packed)))
$(eval $(call BENCH_TABLES,specular_frame,--kind specular_frame))
# Real materials, where the data folder has them.
BENCH_RGL := $(patsubst $(GONIOTILE_DATA)/brdf/%_rgb.bsdf,$(B)/bench/%_64K.ktx2,$(wildcard $(GONIOTILE_DATA)/brdf/*_rgb.bsdf))
$(BENCH_RGL): $(B)/bench/%_64K.ktx2: $(GONIOTILE_DATA)/brdf/%_rgb.bsdf $(B)/gtlut
	@mkdir -p $(@D)
	$(B)/gtlut build $< -o $@ --kind half_vector 2>$@.log || { cat $@.log >&2; exit 1; }

BENCH_FRAME_TABLES := 64K 64K_packed specular_frame
$(BENCH_FRAME_TABLES:%=$(B)/bench/six_models_%.img): $(B)/bench/six_models_%.img: $(B)/board/make_image $(B)/demo/six_models.blob \
    $(foreach m,$(MATERIALS),$(B)/bench/$(m)_%.ktx2)
	$< $@ 256 264 $(filter-out $<,$^)
BENCH_SHADE := $(BENCH_RGL) $(B)/bench/bench_shade $(B)/bench/bench_shade_portable $(B)/gtscene $(B)/board/trace.so $(foreach t,cortex-m3 cortex-m4 cortex-m7,$(B)/board/$(t)/shade.elf) \
    $(foreach s,$(BENCH_SIZES),$(B)/bench/gold_$(s).ktx2 $(B)/bench/gold_$(s)_packed.ktx2) \
    $(foreach s,$(BENCH_FRAME_TABLES),$(B)/bench/six_models_$(s).img)
bench-built: $(BENCH_SHADE)
.PHONY: shade-rows
shade-rows: $(BENCH_SHADE) $(B)/bench/bench_frame $(B)/board/lafortune_phong.img $(foreach t,cortex-m3 cortex-m7,$(B)/board/$(t)/firmware.elf) ## the benchmark's suite `shade` alone
	@B=$(B) tests/bench/shade_rows.sh

DEPS_BENCH += libegl-dev libgl-dev libopengl-dev libegl-mesa0 libgl1-mesa-dri
$(B)/bench/bench_llvmpipe: $(B)/host/tests/bench/bench_llvmpipe.o $(LIBS)
	@mkdir -p $(@D)
	$(CC) -o $@ $^ -lEGL -lOpenGL -lz -lm -ldl -lpthread
$(B)/bench/six_knots.blob: host_tools/scenes/six_knots.json $(B)/gtscene
	@mkdir -p $(@D)
	$(B)/gtscene build $< -o $@
bench-built: $(B)/bench/six_knots.blob

# Reads environment maps.
bench-built: $(B)/bench/goniotile_oiio.so

# Speaks of the reference alone.
$(B)/bench/bench_models: $(B)/host/tests/bench/bench_models.o $(B)/libreference.a
	@mkdir -p $(@D)
	$(CC) -o $@ $^ -lm
bench-built shade-rows: $(B)/bench/bench_models

.PHONY: contact-sheet contact-sheet-built
contact-sheet: deps-demo ## write build/bench/contact_sheet.png: materials by table sizes and models, with differences, to be looked at
	$(AGAIN) contact-sheet-built
# Beside the program, where it looks for it.
$(B)/bench/goniotile_oiio.so: $(B)/goniotile_oiio.so
	@mkdir -p $(@D)
	cp $< $@
contact-sheet-built: $(B)/gtlut $(B)/gtscene $(B)/bench/goniotile_oiio.so $(B)/bench/contact_sheet
	@B=$(B) tests/bench/contact_sheet.sh
