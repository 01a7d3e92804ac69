#!/bin/sh
# Runs a command where /usr/bin/node is that of Debian's package nodejs, whatever node is installed: its packages are
# unpacked into a folder, and laid over /usr for the command alone, in a mount namespace of its own. Nothing is installed.
# Exit code 77, with a line that says why, where that cannot be. SPDX-License-Identifier: Apache-2.0
# usage: with_debian_node.sh FOLDER COMMAND...    or with_debian_node.sh --needed, exit 0 where node is another one
set -eu

skip() {
  echo "with_debian_node: $*" >&2
  exit 77
}

# Debian's newest version of the package. Those of others, such as NodeSource, repack no sources.
version_of() {
  apt-cache madison "$1" 2>/dev/null | awk -F ' *[|] *' '$2 ~ /[+]dfsg/ { print $2; exit }'
}

command -v apt-cache >/dev/null 2>&1 || skip "this is not Debian"
version=$(version_of nodejs)
[ -n "$version" ] || skip "apt knows no nodejs of Debian's; apt-get update may help"
if [ "$1" = --needed ]; then
  [ "$(node --version 2>/dev/null)" != "v${version%%[+]*}" ]
  exit
fi
mkdir -p "$1"
folder=$(CDPATH='' cd -- "$1" && pwd)
shift

# its libraries, and the scripts that Debian keeps apart from it, as far as they are not installed
if [ "$(cat "$folder/version" 2>/dev/null)" != "$version" ]; then
  rm -rf "${folder:?}/usr" "$folder/packages"
  mkdir "$folder/packages"
  names=nodejs=$version
  while [ -n "$names" ]; do
    # shellcheck disable=SC2086 # words
    (cd "$folder/packages" && apt-get download -q $names >"$folder/log" 2>&1) || skip "apt-get cannot download $names"
    names=
    for package in "$folder"/packages/*.deb; do
      dpkg-deb -x "$package" "$folder"
      for name in $(dpkg-deb -f "$package" Depends | tr ',' '\n' | sed -e 's/ *|.*//' -e 's/ *(.*//' -e 's/:any//'); do
        case " $names" in *" $name "* | *" $name="*) continue ;; esac
        if dpkg -s "$name" 2>/dev/null | grep -q '^Status: install ok installed' ||
          [ -n "$(find "$folder/packages" -name "${name}_*")" ]; then
          continue
        fi
        # the library has the version of the program
        case $name in libnode*) name=$name=$version ;; esac
        names="$names$name "
      done
    done
  done
  # libraries of a machine without /usr merged would lie beside it
  [ ! -d "$folder/lib" ] || { cp -a "$folder/lib" "$folder/usr/" && rm -rf "${folder:?}/lib"; }
  rm -rf "$folder/packages"
  echo "$version" >"$folder/version"
fi

# whoever is not root becomes the root of a namespace
as_root=
[ "$(id -u)" -eq 0 ] || as_root=--map-root-user
# shellcheck disable=SC2086,SC2016 # no word where there is none
unshare $as_root --mount sh -c 'mount -t overlay overlay -o "lowerdir=$1/usr:/usr" /usr' sh "$folder" 2>"$folder/log" ||
  skip "nothing can be laid over /usr here: $(cat "$folder/log")"
# shellcheck disable=SC2086,SC2016
exec unshare $as_root --mount sh -eu -c '
  mount -t overlay overlay -o "lowerdir=$1/usr:/usr" /usr
  shift
  PATH=/usr/bin:$PATH
  export PATH
  exec "$@"' sh "$folder" "$@"
