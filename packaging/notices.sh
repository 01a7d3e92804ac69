#!/bin/sh
# The notices of the libraries inside the relocatable tarball: for each Debian package that they come from its version,
# where its source is, and its copyright file with every licence. SPDX-License-Identifier: Apache-2.0
# usage: notices.sh FILE...
set -eu
cat <<'TEXT'
The program bin/thrum holds, or has beside it in lib/thrum, the libraries of others below. Thrum itself is under the
Apache License 2.0 (LICENSE). The supernodal part of CHOLMOD is under the GNU General Public License, version 2 or later:
the program as a whole may be passed on under version 3 of that licence, which the Apache License goes with. The source
of each library is that of the Debian source package named here, unchanged: `apt-get source NAME=VERSION` on Debian 12,
or https://snapshot.debian.org. The libraries libthrum and libthrum_scene hold nothing of others.
TEXT

# the packages of the files, where /lib and /usr/lib are one folder
for file in "$@"; do
  file=$(readlink -f "$file")
  dpkg -S "$file" 2>/dev/null || dpkg -S "${file#/usr}"
done | sed 's/:.*//' | sort -u >"${TMPDIR:-/tmp}/notices.$$"
while IFS= read -r package; do
  printf '\n\n======== %s\n' "$(dpkg-query -W -f 'Debian package ${binary:Package} ${Version}, source package ${source:Package} ${source:Version}' "$package" | sed 's/:amd64//')"
  cat "/usr/share/doc/$package/copyright"
done <"${TMPDIR:-/tmp}/notices.$$"
rm -f "${TMPDIR:-/tmp}/notices.$$"
printf '\n\n======== GNU General Public License, version 3\n'
cat /usr/share/common-licenses/GPL-3
printf '\n\n======== GNU Lesser General Public License, version 2.1\n'
cat /usr/share/common-licenses/LGPL-2.1
