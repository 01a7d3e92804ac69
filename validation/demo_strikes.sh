#!/bin/sh
# Which strikes newmark is lost after, in the case of ./run demo: the beam, struck at its free end
# for 3 ms by 1780 to 1880 N, so that it swings by about a tenth of its length; a minute of steps of
# 3 ms. Lost means more than twice the energy of the strike, at most 9 J. Prints the table
# results/demo/strikes.csv: the force, and when newmark was lost, nothing where it was not.
#
# usage: demo_strikes.sh THRUM >strikes.csv
# SPDX-License-Identifier: Apache-2.0
set -eu
thrum=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
echo force_n,lost_s
for force in $(seq 1780 5 1880); do
  # a run that is flagged, exit code 3, is what is looked for
  "$thrum" simulate beam -o "$work/run" --integrator newmark --dt 0.003 --time 60 \
    --load "impulse:0,0,-$force@load" --record-every 5 -q --json >"$work/run.json" 2>/dev/null || [ $? = 3 ]
  awk -F, -v force="$force" 'NR > 1 && $5 > 18 { lost = $2; exit }
    END { print force "," (lost == "" ? "" : lost + 0) }' "$work/run/energy.csv"
done
