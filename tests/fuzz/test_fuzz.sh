#!/bin/sh
# Builds every fuzz target fuzz_*.c with clang's libFuzzer and the sanitizers, and runs each on its
# corpus and for a bounded number of new inputs from a fixed seed. The sources that a target needs
# are listed in its first comment, after "sources:"; those of the mesh readers are the same for all.
#   test_fuzz.sh SOURCE_FOLDER BUILD_FOLDER CLANG [RUNS] [SECONDS_EACH] [TARGETS]
# A longer run: test_fuzz.sh . build/release clang 100000000 600. An input that crashes a target is
# left in BUILD_FOLDER/fuzz; once the fault is fixed, the input belongs in the corpus.
# SPDX-License-Identifier: Apache-2.0
set -eu
source=$(cd "$1" && pwd)
build=$2/fuzz
clang=$3
runs=${4:-20000}
seconds=${5:-3}
wanted=${6:-"fuzz_*"}
flags="-std=c11 -O1 -g1 -I$source -I$source/include"
flags="$flags -D_POSIX_C_SOURCE=200809L -ffp-contract=off"
flags="$flags -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer"
mesh_sources="mesh/*.c mesh/formats/*.c io/text.c io/file.c"
mesh_sources="$mesh_sources platform/interrupt.c runtime/base/quadratic_tet.c runtime/base/status.c"

mkdir -p "$build"

# a header that changed may concern any object
headers=$build/headers
if [ ! -e "$headers" ] ||
  [ -n "$(find "$source" -path '*/build' -prune -o -name '*.h' -newer "$headers" -print)" ]; then
  rm -f "$build"/*.o
fi
: >"$headers"

# compiles the sources that are newer than their objects; the objects' names go to $objects
compile() {
  objects=
  for pattern in "$@"; do
    for file in "$source"/$pattern; do
      object=$build/$(basename "$(dirname "$file")")_$(basename "$file" .c).o
      objects="$objects $object"
      [ -n "$(find "$object" -newer "$file" 2>/dev/null)" ] && continue
      # shellcheck disable=SC2086
      "$clang" $flags -fsanitize=fuzzer-no-link -c "$file" -o "$object"
    done
  done
}

for target in "$source"/tests/fuzz/$wanted.c; do
  name=$(basename "$target" .c)
  case $name in
  fuzz_mesh_*) sources=$mesh_sources ;;
  *) sources=$(sed -n '/sources:/,/SPDX/p' "$target" | tr ' ' '\n' | grep '\.c$') ;;
  esac
  # shellcheck disable=SC2086
  compile $sources
  # functions that a target does not reach may miss the sources that they call
  # shellcheck disable=SC2086
  "$clang" $flags -fsanitize=fuzzer -no-pie -Wl,--unresolved-symbols=ignore-in-object-files "$target" \
    $objects -lexpat -lm -o "$build/$name"
  corpus=$source/tests/fuzz/corpus/${name#fuzz_}
  work=$build/$name.found
  mkdir -p "$work"
  echo "$name"
  # new inputs go to the work folder; the corpus in the tree stays as it is
  "$build/$name" -seed=1 -runs="$runs" -max_total_time="$seconds" -max_len=8192 -timeout=20 \
    -rss_limit_mb=2048 -artifact_prefix="$build/" -print_final_stats=0 -verbosity=0 \
    "$work" "$corpus"
done
