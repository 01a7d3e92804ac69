#!/bin/sh
# Installs the packages in a clean Debian, runs their tests there, removes them, and demands that nothing stays
# behind: what piuparts does. Needs root, debootstrap, and the network for Debian's own packages.
# SPDX-License-Identifier: Apache-2.0
# usage: deb_check.sh FOLDER_OF_DEBS [CHROOT.tar]
set -eu
debs=$1 base=${2:-}
root=$(mktemp -d /var/tmp/thrum-deb.XXXXXX)
# what is mounted inside is let go before anything is removed
finish() {
  code=$?
  for point in proc dev; do umount -R "$root/$point" 2>/dev/null || true; done
  grep -q " $root/" /proc/mounts || rm -rf --one-file-system "$root"
  exit "$code"
}
trap finish EXIT INT TERM

if [ -n "$base" ] && [ -f "$base" ]; then
  tar -x -C "$root" -f "$base"
else
  debootstrap --variant=minbase bookworm "$root" http://deb.debian.org/debian >/dev/null
  [ -z "$base" ] || tar -c -C "$root" -f "$base" .
fi
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount --make-rslave "$root/dev"
cp /etc/resolv.conf "$root/etc/resolv.conf"

inside() { chroot "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
# every file but what apt and dpkg note for themselves
files() {
  (cd "$root" && find . \( -path ./proc -o -path ./dev -o -path ./sys -o -path ./tmp -o -path ./packages \
    -o -path ./var/lib/apt -o -path ./var/cache -o -path ./var/log -o -path ./var/lib/dpkg \) -prune \
    -o -print | LC_ALL=C sort)
}
quiet() { "$@" >"$root/tmp/log" 2>&1 || { cat "$root/tmp/log"; exit 1; }; }

# what the packages and their tests need comes first, so that what is left afterwards is of ours
mkdir "$root/packages"
for name in "$debs"/*.deb; do
  case $name in *-dbgsym_*) ;; *) cp "$name" "$root/packages/" ;; esac
done
cp -r "$debs/thrum-0/debian/tests" "$root/packages/tests"
quiet inside apt-get update
needs=$(for name in "$root"/packages/*.deb; do dpkg-deb -f "$name" Depends; done | tr ',' '\n' |
  sed -e 's/ *|.*//' -e 's/ *(.*//' -e 's/:any//' -e 's/^ *//' | grep -vE 'thrum|^$' | sort -u)
# shellcheck disable=SC2086 # names
quiet inside apt-get install -y --no-install-recommends gcc libc6-dev cmake make pkg-config $needs
files >"$root/tmp/before"

echo "-- install"
quiet inside sh -c 'apt-get install -y --no-install-recommends /packages/*.deb'
inside sh -c 'dpkg-query -W -f "\${Package} \${Version} \${db:Status-Status}\n" "*thrum*"'
mkdir "$root/packages/tree"
cp -r "$debs/thrum-0/debian" "$debs/thrum-0/tests" "$root/packages/tree/"
for name in c-library program python; do
  echo "-- test $name"
  inside sh -c "cd /packages/tree && debian/tests/$name >/tmp/log 2>&1 || { cat /tmp/log; exit 1; }; tail -n 2 /tmp/log"
done

echo "-- install again over itself"
quiet inside sh -c 'apt-get install -y --reinstall --no-install-recommends /packages/*.deb'

echo "-- remove and purge"
inside sh -c "dpkg-query -W -f '\${db:Status-Status} \${Package}\n' '*thrum*'" | sed -n 's/^installed //p' >"$root/tmp/names"
# shellcheck disable=SC2046
quiet inside dpkg --remove $(cat "$root/tmp/names")
# shellcheck disable=SC2046
quiet inside dpkg --purge $(cat "$root/tmp/names")
files >"$root/tmp/after"
diff "$root/tmp/before" "$root/tmp/after" || { echo "the packages leave files behind" >&2; exit 1; }
echo "nothing is left behind, $(wc -l <"$root/tmp/after") files as before"
