#!/bin/sh
# Makes the committed results of condensed models again (docs/condensed.md, pages 16 and 17 of the
# mathematics): condensed_results.sh BUILD FOLDER, after
#   cmake --build BUILD --target thrum_condensed_cost thrum_condensed_errors
# Two minutes on one core; the costs want a quiet machine. SPDX-License-Identifier: Apache-2.0
set -eu
build=$1 folder=$2
mkdir -p "$folder"
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# errors MODEL MODES RANK TIME SWINGS MASTERS: the rows of one body
errors() {
  "$build/thrum" precompute "$1" --modes "$2" --rank "$3" -q -o "$work/$1.npz" >"$work/said" 2>&1 ||
    { cat "$work/said" >&2; exit 1; }
  "$build/thrum_condensed_errors" "$work/$1.npz" "$4" "$5" "$6" >"$work/rows"
  # the header once
  [ "$1" = beam ] && head -1 "$work/rows" >"$folder/errors.csv"
  sed -e 1d -e 's/\.npz,/,/' "$work/rows" >>"$folder/errors.csv"
}
errors beam 15 30 1.2 0.1,0.2,0.3 4,6,8,12,20
errors heart 12 40 1.2 0.1,0.2 4,8,12,20
errors tower 12 30 1.2 0.15,0.3 4,8,12,20
errors horse 12 40 1.2 0.05,0.15 4,8,12,20
errors bridge 15 30 1.2 0.5,1 4,8,12,20
errors basket 12 40 1.2 0.03,0.1 4,8,12,20

# what steps cost, at three swings
for swing in 0.05 0.1 0.2; do
  echo "# thrum_condensed_cost beam.npz $swing"
  "$build/thrum_condensed_cost" "$work/beam.npz" "$swing"
done >"$folder/cost.txt"
