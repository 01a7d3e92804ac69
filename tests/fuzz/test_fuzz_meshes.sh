#!/bin/sh
# Builds every fuzz target fuzz_mesh_*.c with clang's libFuzzer and the sanitizers, and runs each on its
# corpus and for a bounded number of new inputs from a fixed seed.
#   test_fuzz_meshes.sh SOURCE_FOLDER BUILD_FOLDER CLANG [RUNS] [SECONDS_EACH]
# Longer: test_fuzz_meshes.sh . build/release clang 100000000 600. What crashes a target is left in
# BUILD_FOLDER/fuzz; once mended it goes into the corpus.
# SPDX-License-Identifier: Apache-2.0
set -eu
source=$(cd "$1" && pwd)
build=$2/fuzz
clang=$3
runs=${4:-20000}
seconds=${5:-4}
flags="-std=c11 -O1 -g -I$source -I$source/include -D_POSIX_C_SOURCE=200809L -ffp-contract=off"
flags="$flags -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer"

mkdir -p "$build"
objects=
for file in "$source"/precompute/mesh*.c "$source"/precompute/text.c "$source"/precompute/quality.c \
  "$source"/precompute/file.c "$source"/precompute/interrupt.c \
  "$source"/runtime/status.c; do
  [ -e "$file" ] || continue
  object=$build/$(basename "$(dirname "$file")")_$(basename "$file" .c).o
  [ -n "$(find "$object" -newer "$file" 2>/dev/null)" ] && objects="$objects $object" && continue
  # shellcheck disable=SC2086
  "$clang" $flags -fsanitize=fuzzer-no-link -c "$file" -o "$object"
  objects="$objects $object"
done

for target in "$source"/tests/fuzz/fuzz_mesh_*.c; do
  name=$(basename "$target" .c)
  # shellcheck disable=SC2086
  "$clang" $flags -fsanitize=fuzzer "$target" $objects -lm -o "$build/$name"
  corpus=$source/tests/fuzz/corpus/${name#fuzz_}
  work=$build/$name.found
  mkdir -p "$work"
  echo "$name"
  # the work folder takes what is new, the corpus in the tree stays as it is
  "$build/$name" -seed=1 -runs="$runs" -max_total_time="$seconds" -max_len=4096 -timeout=20 \
    -rss_limit_mb=2048 -artifact_prefix="$build/" -print_final_stats=0 -verbosity=0 \
    "$work" "$corpus"
done
