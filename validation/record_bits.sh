#!/bin/sh
# Records what the program computes, to the last bit, so that a change which must not alter any
# number (a renaming, a move, a new layout of the code) can be shown not to have done so.
# usage: record_bits.sh PROGRAM [SOURCE]
#
#   sh validation/record_bits.sh build/release/thrum >before.txt
#   (make the change and build it)
#   sh validation/record_bits.sh build/release/thrum >after.txt
#   diff before.txt after.txt
#
# PROGRAM is a built `thrum`. SOURCE is the folder whose models/ and examples/scenes/ are the
# inputs; by default it is the project that this script belongs to. Name the same SOURCE both times
# when the inputs themselves have changed in between.
#
# Each line of the output is `NAME SHA256` or, where the command gave no result,
# `NAME failed EXITCODE`; the script goes on after a failure and then exits with 1. A run that
# finishes with a warning (exit code 3) counts as a result. The lines cover the model files and each
# array in them (the arrays need unzip), the states and energies of runs with every integrator, runs
# that need the fallback chain, the energy correction or the switch to the energy integrator, static
# answers, the unreduced body, scenes, and frames with stress. No line depends on a time or a path.
# Of energy.csv and probes.csv the numbers count and the line of column names does not.
#
# The hashes hold for one machine, one compiler and one BLAS: compare two programs that were built
# alike, and run both on the same machine. It takes half a minute on one core.
# SPDX-License-Identifier: Apache-2.0
set -u
if [ $# -lt 1 ] || [ $# -gt 2 ]; then
  echo "usage: record_bits.sh PROGRAM [SOURCE]" >&2
  exit 2
fi
program=$1
source=${2:-$(dirname "$0")/..}
if ! [ -x "$program" ] || ! [ -d "$source/models" ] || ! [ -d "$source/examples/scenes" ]; then
  echo "record_bits.sh: $program is no program, or $source has no models/ and examples/scenes/" >&2
  exit 2
fi

work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
trap 'exit 1' INT TERM PIPE

# models that a scene names are made by this program and not taken from the user's cache
THRUM_MODELS=$(cd "$source/models" && pwd)
XDG_CACHE_HOME=$work/cache
export THRUM_MODELS XDG_CACHE_HOME
failures=0

# prints the hash of standard input
hash() {
  if command -v sha256sum >/dev/null 2>&1; then
    sha256sum | cut -d ' ' -f 1
  else
    shasum -a 256 | cut -d ' ' -f 1
  fi
}

# runs a command of the program silently; its exit code is left in $code
thrum() {
  "$program" "$@" -q >/dev/null 2>&1
  code=$?
}

# print_failure NAME
print_failure() {
  echo "$1 failed $code"
  failures=$((failures + 1))
}

# succeeded FILE: whether the last command ended well, possibly with a warning, and wrote FILE
succeeded() {
  { [ "$code" -eq 0 ] || [ "$code" -eq 3 ]; } && [ -s "$1" ]
}

# print_file NAME FILE: the line of a file that the last command was to write
print_file() {
  if succeeded "$2"; then
    echo "$1 $(hash <"$2")"
  else
    print_failure "$1"
  fi
}

# print_folder NAME FOLDER: the lines of the arrays and of the energies that a run wrote
print_folder() {
  if ! succeeded "$2/end.npy"; then
    print_failure "$1"
    return
  fi
  for array in "$2"/*.npy; do
    echo "$1.$(basename "$array" .npy) $(hash <"$array")"
  done
  echo "$1.energy $(tail -n +2 "$2/energy.csv" | hash)"
}

# model NAME MESH [OPTIONS]: makes a model file and prints the line of it and of each array in it
model() {
  name=$1
  shift
  thrum precompute "$@" --reproducible -o "$work/$name.npz"
  print_file "model.$name" "$work/$name.npz"
  if command -v unzip >/dev/null 2>&1 && succeeded "$work/$name.npz"; then
    for array in $(unzip -Z1 "$work/$name.npz"); do
      echo "model.$name.$(basename "$array" .npy) $(unzip -p "$work/$name.npz" "$array" | hash)"
    done
  fi
}

# simulate NAME MODEL [OPTIONS]: steps a model and prints the lines of the run
simulate() {
  name=$1 body=$2
  shift 2
  thrum simulate "$body" -o "$work/run.$name" "$@"
  print_folder "$name" "$work/run.$name"
}

# static NAME MODEL [OPTIONS]: finds an equilibrium and prints the line of its coordinates
static() {
  name=$1 body=$2
  shift 2
  thrum static "$body" -o "$work/$name.npy" "$@"
  print_file "$name" "$work/$name.npy"
}

# scene NAME [OPTIONS]: runs a scene and prints the lines of its probes and of each body
scene() {
  name=$1
  shift
  thrum simulate "$source/examples/scenes/$name.json" -o "$work/scene.$name" "$@"
  if ! succeeded "$work/scene.$name/probes.csv"; then
    print_failure "scene.$name"
    return
  fi
  echo "scene.$name.probes $(tail -n +2 "$work/scene.$name/probes.csv" | hash)"
  for body in "$work/scene.$name"/*/; do
    print_folder "scene.$name.$(basename "$body")" "${body%/}"
  done
}

# body NAME MODERATE LARGE FORCE: everything that is done with each of the six models. MODERATE and
# LARGE are the displacements of a start in metres, FORCE is the load of models/NAME.json.
body() {
  body_name=$1 file=$work/$1.npz moderate=mode:1,$2 large=mode:1,$3 force=$4@load
  model "$body_name" "$body_name"

  # 200 steps with each integrator; verlet is stable at a shorter step only
  for integrator in imexv newmark midpoint energy; do
    simulate "$body_name.$integrator" "$file" --integrator "$integrator" --time 0.6 --start "$moderate"
  done
  simulate "$body_name.verlet" "$file" --integrator verlet --dt 0.0005 --time 0.1 --start "$moderate"

  # the forms of imexv and of damping
  simulate "$body_name.imexv-thesis" "$file" --integrator imexv --split-form thesis --time 0.6 --start "$moderate"
  simulate "$body_name.imexv-quadratic" "$file" --integrator imexv --split-form quadratic --time 0.6 --start "$moderate"
  simulate "$body_name.imexv-fixed" "$file" --integrator imexv --adaptive off --time 0.6 --start "$moderate"
  simulate "$body_name.imexv-sampling" "$file" --integrator imexv --split sampling --time 0.6 --start "$moderate"
  simulate "$body_name.damped" "$file" --integrator imexv --damping 0.3,0.001 --time 0.6 --start "$moderate"
  for integrator in imexv newmark energy; do
    simulate "$body_name.$integrator-tangent" "$file" --integrator "$integrator" \
      --damping 0.3,0.001 --damping-form tangent --time 0.6 --start "$moderate"
  done

  # a load that starts and ends, on fewer coordinates
  simulate "$body_name.loaded" "$file" --integrator imexv --load "square:$force" --rank 10 --time 0.6

  # long enough for the energy correction, and far enough for the other ways out of a failed step
  simulate "$body_name.long" "$file" --integrator imexv --time 60 --record-every 100 --start "$moderate"
  for integrator in imexv newmark energy; do
    simulate "$body_name.$integrator-large" "$file" --integrator "$integrator" --dt 0.006 \
      --time 1.2 --start "$large"
  done
  static "$body_name.static" "$file" --load "constant:$force"
}

body beam 0.05 0.4 0,0,-13
body basket 0.05 0.6 210,0,0
body bridge 0.3 2 0,0,-72000
body heart 0.05 0.3 0,76,0
body horse 0.1 0.6 0,4000,0
body tower 0.2 1 2000,0,0

# options of precompute that the six models leave at their defaults
model beam-single beam --precision single
model beam-linear beam --order 1
model beam-lumped beam --mass lumped
model beam-handles beam --handles load
model beam-free beam:8x2x2@1x0.2x0.2
simulate beam-single.imexv "$work/beam-single.npz" --integrator imexv --time 0.6 --start mode:1,0.05
simulate beam-free.imexv "$work/beam-free.npz" --integrator imexv --time 0.6 --start mode:1,0.02

# few iterations allowed, so that steps are halved
simulate beam.newmark-halved "$work/beam.npz" --integrator newmark --iterations 2 --time 0.6 \
  --start mode:1,0.4
simulate beam.newmark-damped "$work/beam.npz" --integrator newmark --newmark 0.3025,0.6 --time 0.6 \
  --start mode:1,0.05

# frames with stress, by the last of them
thrum simulate "$work/beam.npz" -o "$work/frames" --integrator imexv --time 0.3 --start mode:1,0.05 \
  --frames every-50 --stress
print_file beam.frame "$work/frames/frames/frame_000002.vtu"

# the unreduced body, of linear tetrahedra and of ten nodes; central differences need a step below
# 0.3 ms
for integrator in energy newmark midpoint; do
  simulate "full.$integrator" "$work/beam-linear.npz" --full --integrator "$integrator" --dt 0.001 \
    --time 0.02 --start mode:1,0.05
done
simulate full.verlet "$work/beam-linear.npz" --full --integrator verlet --dt 0.0002 --time 0.01 \
  --start mode:1,0.05
simulate full.cg "$work/beam-linear.npz" --full --linear-solver cg --dt 0.001 --time 0.01 \
  --start mode:1,0.05
static full.static "$work/beam-linear.npz" --full --load gravity:0,0,-9.81
simulate full.ten "$work/beam.npz" --full --dt 0.001 --time 0.01 --start mode:1,0.05

for scene_name in drop quake wind integrators; do
  scene "$scene_name"
done

[ "$failures" -eq 0 ]
