#!/bin/sh
# An installed Thrum is found by find_package and by pkg-config, as a static and as a shared
# library, and a program built on it runs. SPDX-License-Identifier: Apache-2.0
# usage: test_install.sh SOURCE BUILD COMPILER [SANITIZERS]
set -eu
source=$1 build=$2 compiler=$3 sanitize=${4:-}
flags=${sanitize:+-fsanitize=$sanitize}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM
unset PKG_CONFIG_PATH CMAKE_PREFIX_PATH || true

# Builds and runs the consumer both ways on what lies under a prefix.
consume() {
  prefix=$1
  echo "-- find_package: $prefix"
  cmake -G Ninja -S "$source/tests/install" -B "$prefix-cmake" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_C_COMPILER="$compiler" -DCMAKE_C_FLAGS="$flags"
  cmake --build "$prefix-cmake"
  "$prefix-cmake/consumer"

  echo "-- pkg-config: $prefix"
  pc=$(find "$prefix" -name thrum.pc)
  libdir=$(dirname "$(dirname "$pc")")
  # shellcheck disable=SC2046,SC2086 # flags are words
  PKG_CONFIG_PATH=$(dirname "$pc") "$compiler" -std=c11 $flags "$source/tests/install/consumer.c" \
    $(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --cflags --libs thrum) -o "$prefix-pc"
  LD_LIBRARY_PATH=$libdir "$prefix-pc"
  PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --exact-version="$version" thrum
}

version=$(sed -n 's/^#define THRUM_VERSION_STRING "\(.*\)"/\1/p' "$source/include/thrum/version.h")

# 1. what this build installs, the program with it; moved afterwards, for it must not know its place
cmake --install "$build" --prefix "$work/staged"
mv "$work/staged" "$work/static"
consume "$work/static"
test "$("$work/static/bin/thrum" --version)" = "thrum $version"
if [ -f "$build/viewer/viewer.html" ]; then
  test -f "$work/static/share/thrum/viewer.html"
fi
for header in "$source"/include/thrum/*.h; do
  test -f "$work/static/include/thrum/$(basename "$header")"
done

# 2. a shared library, the runtime alone: no other library is asked for
cmake -G Ninja -S "$source" -B "$work/shared-build" -DBUILD_SHARED_LIBS=ON \
  -DTHRUM_BUILD_PRECOMPUTE=OFF -DCMAKE_C_COMPILER="$compiler" -DTHRUM_SANITIZE="$sanitize"
cmake --build "$work/shared-build"
cmake --install "$work/shared-build" --prefix "$work/shared"
test -n "$(find "$work/shared" -name 'libthrum.so.*')"
consume "$work/shared"
echo "-- installed library works"
