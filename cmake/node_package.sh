#!/bin/sh
# Builds the viewer or the npm package: installs npm's packages as they are pinned, then runs build.mjs. Says
# what is missing. SPDX-License-Identifier: Apache-2.0
# usage: node_package.sh viewer|javascript [ARGUMENT OF build.mjs...]
set -eu
here=$(CDPATH='' cd -- "$(dirname -- "$0")/../$1" && pwd)
shift

missing() {
  echo "thrum: $1 missing; Debian 12 has it in: $2" >&2
  exit 1
}

command -v node >/dev/null 2>&1 || missing "node is" nodejs
command -v npm >/dev/null 2>&1 || missing "npm is" npm
[ "$(node -p 'process.versions.node.split(".")[0] >= 18')" = true ] ||
  missing "node 18 or newer is" nodejs
probe=$(mktemp)
printf 'int main(void) { return 0; }\n' |
  "${CLANG:-clang}" --target=wasm32-wasi -x c - -o "$probe" 2>/dev/null ||
  missing "a clang for WebAssembly is" "clang lld wasi-libc libclang-rt-14-dev-wasm32"
rm -f "$probe"

# the mark is newer than the list of packages when those are installed
mark=$here/node_modules/.thrum
if [ ! -f "$mark" ] || [ -n "$(find "$here/package-lock.json" -newer "$mark")" ]; then
  (cd "$here" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error)
  touch "$mark"
fi
exec node "$here/build.mjs" "$@"
