#!/bin/sh
# test_kernel.c and test_inverse.c, on ranks up to 40, on another architecture:
# test_cross.sh neon|wasm SOURCE BUILD
# SPDX-License-Identifier: Apache-2.0
set -eu
target=$1 source=$(cd "$2" && pwd) out=$3/tests/cross-$1
rm -rf "$out"
mkdir -p "$out"
cd "$out"
case $target in
neon) compiler="aarch64-linux-gnu-gcc -static" ;;
wasm) compiler="clang --target=wasm32-wasi -msimd128" ;;
esac
flags="-std=c11 -O2 -ffp-contract=off -DRANK_LIMIT=40"
flags="$flags -I$source/tests/cross -I$source/include -I$source"

# both tests link the same objects
# shellcheck disable=SC2086
$compiler $flags -c "$source"/tests/cross/kernel_table.c "$source"/core/base/*.c "$source"/core/polynomial/*.c \
  "$source"/core/linear_algebra/*.c "$source"/runtime/kernels/*.c "$source"/runtime/batch/batch_kernel*.c \
  "$source"/runtime/material/*.c "$source"/runtime/points/kernel_points.c "$source"/runtime/points/point_law.c \
  "$source"/runtime/points/point_rest.c
for name in test_kernel test_inverse; do
  # shellcheck disable=SC2086
  $compiler $flags "$source"/tests/*/*/"$name.c" ./*.o -lm -o "$name"
  if [ "$target" = neon ]; then
    qemu-aarch64 "./$name"
    continue
  fi
  node --no-warnings --experimental-wasi-unstable-preview1 -e '
    const { WASI } = require("wasi");
    const wasi = new WASI({ version: "preview1", args: ["test"] });
    WebAssembly.instantiate(require("fs").readFileSync(process.argv[1]),
                            { wasi_snapshot_preview1: wasi.wasiImport })
      .then((made) => process.exit(wasi.start(made.instance) || 0));' "$name"
done
