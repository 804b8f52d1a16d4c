# The report: experiments of Cezner and Havran 2024 and of James 2022, and what tables cost. A chapter is a script tests/report/N_name.sh.
DEPS_REPORT := $(DEPS_DEMO) $(CROSS) gnuplot-nox nodejs qemu-system-arm
.PHONY: deps-report report report-built
deps-report:
	@tests/install_deps.sh $(DEPS_REPORT)
report: deps-report ## write build/report/REPORT.md: the literature's experiments with pictures, plots and CSV
	$(AGAIN) report-built
# Beside goniotile_oiio.so.
REPORT_PROGRAMS := $(patsubst tests/report/%.c,$(B)/report_%,$(wildcard tests/report/*.c))
$(REPORT_PROGRAMS): $(B)/report_%: $(B)/host/tests/report/%.o $(B)/libreference.a $(LIBS)
	$(CC) -o $@ $^ -lgsl -lgslcblas -lz -lm -ldl
report-programs: all $(REPORT_PROGRAMS)
check-built: $(REPORT_PROGRAMS)
report-built: report-programs demo-data budget-boards $(BUDGET_BOARDS:%=$(B)/board/%/firmware.elf) $(B)/board/make_image \
    $(B)/board/measured.img $(B)/board/lafortune_phong.img
	@B=$(B) tests/report/report.sh
# tests/bench/de03_rows.sh
bench-built: $(B)/report_difference
