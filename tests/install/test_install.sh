#!/bin/sh
# What a build installs, static or shared libraries, is found by find_package and by pkg-config, and a
# program built on it runs. SPDX-License-Identifier: Apache-2.0
# usage: test_install.sh SOURCE BUILD COMPILER
set -eu
source=$1 build=$2 compiler=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM
unset PKG_CONFIG_PATH CMAKE_PREFIX_PATH || true

# Builds and runs the consumer both ways on what lies under a prefix.
consume() {
  prefix=$1
  echo "-- find_package: $prefix"
  cmake -G Ninja -S "$source/tests/install" -B "$prefix-cmake" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_C_COMPILER="$compiler"
  cmake --build "$prefix-cmake"
  "$prefix-cmake/consumer"
  "$prefix-cmake/falling_body"

  echo "-- pkg-config: $prefix"
  pc=$(find "$prefix" -name thrum.pc)
  libdir=$(dirname "$(dirname "$pc")")
  # shellcheck disable=SC2046,SC2086 # flags are words
  PKG_CONFIG_PATH=$(dirname "$pc") "$compiler" -std=c11 "$source/tests/install/consumer.c" \
    $(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --cflags --libs thrum) -o "$prefix-pc"
  LD_LIBRARY_PATH=$libdir "$prefix-pc"
  PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --exact-version="$version" thrum
  # shellcheck disable=SC2046,SC2086
  PKG_CONFIG_PATH=$(dirname "$pc") "$compiler" -std=c11 "$source/tests/install/falling_body.c" \
    $(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --cflags --libs thrum-scene) -o "$prefix-scene"
  LD_LIBRARY_PATH=$libdir "$prefix-scene"

  # libm is named once, also to who links statically
  for package in thrum thrum-scene thrum-response thrum-gradient thrum-accelerator; do
    test "$(PKG_CONFIG_PATH=$(dirname "$pc") pkg-config --static --libs $package | tr ' ' '\n' | grep -cx -- -lm)" = 1
  done

  echo "-- licence and examples: $prefix"
  test -f "$prefix/share/doc/thrum/LICENSE"
  test -f "$prefix/share/doc/thrum/examples/jobs/slurm_array.sh"
  test -z "$(find "$prefix" -type d -empty)"
  compile_examples "$prefix" "$(dirname "$pc")"
}

# Each installed example is one command of the compiler; the embedded one needs a model's bytes, and
# the one of a scene its library.
compile_examples() {
  examples=$1/share/doc/thrum/examples
  printf 'static const _Alignas(64) unsigned char model_bytes[] = {0};\n' >"$work/model_bytes.h"
  for example in "$examples"/*.c; do
    package=thrum
    ! grep -q '"thrum/scene.h"' "$example" || package=thrum-scene
    ! grep -q '"thrum/gradient.h"' "$example" || package=thrum-gradient
    ! grep -q '"thrum/accelerator.h"' "$example" || package=thrum-accelerator
    # shellcheck disable=SC2046,SC2086
    "$compiler" -std=c11 -Wall -Wextra -Werror -I"$work" "$example" \
      $(PKG_CONFIG_PATH=$2 pkg-config --cflags --libs $package) -lm -o "$work/example"
  done
}

version=$(sed -n 's/^#define THRUM_VERSION_STRING "\(.*\)"/\1/p' "$source/include/thrum/version.h")

# what this build installs, the program with it; moved afterwards, for it must not know its place
cmake --install "$build" --prefix "$work/staged"
mv "$work/staged" "$work/installed"
consume "$work/installed"
test "$("$work/installed/bin/thrum" --version)" = "thrum $version"
if [ -f "$build/viewer/viewer.html" ]; then
  test -f "$work/installed/share/thrum/viewer.html"
fi
for header in "$source"/include/thrum/*.h; do
  test -f "$work/installed/include/thrum/$(basename "$header")"
done

# shared libraries carry the minor version in their names
if grep -q '^BUILD_SHARED_LIBS:[A-Z]*=ON' "$build/CMakeCache.txt"; then
  for library in libthrum libthrum_scene libthrum_response libthrum_gradient libthrum_accelerator; do
    test -n "$(find "$work/installed" -name "$library.so.${version%.*}")"
  done
fi

# the runtime alone asks for no other library, and is both of what there is to build
cmake -G Ninja -S "$source" -B "$work/alone" -DTHRUM_BUILD_PRECOMPUTE=OFF \
  -DCMAKE_C_COMPILER="$compiler" -DCMAKE_DISABLE_FIND_PACKAGE_PkgConfig=ON
ninja -C "$work/alone" -t targets all >"$work/targets"
grep -q '^libthrum_scene' "$work/targets"
if grep -q '^libthrum_mesh' "$work/targets"; then
  exit 1
fi
echo "-- installed library works"
