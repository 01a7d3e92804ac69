#!/bin/sh
# Builds the viewer into FOLDER/viewer.html and FOLDER/thrum.wasm: npm's packages as they are pinned,
# then build.mjs. Says what is missing. SPDX-License-Identifier: Apache-2.0
# usage: make.sh FOLDER
set -eu
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
mkdir -p "$1"
folder=$(CDPATH='' cd -- "$1" && pwd)

missing() {
  echo "viewer: $1 missing; Debian 12 has it in: $2" >&2
  exit 1
}

command -v node >/dev/null 2>&1 || missing "node is" nodejs
command -v npm >/dev/null 2>&1 || missing "npm is" npm
[ "$(node -p 'process.versions.node.split(".")[0] >= 18')" = true ] ||
  missing "node 18 or newer is" nodejs
printf 'int main(void) { return 0; }\n' |
  "${CLANG:-clang}" --target=wasm32-wasi -x c - -o "$folder/probe.wasm" 2>/dev/null ||
  missing "a clang for WebAssembly is" "clang lld wasi-libc libclang-rt-14-dev-wasm32"
rm -f "$folder/probe.wasm"

# the mark is newer than the list of packages when those are installed
mark=$here/node_modules/.thrum
if [ ! -f "$mark" ] || [ -n "$(find "$here/package-lock.json" -newer "$mark")" ]; then
  (cd "$here" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
  touch "$mark"
fi
exec node "$here/build.mjs" "$folder"
