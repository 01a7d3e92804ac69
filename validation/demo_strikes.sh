#!/bin/sh
# Which strikes newmark is lost after, in the case of ./run demo: the beam, struck at its free end
# for 3 ms by 1300 to 1700 N, so that it swings by about a tenth of its length; a minute at 60 steps a
# second. Lost means more than twice the energy of the strike, at most 5.1 J. Prints the table
# results/demo/strikes.csv: the force, and when newmark was lost, nothing where it was not.
#
# usage: demo_strikes.sh THRUM >strikes.csv
# SPDX-License-Identifier: Apache-2.0
set -eu
thrum=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
echo force_n,lost_s
for force in $(seq 1300 20 1700); do
  # a run that is flagged, exit code 3, is what is looked for
  "$thrum" simulate beam -o "$work/run" --integrator newmark --dt 0.016666666666666666 --time 60 \
    --load "impulse:0,0,-$force@load" -q --json >"$work/run.json" 2>/dev/null || [ $? = 3 ]
  awk -F, -v force="$force" 'NR > 1 && $5 > 10.2 { lost = $2; exit }
    END { print force "," (lost == "" ? "" : lost + 0) }' "$work/run/energy.csv"
done
