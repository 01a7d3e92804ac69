#!/bin/sh
# Makes a release twice, in folders of other names, another time zone, language and mask of files, and demands the same
# bytes of every artefact. SPDX-License-Identifier: Apache-2.0
# usage: release_twice.sh SOURCE FOLDER [DEBIAN_11]
set -eu
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
mkdir -p "$2"
folder=$(CDPATH='' cd -- "$2" && pwd)
old=${3:-$folder/debian-11}
"$here/release.sh" "$1" "$folder/first" "$old"
(
  export TZ=Asia/Kathmandu LC_ALL=C LANG=C
  umask 077
  # the same commit, whatever was committed meanwhile
  "$here/release.sh" "$folder/first/clone" "$folder/another/second" "$old"
) >/dev/null

# the sums are of all artefacts, the bill of materials included
if ! diff "$folder/first/artefacts/SHA256SUMS" "$folder/another/second/artefacts/SHA256SUMS"; then
  echo "release_twice.sh: these artefacts differ" >&2
  exit 1
fi
echo "$(wc -l <"$folder/first/artefacts/SHA256SUMS") artefacts, the same bytes twice"
