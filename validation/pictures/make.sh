#!/bin/sh
# Makes the pictures of the README: docs/models_under_load.png from the models, docs/long_energy.png
# from the committed results of the long run. Needs gnuplot. The target `pictures` calls it.
# usage: make.sh SOURCE PROGRAM RENDERER
# SPDX-License-Identifier: Apache-2.0
set -eu
source=$1 program=$2 renderer=$3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM

for name in horse tower bridge basket heart beam; do
  "$program" precompute "$name" -o "$work/$name.npz" -q >/dev/null
done
"$renderer" "$work/models.ppm" "$work"
# behind the header of three lines
tail -n +4 "$work/models.ppm" >"$work/models.rgb"
gnuplot -e "input='$work/models.rgb'; output_file='$work/models.png'" \
  "$source/validation/pictures/models.gp"

windows=$source/validation/results/long/long_windows.csv
gnuplot -e "input='$windows'; output_file='$work/long.png'" "$source/validation/pictures/long_energy.gp"
mv "$work/models.png" "$source/docs/models_under_load.png"
mv "$work/long.png" "$source/docs/long_energy.png"
