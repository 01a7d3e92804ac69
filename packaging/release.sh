#!/bin/sh
# Makes every artefact of a release from a clean clone of the last commit: source tarball, wheels, source distribution,
# npm package, Debian packages, relocatable tarball and documentation site, with a bill of materials and checksums. The
# same commit and the same packages of Debian give the same bytes, in whatever folder, time zone or language.
# It refuses a commit without a result of ./run bare test, unless THRUM_WITHOUT_BARE is set.
# Needs root and the network, and takes an hour on two cores. SPDX-License-Identifier: Apache-2.0
# usage: release.sh SOURCE FOLDER [DEBIAN_11]
set -eu
source=$(CDPATH='' cd -- "$1" && pwd)
umask 022
rm -rf "$2"
mkdir -p "$2/artefacts"
folder=$(CDPATH='' cd -- "$2" && pwd)
out=$folder/artefacts
old=${3:-$folder/debian-11}
step() { printf 'release: %s\n' "$*" >&2; }
# what takes long runs behind the words of THRUM_RUN_WITH, such as nice
quiet() { ${THRUM_RUN_WITH:-} "$@" >"$folder/log" 2>&1 || { tail -n 60 "$folder/log" >&2; exit 1; }; }

# what would differ between two machines or two days is set here: the time of every file is that of the commit
[ -z "$(git -C "$source" status --porcelain)" ] || step "changes that are not committed are left out"
quiet git clone --no-local "$source" "$folder/clone"
clone=$folder/clone
SOURCE_DATE_EPOCH=$(git -C "$clone" log -1 --format=%ct)
export SOURCE_DATE_EPOCH LC_ALL=C.UTF-8 TZ=UTC PYTHONHASHSEED=0 PYTHONDONTWRITEBYTECODE=1
chmod -R u=rwX,go=rX "$clone"
version=$(sed -n 's/^#define THRUM_VERSION_STRING "\(.*\)"/\1/p' "$clone/include/thrum/version.h")
cd "$clone"

# what is handed out has passed its tests where nothing of ours was installed
if [ -n "${THRUM_WITHOUT_BARE:-}" ]; then
  step "tests on a bare Debian 12 are not asked for"
else
  packaging/bare_record.sh check .
fi

# packs a folder so that its bytes tell of its files alone: pack NAME.tar.gz PARENT FOLDER
pack() {
  tar -c --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner --mode=u=rwX,go=rX \
    --format=ustar -C "$2" "$3" | gzip -9n >"$1"
}

step "source tarball"
git archive --format=tar --prefix="thrum-$version/" HEAD | gzip -9n >"$out/thrum-$version-source.tar.gz"

step "source distribution and wheels for Python"
# runs a hook of PEP 517 in a folder: hook FOLDER NAME OUTPUT
hook() {
  (cd "$1" && quiet /usr/bin/python3 -c \
    'import sys, setuptools.build_meta as backend; getattr(backend, sys.argv[1])(sys.argv[2])' "$2" "$3")
}
python=$folder/python
mkdir -p "$python/tree" "$python/sdist"
packaging/export_tree.sh . "$python/tree"
hook "$python/tree" build_sdist "$python"
tar -xzf "$python/thrum-$version.tar.gz" -C "$python/sdist"
pack "$out/thrum-$version.tar.gz" "$python/sdist" "thrum-$version"
prefix="-ffile-prefix-map=$python/sdist/thrum-$version=."
# the folder of each build is left out of what is compiled, and the symbols of the library are its own business
export CMAKE_ARGS="'-DCMAKE_C_FLAGS=$prefix' -DCMAKE_SHARED_LINKER_FLAGS=-s"
hook "$python/sdist/thrum-$version" build_wheel "$out"
rm -rf "$python/sdist/thrum-$version/build"
CMAKE_ARGS="$CMAKE_ARGS -DCMAKE_SYSTEM_NAME=Linux -DCMAKE_SYSTEM_PROCESSOR=aarch64 -DCMAKE_C_COMPILER=aarch64-linux-gnu-gcc"
hook "$python/sdist/thrum-$version" build_wheel "$out"
unset CMAKE_ARGS

step "npm package"
quiet cmake/node_package.sh javascript
(cd javascript && quiet npm pack --ignore-scripts --pack-destination "$folder")
mv "$folder/thrum-$version.tgz" "$out/thrum-$version-npm.tgz"

step "Debian packages"
quiet packaging/deb.sh "$clone" "$folder/deb" viewer
cp "$folder"/deb/*.deb "$out/"

step "relocatable tarball"
quiet packaging/tarball.sh "$clone" "$folder/tarball" "$old"
cp "$folder/tarball/thrum-$version-linux-x86_64.tar.gz" "$out/"

step "documentation site"
quiet cmake -S . -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTHRUM_BUILD_TESTS=OFF \
  -DTHRUM_BUILD_PYTHON=ON -DTHRUM_BUILD_VIEWER=ON
quiet cmake --build "$folder/build"
quiet /usr/bin/python3 docs/site/build.py "$clone" "$folder/build" "$folder/site"
mv "$folder/site/html" "$folder/site/thrum-$version-site"
pack "$out/thrum-$version-site.tar.gz" "$folder/site" "thrum-$version-site"

step "bill of materials and checksums"
/usr/bin/python3 packaging/bill.py "$clone" "$out" "$folder/tarball/archives" >"$folder/bill.json"
mv "$folder/bill.json" "$out/thrum-$version.cdx.json"
(cd "$out" && sha256sum -- * >../SHA256SUMS && mv ../SHA256SUMS .)
/usr/bin/python3 packaging/bill.py --check "$out"
cat "$out/SHA256SUMS"
