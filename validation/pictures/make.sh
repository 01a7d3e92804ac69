#!/bin/sh
# Makes the pictures of docs/: models_under_load.png from the models, those that compare schemes from
# the committed results. Needs gnuplot and Python 3. The target `pictures` calls it.
# usage: make.sh SOURCE PROGRAM
# SPDX-License-Identifier: Apache-2.0
set -eu
source=$1 program=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT INT TERM

python3 "$source/validation/pictures/models.py" "$program" "$work/models.png"
python3 "$source/validation/pictures/schemes.py" "$work"
python3 "$source/validation/pictures/orders.py" "$work"
python3 "$source/validation/pictures/fmu_bar.py" "$work"
mv "$work/models.png" "$source/docs/models_under_load.png"
for name in long_energy energy_schemes step_sizes work_impulse work_smooth tradeoff_fronts tradeoff_points order_cost fmu_bar \
  tradeoff_beam tradeoff_basket tradeoff_bridge tradeoff_horse tradeoff_tower tradeoff_heart; do
  mv "$work/$name.png" "$source/docs/$name.png"
done
