#!/bin/sh
# Copies the files that git tracks, or would track, as they are now, into a new folder: builds write there and not
# in the tree. SPDX-License-Identifier: Apache-2.0
# usage: export_tree.sh SOURCE FOLDER
set -eu
source=$1 folder=$2
mkdir -p "$folder"
folder=$(CDPATH='' cd -- "$folder" && pwd)
cd "$source"
# a file that was removed and not yet committed is still listed
git ls-files --cached --others --exclude-standard | sort -u | while IFS= read -r name; do
  [ ! -e "$name" ] || printf '%s\n' "$name"
done | tar -c -T - | tar -x -C "$folder"
