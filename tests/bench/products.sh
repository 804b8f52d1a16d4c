#!/usr/bin/env bash
# Prints rows of results.csv: code and constants that products link, in bytes, lut/ and raster/ and where there are budgets
# firmware/budget*.c; without the product's own. A product is a file of tests/bench/products/.
#   tests/bench/products.sh [TARGET...]
set -eu
cd "$(dirname "$0")/../.."
. tests/targets.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for t in ${@:-cortex-m3 cortex-m7 rv32imac}; do
    target_compile "$t" "$work/$t" "-ffunction-sections -fdata-sections" lut/*.c raster/*.c firmware/budget*.c
    target_compile "$t" "$work/$t/products" "-ffunction-sections -fdata-sections" tests/bench/products/*.c
    main=$work/$t/products/tests_bench_products_main.o
    for product in measured_only measured_lafortune specular_lafortune_blinn everything everything_budgets; do
        own=$work/$t/products/tests_bench_products_$product.o
        # What is not referred to goes; memcpy and the like stay undefined.
        $(target_cc "$t") -r -nostdlib -Wl,--gc-sections,-e,main -o "$work/linked.o" "$main" "$own" "$work/$t"/*.o
        echo "code,$t,$product,linked,text,$(($(target_text_bytes "$t" "$work/linked.o") - $(target_text_bytes "$t" "$main") - $(target_text_bytes "$t" "$own"))),bytes"
    done
done
