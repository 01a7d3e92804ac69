#!/bin/sh
# Builds the Debian packages in a copy of the tree and has lintian judge them: an error of lintian fails.
# With "viewer" the page of the viewer becomes a package too, which needs npm and the network.
# SPDX-License-Identifier: Apache-2.0
# usage: deb.sh SOURCE FOLDER [viewer]
set -eu
source=$1 folder=$2 profile=
[ "${3:-}" != viewer ] || profile=-Ppkg.thrum.viewer
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
rm -rf "$folder"
mkdir -p "$folder"
folder=$(CDPATH='' cd -- "$folder" && pwd)

"$here/export_tree.sh" "$source" "$folder/thrum-0"
cd "$folder/thrum-0"
version=$(dpkg-parsechangelog -S Version)
header=$(sed -n 's/^#define THRUM_VERSION_STRING "\(.*\)"/\1/p' include/thrum/version.h)
[ "$version" = "$header" ] || {
  echo "debian/changelog has version $version, include/thrum/version.h has $header" >&2
  exit 1
}

# the same bytes on every machine: one time for all files, and no trace of the folder
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(dpkg-parsechangelog -S Timestamp)}
export SOURCE_DATE_EPOCH LC_ALL=C.UTF-8 TZ=UTC
umask 022
# the system's tools, not those that somebody put before them
PATH=/usr/sbin:/usr/bin:/sbin:/bin
export PATH
# shellcheck disable=SC2086 # no word where there is no profile
dpkg-buildpackage -us -uc -b $profile
cd "$folder"
lintian --fail-on error --display-info ./*.changes
ls -l ./*.deb
