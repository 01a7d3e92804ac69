#!/bin/sh
# Makes the committed results of speed again, for a quiet machine: results.sh PROGRAM FOLDER
# About a quarter of an hour on one core. SPDX-License-Identifier: Apache-2.0
set -eu
program=$1 folder=$2
ranks=5,10,15,20,30,45,60,80,100
mkdir -p "$folder"
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
unset OPENBLAS_CORETYPE
"$program" bench kernels --rank "$ranks" --batches 100 -q -o "$folder" >"$folder/kernels.txt"
"$program" bench step --rank "$ranks" -q --swing 0.2 -o "$folder" >"$folder/step_default.txt"
# one setting after the other into one table, each under the command that gives it
step() {
  echo "thrum bench step $*"
  "$program" bench step "$@" -q --batches 100
}
{
  step --rank 15 --implicit 6 --integrator imexv
  step --rank 30,60 --implicit 3 --integrator imexv
  step --rank 15,30,60 --swing 0.2 --integrator imexv
  # sound, 44,100 steps a second: 22.7 us each
  step --rank 30 --dt 2.267573696145125e-5 --integrator imexv
  step --rank 15,30,60 --integrator newmark
  step --rank 15,30,60 --integrator energy
} >"$folder/step.txt"
{
  echo "# steps of the beam by imexv at ranks 60, 80 and 100 with coefficients in double and in single precision"
  for rank in 60 80 100; do
    for precision in double single; do
      "$program" precompute beam:20x3x3@1x0.15x0.15,split=6 --order 1 --fix 'x<0.001' --modes $((rank / 2)) \
        --rank "$rank" --precision "$precision" -q -o "$work/$precision.npz" >/dev/null
      echo "$precision"
      "$program" bench step "$work/$precision.npz" --implicit 3 --integrator imexv --no-machine -q | tail -1
    done
  done
} >"$folder/precision.txt"
for integrator in imexv energy; do
  for swing in 0.02 0.1 0.4; do
    echo "thrum bench batch --rank 30 --bodies 300 --swing $swing --integrator $integrator"
    "$program" bench batch --rank 30 --bodies 300 --swing "$swing" --integrator "$integrator" -q
  done
done >"$folder/batch.txt"
for threads in 1 2; do
  echo "thrum bench contact --threads $threads"
  "$program" bench contact --threads $threads
done >"$folder/contact.txt"
"$program" bench displacement >"$folder/displacement.txt"
