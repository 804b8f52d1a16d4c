# What the benchmarks of shading are built from and with.

# Its pixels get no tone curve: see tests/board/shade/sphere.h.
$(B)/host/tests/bench/bench_shade.o: CORE_INC += -Itests/board/shade
$(B)/bench/bench_shade: $(B)/host/tests/bench/bench_shade.o $(B)/host/tests/board/shade/sphere.o $(B)/libreference.a $(LIBS)
	@mkdir -p $(@D)
	$(CC) -Wl,--wrap=raster_finish_pixels -o $@ $^ -lz -lm -ldl
