#!/bin/sh
# Instructions of 1074 steps of the beam at rank 15, counted by valgrind: unlike times they do not
# depend on the load, so they show when a change makes steps dearer.
#   count_instructions.sh PROGRAM FOLDER     fails above the limits below
# valgrind has no AVX-512, so the AVX2 kernel is counted. SPDX-License-Identifier: Apache-2.0
set -eu
program=$1 folder=$2
mkdir -p "$folder"
"$program" precompute beam:20x3x3@1x0.15x0.15,split=6 --order 1 --fix 'x<0.001' --modes 8 --rank 15 -q \
  -o "$folder/count.npz" >/dev/null

# count LIMIT OPTION...
count() {
  limit=$1
  shift
  valgrind --tool=callgrind --callgrind-out-file="$folder/count.out" --toggle-collect=thrum_step \
    "$program" bench step "$folder/count.npz" --kernel avx2 "$@" --steps 50 --batches 1 \
    --no-machine --json -q >"$folder/count.json" 2>"$folder/count.err" ||
    { cat "$folder/count.err" >&2; exit 1; }
  found=$(sed -n 's/.*Collected : \([0-9]*\).*/\1/p' "$folder/count.err")
  printf '%s: %s instructions, at most %s\n' "$*" "$found" "$limit"
  [ "$found" -gt 0 ] && [ "$found" -le "$limit" ]
}

# a fifth more than gcc 12.2 -O3 takes, for other versions: 44162155, 66929795, 41105232
count 53000000 --implicit 6
count 80300000 --integrator newmark
count 49300000 --integrator energy
