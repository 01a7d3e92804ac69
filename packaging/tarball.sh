#!/bin/sh
# The relocatable tarball: the program with all it needs but glibc, for any Linux on x86-64 with glibc 2.31 or newer,
# the library, headers, models and the notices of what is inside.
#
# The program is linked against the C library of Debian 11, so that it asks for no symbol newer than 2.31, and
# holds the static libraries of Debian 12; two of which Debian has shared ones only, METIS and cJSON, lie beside it.
# Every file is then judged by the symbol versions that it needs, and the program makes, steps and checks a model in
# that Debian 11. Needs root and debootstrap for Debian 11. SPDX-License-Identifier: Apache-2.0
# usage: tarball.sh SOURCE FOLDER [DEBIAN_11]
set -eu
floor=2.31
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
source=$(CDPATH='' cd -- "$1" && pwd)
mkdir -p "$2"
folder=$(CDPATH='' cd -- "$2" && pwd)
old=${3:-$folder/debian-11}
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(dpkg-parsechangelog -l "$source/debian/changelog" -S Timestamp)}
export SOURCE_DATE_EPOCH LC_ALL=C.UTF-8 TZ=UTC PATH=/usr/sbin:/usr/bin:/sbin:/bin
umask 022
quiet() { "$@" >"$folder/log" 2>&1 || { tail -n 40 "$folder/log" >&2; exit 1; }; }

[ "$(dpkg --print-architecture)" = amd64 ] || { echo "tarball.sh: x86-64 is needed" >&2; exit 1; }
if [ ! -f "$old/usr/lib/x86_64-linux-gnu/libc.so" ]; then
  quiet debootstrap --variant=minbase bullseye "$old" http://deb.debian.org/debian
  quiet chroot "$old" apt-get install -y --no-install-recommends libc6-dev
fi
[ "$(chroot "$old" dpkg-query -W -f '${Version}' libc6 | cut -d- -f1)" = $floor ]

# the objects, as a package has them
rm -rf "$folder/tree" "$folder/build" "$folder/shared" "$folder/root"
"$here/export_tree.sh" "$source" "$folder/tree"
version=$(sed -n 's/^#define THRUM_VERSION_STRING "\(.*\)"/\1/p' "$folder/tree/include/thrum/version.h")
name=thrum-$version-linux-x86_64
flags="-ffile-prefix-map=$folder/tree=. -ffile-prefix-map=$folder/build=."
quiet cmake -S "$folder/tree" -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTHRUM_BUILD_TESTS=OFF \
  -DTHRUM_SOURCE_FALLBACK=OFF -DTHRUM_USE_MUMPS=OFF -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_C_FLAGS="$flags" \
  ${THRUM_LAUNCHER:+-DCMAKE_C_COMPILER_LAUNCHER=$THRUM_LAUNCHER}
quiet cmake --build "$folder/build"
quiet cmake --install "$folder/build" --prefix "$folder/root/$name"

# what the program holds: archives of Debian 12
lib=/usr/lib/x86_64-linux-gnu
archives="$lib/libcholmod.a $lib/libamd.a $lib/libcolamd.a $lib/libccolamd.a $lib/libcamd.a $lib/libsuitesparseconfig.a
  $lib/libarpack.a $lib/liblapacke.a $lib/libtmglib.a $lib/openblas-pthread/libopenblas.a $lib/libexpat.a $lib/libz.a"
for archive in libgfortran.a libquadmath.a libgomp.a; do
  archives="$archives $(gcc -print-file-name=$archive)"
done
beside="$lib/libmetis.so.5 $lib/libcjson.so.1"
root=$folder/root/$name

# What the linker reads of Debian 11, whose absolute links would lead into this system
sysroot=$folder/sysroot
triple=x86_64-linux-gnu
rm -rf "$sysroot"
mkdir -p "$sysroot/lib/$triple" "$sysroot/lib64" "$sysroot/usr/lib/$triple"
for library in libc.so.6 libm.so.6 libmvec.so.1 libpthread.so.0 libdl.so.2; do
  cp -L "$old/lib/$triple/$library" "$sysroot/lib/$triple/"
done
cp "$old/lib/$triple/ld-$floor.so" "$sysroot/lib64/ld-linux-x86-64.so.2"
for file in crti.o crtn.o Scrt1.o libc.so libc_nonshared.a libm.so; do
  cp -L "$old/usr/lib/$triple/$file" "$sysroot/usr/lib/$triple/"
done

# libgcc_s, which every Linux with glibc has, is the one part of gcc that is not inside: the static one asks for
# glibc 2.35
quiet gcc -std=c11 -O2 -Wall -Wextra -Werror -fPIE $flags -c "$here/glibc_compat.c" -o "$folder/build/glibc_compat.o"
# shellcheck disable=SC2046,SC2086 # lists of files
quiet gcc --sysroot="$sysroot" -B"$sysroot/usr/lib/$triple" -L"$sysroot/lib/$triple" -L"$sysroot/usr/lib/$triple" \
  -pie -shared-libgcc -Wl,--allow-shlib-undefined -Wl,-z,relro,-z,now -Wl,--as-needed -Wl,--build-id=sha1 \
  -Wl,-rpath,'$ORIGIN/../lib/thrum' -o "$root/bin/thrum" \
  $(find "$folder/build/CMakeFiles/thrum_program.dir" -name '*.o' | sort) "$folder/build/glibc_compat.o" \
  -Wl,--start-group $(find "$folder/build" -maxdepth 1 -name 'libthrum*.a' | sort) $archives -Wl,--end-group \
  $beside "$sysroot/lib/$triple/libpthread.so.0" "$sysroot/lib/$triple/libdl.so.2" -lm
strip "$root/bin/thrum"
mkdir -p "$root/lib/thrum"
# shellcheck disable=SC2086
cp -L $beside "$root/lib/thrum/"

# the shared libraries beside the static ones, as the installed CMake files name the latter; each finds the other beside it
quiet cmake -S "$folder/tree" -B "$folder/shared" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTHRUM_BUILD_TESTS=OFF \
  -DTHRUM_BUILD_PRECOMPUTE=OFF -DBUILD_SHARED_LIBS=ON -DCMAKE_BUILD_RPATH_USE_ORIGIN=ON -DCMAKE_INSTALL_LIBDIR=lib \
  -DCMAKE_C_FLAGS="$flags" \
  ${THRUM_LAUNCHER:+-DCMAKE_C_COMPILER_LAUNCHER=$THRUM_LAUNCHER}
quiet cmake --build "$folder/shared"
cp -P "$folder"/shared/libthrum.so* "$folder"/shared/libthrum_scene.so* \
  "$folder"/shared/libthrum_response.so* "$folder"/shared/libthrum_gradient.so* \
  "$folder"/shared/libthrum_accelerator.so* "$root/lib/"
for library in "$root"/lib/libthrum*.so.*.*.*; do
  strip --strip-unneeded "$library"
done

# shellcheck disable=SC2086
"$here/notices.sh" $archives $beside >"$root/NOTICES"
# shellcheck disable=SC2086
printf '%s\n' $archives $beside >"$folder/archives"
cp "$folder/tree/LICENSE" "$folder/tree/README.md" "$folder/tree/CHANGELOG.md" "$root/"

# no symbol of a newer C library, and no library from elsewhere
for file in "$root/bin/thrum" "$root"/lib/libthrum*.so.*.*.* "$root"/lib/thrum/*; do
  newest=$(objdump -T "$file" | sed -n 's/.*GLIBC_\([0-9.]*\)).*/\1/p' | sort -uV | tail -n 1)
  needed=$(readelf -d "$file" | sed -n 's/.*NEEDED.*\[\(.*\)\]/\1/p' | tr '\n' ' ')
  printf '%-32s glibc %-6s needs %s\n' "${file#"$root"/}" "$newest" "$needed"
  [ "$(printf '%s\n' "$newest" $floor | sort -V | tail -n 1)" = $floor ] || { echo "newer than $floor" >&2; exit 1; }
  for library in $needed; do
    case $library in
    libc.so.6 | libm.so.6 | libpthread.so.0 | libdl.so.2 | ld-linux-x86-64.so.2 | libgcc_s.so.1 | libmetis.so.5 | libcjson.so.1 | libthrum.so.*) ;;
    *) echo "$file needs $library" >&2; exit 1 ;;
    esac
  done
done

# and no folder of whoever built it
! grep -rlF "$folder" "$root" || { echo "these name the folder in which they were built" >&2; exit 1; }

# unpacked anywhere in Debian 11, without anything installed
rm -rf "$old/opt/else where"
mkdir -p "$old/opt/else where"
cp -a "$root" "$old/opt/else where/"
cp "$source/debian/tests/program" "$old/opt/program"
mount -t proc proc "$old/proc"
status=0
chroot "$old" env -i PATH=/usr/bin:/bin /opt/program "/opt/else where/$name/bin/thrum" >"$folder/log" 2>&1 &&
  chroot "$old" env -i PATH=/usr/bin:/bin HOME=/tmp "/opt/else where/$name/bin/thrum" info beam >>"$folder/log" 2>&1 || status=$?
umount "$old/proc"
rm -rf "$old/opt/else where"
grep energy "$folder/log" || true
[ $status = 0 ] || { cat "$folder/log" >&2; exit 1; }

# the same bytes whenever it is made
tar -c --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner -C "$folder/root" "$name" |
  gzip -9n >"$folder/$name.tar.gz"
ls -l "$folder/$name.tar.gz"
