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
  "$source/study/pictures/models.gp"

# the committed results where they hold all that is drawn, else the rows of them that were drawn last
windows=$source/study/results/long_3m/long_windows.csv
for run in horse,imexv,0.05 horse,newmark,0.05 horse,energy,0.05 \
  beam,imexv,0.1 beam,newmark,0.1 beam,energy,0.1; do
  grep -q "^$run," "$windows" || windows=$source/study/pictures/long_energy.csv
done
gnuplot -e "input='$windows'; output_file='$work/long.png'" "$source/study/pictures/long_energy.gp"
mv "$work/models.png" "$source/docs/models_under_load.png"
mv "$work/long.png" "$source/docs/long_energy.png"
