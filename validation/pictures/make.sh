#!/bin/sh
# Makes the pictures of the README: docs/models_under_load.png from the models, docs/long_energy.png
# from the committed results of the long run. Needs gnuplot and Python 3. The target `pictures` calls it.
# usage: make.sh SOURCE PROGRAM
# SPDX-License-Identifier: Apache-2.0
set -eu
source=$1 program=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM

python3 "$source/validation/pictures/models.py" "$program" "$work/models.png"
long=$source/validation/results/long
gnuplot -e "input='$long/long_windows.csv'; runs='$long/long.csv'; output_file='$work/long.png'" \
  "$source/validation/pictures/long_energy.gp"
mv "$work/models.png" "$source/docs/models_under_load.png"
mv "$work/long.png" "$source/docs/long_energy.png"
