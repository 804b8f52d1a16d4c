# Fuzz harnesses: everything once more, by clang with libFuzzer's instrumentation, in $(B)/fuzz.
FUZZ_FORMATS := gtm rgl merl ktx2 composite astm zemax cornell sgd csv
FUZZ_NAMES   := protocol usb table atlas scene $(FUZZ_FORMATS:%=import_%)
FUZZ_CC      := clang-14
FUZZ_SAN     := -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all -fsanitize=fuzzer-no-link \
                -fprofile-instr-generate -fcoverage-mapping
# The importers end by exit(), and images are not read by OpenImageIO: see fuzz_import.c.
FUZZ_WRAP    := -Wl,--wrap=exit,--wrap=image_read_rgb,--wrap=malloc,--wrap=calloc,--wrap=realloc,--wrap=vasprintf,--wrap=free
FUZZ_LIBS    := -lgsl -lgslcblas -lz -lm -ldl
export FUZZ_SECONDS

.PHONY: deps-fuzz fuzz fuzz-programs fuzz-built fuzz-corpus
deps-fuzz: ## install what `make fuzz` needs
	@tests/install_deps.sh $(DEPS_FUZZ)
fuzz: FUZZ_SECONDS ?= 600
fuzz: deps-fuzz ## fuzz every parser for FUZZ_SECONDS (600) each; prints runs, findings and coverage
	$(AGAIN) fuzz-programs
	@B=$(B) FUZZ_KEEP=1 tests/fuzz/test_fuzz.sh

# Nothing where this compiler has no libFuzzer: the test says so.
fuzz-programs:
	@echo 'int LLVMFuzzerTestOneInput(const char *p, long n) { return p && !n; }' | \
	    $(FUZZ_CC) -fsanitize=fuzzer -x c - -o /dev/null 2>/dev/null || exit 0; \
	$(MAKE) --no-print-directory B=$(B)/fuzz CC=$(FUZZ_CC) OPT=-O1 WARN=-Wall SAN='$(FUZZ_SAN)' fuzz-built
fuzz-built: $(FUZZ_NAMES:%=$(B)/fuzz_%)
$(FUZZ_NAMES:%=$(B)/fuzz_%): $(B)/fuzz_%: $(B)/san/host/tests/fuzz/fuzz_%.o $(LIBS_SAN)
	$(CC) $(SAN) -fsanitize=fuzzer $(if $(filter import_%,$*),$(FUZZ_WRAP)) -o $@ $^ $(FUZZ_LIBS)
$(B)/san/host/tests/fuzz/fuzz_import_%.o: tests/fuzz/fuzz_import.c
	@mkdir -p $(@D)
	$(CC) $(TEST) $(SAN) -DFORMAT='"$*"' -c $< -o $@

# The seeds in the tree, written anew when a format has changed.
fuzz-corpus: $(B)/tests/fuzz/make_corpus
	ASAN_OPTIONS=detect_leaks=0 $< tests/fuzz/corpus
