# The instruction sets the freestanding folders must compile for; sourced by cross.sh and the benchmarks.
# Debian packages: gcc-arm-none-eabi, gcc-riscv64-unknown-elf, clang-14.

TARGETS="cortex-m0 cortex-m3 cortex-m4 cortex-m7 cortex-m33 rv32imac x86-64"

# Files whose code runs once for a frame, a file or a request, or for few triangles, and func.c, which is faster so: compiled for size,
# by board.mk as well.
COLD="lut/func.c lut/half_vector.c lut/lut.c raster/bound.c raster/clip.c raster/general.c raster/quality.c raster/scene.c raster/transform.c"
COLD+=" firmware/app.c firmware/content.c firmware/messages.c firmware/protocol.c firmware/table_store.c"

# Compiler and machine options of a target. x86-64 is clang's turn, held to the integer registers: a float that slipped
# in would not compile.
target_cc() {
    case $1 in
    cortex-*) echo "arm-none-eabi-gcc -mcpu=$1 -mthumb" ;;
    rv32imac) echo "riscv64-unknown-elf-gcc -march=rv32imac -mabi=ilp32" ;;
    x86-64) echo "clang-14 --target=x86_64-linux-gnu -mgeneral-regs-only" ;;
    esac
}

# Prefix of a target's nm and size.
target_binutils() {
    case $1 in
    cortex-*) echo arm-none-eabi- ;;
    rv32imac) echo riscv64-unknown-elf- ;;
    esac
}

# Extended regular expression of the undefined symbols a target may leave to its run-time library.
target_allowed() {
    local memory='mem(cpy|set|move|cmp)'
    case $1 in
    cortex-m0) echo "$memory|__aeabi_mem(cpy|set|clr|move)[48]?|__aeabi_(lmul|uidiv|idiv|uidivmod|idivmod|llsl|llsr|lasr)|__clzsi2|__gnu_thumb1_case_[a-z]+" ;;
    cortex-*) echo "$memory|__aeabi_mem(cpy|set|clr|move)[48]?" ;;
    rv32imac) echo "$memory|__clzsi2|__(ashl|ashr|lshr)di3" ;;
    *) echo "$memory" ;;
    esac
}

# Compiles files for a target as freestanding code: one object per file in out_dir, warnings are errors, no -D.
target_compile() { # target out_dir extra_options file...
    local target=$1 out=$2 extra=$3 cc f level
    shift 3
    cc=$(target_cc "$target")
    mkdir -p "$out" || return 1
    for f in "$@"; do
        case " $COLD " in *" $f "*) level=-Os ;; *) level=-O2 ;; esac
        $cc -std=c11 $level $extra -ffreestanding -nostdinc -isystem "$($cc -print-file-name=include)" \
            -I. -Ilut -Iraster -Ifirmware -Ihal -Wall -Wextra -Werror -c "$f" -o "$out/$(tr / _ <<<"${f%.c}").o" || return 1
    done
}

# Code and constant data of an object file, in bytes.
target_text_bytes() { # target object
    "$(target_binutils "$1")size" "$2" | awk 'NR == 2 { print $1 }'
}

# Links objects into one relocatable object: duplicate symbols show, what stays undefined is asked of the run time.
target_link() { # target output object...
    local target=$1 output=$2
    shift 2
    if [ "$target" = x86-64 ]; then
        ld -r -o "$output" "$@"
    else
        $(target_cc "$target") -r -nostdlib -o "$output" "$@"
    fi
}

# Links a product, a file of tests/bench/products/, as what it refers to: memcpy and the like stay undefined. Puts the product's own code
# besides lut/, raster/ and budgets into $output.own.
target_product() { # target product output
    local target=$1 product=$2 output=$3 sections="-ffunction-sections -fdata-sections" objects
    objects=$(dirname "$output")/product_objects-$target
    if [ ! -d "$objects" ]; then
        target_compile "$target" "$objects" "$sections" lut/*.c raster/*.c firmware/budget*.c || return 1
    fi
    target_compile "$target" "$output.objects" "$sections" tests/bench/products/main.c "tests/bench/products/$product.c" &&
        target_link "$target" "$output.own" "$output.objects"/*.o &&
        $(target_cc "$target") -r -nostdlib -Wl,--gc-sections,-e,main -o "$output" "$output.own" "$objects"/*.o
}
