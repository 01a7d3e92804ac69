#!/bin/sh
# Builds every fuzz target (build.sh), and runs each on its corpus and for a bounded number of new
# inputs from a fixed seed.
#   test_fuzz.sh SOURCE_FOLDER BUILD_FOLDER CLANG [RUNS] [SECONDS_EACH] [TARGETS]
# An input that crashes a target is left in BUILD_FOLDER/fuzz; once the fault is fixed, the input
# belongs in the corpus. fuzz_long.py runs for hours.
# SPDX-License-Identifier: Apache-2.0
set -eu
source=$(cd "$1" && pwd)
build=$2/fuzz
runs=${4:-2000}
seconds=${5:-1}

targets=$("$source/tests/fuzz/build.sh" "$source" "$build" "$3" "${6:-"fuzz_*"}" brief)
for name in $targets; do
  work=$build/$name.found
  mkdir -p "$work"
  echo "$name"
  # new inputs go to the work folder; the corpus in the tree stays as it is
  "$build/$name" -seed=1 -runs="$runs" -max_total_time="$seconds" -max_len=8192 -timeout=20 \
    -rss_limit_mb=2048 -artifact_prefix="$build/" -print_final_stats=0 -verbosity=0 \
    "$work" "$source/tests/fuzz/corpus/${name#fuzz_}"
done
