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
    for product in measured_only measured_lafortune specular_lafortune_blinn everything everything_budgets; do
        linked=$work/$t-$product.o
        target_product "$t" $product "$linked"
        echo "code,$t,$product,linked,text,$(($(target_text_bytes "$t" "$linked") - $(target_text_bytes "$t" "$linked.own"))),bytes"
    done
done
