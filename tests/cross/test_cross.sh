#!/bin/sh
# test_kernel.c, on ranks up to 40, and test_inverse.c on another architecture:
# test_cross.sh neon|wasm SOURCE BUILD
# SPDX-License-Identifier: Apache-2.0
set -eu
target=$1 source=$2 out=$3/tests/cross-$1
mkdir -p "$out"
cd "$source"
set -- -std=c11 -O2 -ffp-contract=off -DRANK_LIMIT=40 -Itests/cross -Iinclude -I. \
  runtime/base/*.c runtime/polynomial/*.c runtime/linear_algebra/*.c
for name in test_kernel test_inverse; do
  if [ "$target" = neon ]; then
    aarch64-linux-gnu-gcc -static tests/*/*/"$name.c" "$@" -lm -o "$out/$name"
    qemu-aarch64 "$out/$name"
    continue
  fi
  clang --target=wasm32-wasi -msimd128 tests/*/*/"$name.c" "$@" -lm -o "$out/$name.wasm"
  node --no-warnings --experimental-wasi-unstable-preview1 -e '
    const { WASI } = require("wasi");
    const wasi = new WASI({ version: "preview1", args: ["test"] });
    WebAssembly.instantiate(require("fs").readFileSync(process.argv[1]),
                            { wasi_snapshot_preview1: wasi.wasiImport })
      .then((made) => process.exit(wasi.start(made.instance) || 0));' "$out/$name.wasm"
done
