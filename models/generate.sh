#!/bin/sh
# Makes the meshes beside the geometry: generate.sh [NAME...], default every .geo here and of the
# scenes in examples; a name may have a folder, from here. Needs gmsh (4.8 made the committed ones;
# another version makes other meshes, and the materials in the .json files are tuned for the
# committed ones).
#
# SPDX-License-Identifier: Apache-2.0
set -eu
cd "$(dirname "$0")"

if ! command -v gmsh >/dev/null 2>&1; then
  echo "generate.sh: gmsh is not installed; the committed meshes stay (apt-get install gmsh)" >&2
  exit 1
fi
if [ $# -eq 0 ]; then
  set -- *.geo ../examples/scenes/*.geo
fi

temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
trap 'exit 1' HUP INT TERM

for name in "$@"; do
  name=${name%.geo}
  # one thread, so that the same gmsh makes the same file; gmsh may exit 0 after an error
  made=$temporary/$(basename "$name").msh
  if ! gmsh -3 -nt 1 -format msh22 -v 2 "$name.geo" -o "$made" \
    >"$temporary/log" 2>&1 || grep -q '^Error' "$temporary/log"; then
    cat "$temporary/log" >&2
    echo "generate.sh: $name.geo gave no mesh" >&2
    exit 1
  fi
  # through a file beside the target, so that nobody reads half a mesh
  cp "$made" "$name.msh.new"
  mv "$name.msh.new" "$name.msh"
  echo "$name.msh" >&2
done
