# Absence of run-time errors, by abstract interpretation.
DEPS_PROVE := gcc frama-c-base
.PHONY: prove
prove: ## run Frama-C's Eva over parsers, evaluation, USB core and protocol; every alarm must be explained
	@tests/install_deps.sh $(DEPS_PROVE)
	@tests/prove/prove.sh
