#!/bin/sh
# Makes small models of the six bodies and lets the soak step them (soak.c).
#   soak.sh THRUM SOAK FOLDER STEPS [SEED]
# SPDX-License-Identifier: Apache-2.0
set -eu
thrum=$1
soak=$2
folder=$3
mkdir -p "$folder"
for body in beam basket bridge heart horse tower; do
  [ -f "$folder/$body.npz" ] ||
    "$thrum" precompute "$body" --modes 3 --rank 6 -q -o "$folder/$body.npz" >"$folder/$body.txt"
done
exec "$soak" "$4" "${5:-1}" "$folder"/*.npz
