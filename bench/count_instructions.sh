#!/bin/sh
# Instructions of 150 steps of the beam at rank 15 with 6 implicit modes, counted by valgrind: unlike
# times they do not depend on the load, so they show when a change makes steps dearer.
#   count_instructions.sh PROGRAM FOLDER     fails above the limit below
# valgrind has no AVX-512, so the AVX2 kernel is counted. SPDX-License-Identifier: Apache-2.0
set -eu
program=$1 folder=$2
limit=11000000 # gcc 12.2 -O3 takes 9121124; a fifth more is for other versions
mkdir -p "$folder"
"$program" precompute beam:20x3x3@1x0.15x0.15 --fix 'x<0.001' --modes 8 --rank 15 -q \
  -o "$folder/count.npz" >/dev/null
valgrind --tool=callgrind --callgrind-out-file="$folder/count.out" --toggle-collect=thrum_step \
  "$program" bench step "$folder/count.npz" --kernel avx2 --implicit 6 --steps 50 --batches 1 \
  --no-machine --json -q >"$folder/count.json" 2>"$folder/count.err" ||
  { cat "$folder/count.err" >&2; exit 1; }
count=$(sed -n 's/.*Collected : \([0-9]*\).*/\1/p' "$folder/count.err")
printf '%s instructions, at most %s\n' "$count" "$limit"
[ "$count" -gt 0 ] && [ "$count" -le "$limit" ]
