#!/bin/sh
# test_kernel.c on another architecture, on ranks up to 40: test_cross.sh neon|wasm SOURCE BUILD
# SPDX-License-Identifier: Apache-2.0
set -eu
target=$1 source=$2 out=$3/tests/cross-$1
mkdir -p "$out"
cd "$source"
set -- -std=c11 -O2 -ffp-contract=off -DRANK_LIMIT=40 -Itests/cross -Iinclude -I. \
  tests/test_kernel.c runtime/kernel*.c runtime/polynomial.c runtime/model_pack.c runtime/status.c -lm
if [ "$target" = neon ]; then
  aarch64-linux-gnu-gcc -static "$@" -o "$out/test_kernel"
  exec qemu-aarch64 "$out/test_kernel"
fi
clang --target=wasm32-wasi -msimd128 "$@" -o "$out/test_kernel.wasm"
exec node --no-warnings --experimental-wasi-unstable-preview1 -e '
  const { WASI } = require("wasi");
  const wasi = new WASI({ version: "preview1", args: ["test_kernel"] });
  WebAssembly.instantiate(require("fs").readFileSync(process.argv[1]),
                          { wasi_snapshot_preview1: wasi.wasiImport })
    .then((made) => process.exit(wasi.start(made.instance) || 0));' "$out/test_kernel.wasm"
