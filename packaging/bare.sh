#!/bin/sh
# Runs ./run demo or ./run test in a bare Debian 12: minbase by debootstrap with git, sudo and an ordinary user who may
# use it, from the mirror that apt has here, and in it a clone of the last commit. The result goes into bare_record.md.
# Needs root, debootstrap and the network. SPDX-License-Identifier: Apache-2.0
# usage: bare.sh SOURCE FOLDER demo|test
set -eu
here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
source=$(CDPATH='' cd -- "$1" && pwd)
mkdir -p "$2"
folder=$(CDPATH='' cd -- "$2" && pwd)
command=$3
machine=$folder/machine base=$folder/debian-12.tar log=$folder/$command.log
user=visitor
say() { printf 'bare: %s\n' "$*" >&2; }
quiet() { "$@" >"$folder/log" 2>&1 </dev/null || { tail -n 40 "$folder/log" >&2; say "this failed: $*"; exit 1; }; }

# What is mounted in the machine is so in a mount namespace of its own, which ends with its last process, and
# --kill-child ends that with this script: a folder without mounts is left, however the run ends.
clear_machine() {
  ! grep -q " $machine" /proc/mounts || { say "something is mounted below $machine"; exit 1; }
  rm -rf --one-file-system "$machine"
}

# Becomes a command that runs as root in the machine, which is the root of the command's own mounts and processes.
# It reads no terminal: what asks something would wait.
# shellcheck disable=SC2016 # the text is for the shell inside
become() {
  mkdir -p "$folder/archives/partial"
  exec unshare --mount --pid --fork --kill-child --propagation private sh -eu -c '
    machine=$1 archives=$2
    shift 2
    mount --bind "$machine" "$machine"
    mount -t proc proc "$machine/proc"
    mount -t sysfs -o ro sysfs "$machine/sys"
    mount --rbind /dev "$machine/dev"
    mount -t tmpfs -o mode=1777 shm "$machine/dev/shm"
    mount --bind "$archives" "$machine/var/cache/apt/archives"
    cd "$machine"
    mkdir -p .before
    pivot_root . .before
    exec chroot . env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root TERM=dumb DEBIAN_FRONTEND=noninteractive \
      sh -eu -c "umount -l /.before; rmdir /.before; exec \"\$@\"" sh "$@"
  ' sh "$machine" "$folder/archives" "$@" </dev/null
}
# shellcheck disable=SC2317 # quiet calls it
inside() { (become "$@"); }

# Where apt has a suite of Debian from here.
mirror_of() {
  # shellcheck disable=SC2016 # names of apt
  found=$(apt-get indextargets --format '$(RELEASE) $(REPO_URI)' 'Created-By: Packages' 2>/dev/null |
    sed -n "s/^$1 //p" | head -n 1)
  printf '%s' "${found:-$2}"
}

# The machine as it is before anybody has done anything in it, which is kept for a month.
make_base() {
  mirror=$(mirror_of bookworm http://deb.debian.org/debian)
  security=$(mirror_of bookworm-security http://deb.debian.org/debian-security)
  say "a bare Debian 12 from $mirror"
  quiet debootstrap --variant=minbase --include=git,sudo bookworm "$machine" "$mirror"
  for suite in "$mirror bookworm" "$mirror bookworm-updates" "$security bookworm-security"; do
    printf 'deb %s main\n' "$suite"
  done >"$machine/etc/apt/sources.list"

  # the way to the network is that of this machine
  cp -L /etc/resolv.conf "$machine/etc/resolv.conf"
  printf '127.0.0.1 localhost %s\n' "$(hostname)" >"$machine/etc/hosts"
  apt-config dump | grep -iE '^Acquire::[a-z:]*proxy ' >"$machine/etc/apt/apt.conf.d/90proxy" || true
  quiet inside sh -c 'apt-get update && apt-get -y dist-upgrade'
  quiet chroot "$machine" useradd --create-home --shell /bin/bash "$user"
  printf '%s ALL=(ALL) NOPASSWD: ALL\n' "$user" >"$machine/etc/sudoers.d/$user"
  chmod 440 "$machine/etc/sudoers.d/$user"
  tar -c --one-file-system -C "$machine" -f "$base.part" .
  mv "$base.part" "$base"
}

# Processor time of all that has ended by now [s], in $spent: a subshell would tell its own.
take_time() {
  times >"$folder/.times"
  spent=$(tail -n 1 "$folder/.times" | tr 'ms' '  ' | awk '{ printf "%d\n", 60 * ($1 + $3) + $2 + $4 }')
}

case $command in
demo | test) ;;
*) say "demo or test, not '$command'" && exit 2 ;;
esac
[ "$(id -u)" -eq 0 ] || { say "a machine is made by root; this is $(id -un)"; exit 1; }
running=
# Ends what runs in the machine and takes it away.
# shellcheck disable=SC2317 # the trap calls it
stop() {
  say "stopped"
  [ -z "$running" ] || { kill -KILL "$running" && wait "$running"; } 2>/dev/null || true
  clear_machine || { sleep 1 && clear_machine; }
  exit 130
}
trap stop INT TERM HUP
clear_machine
mkdir -p "$machine"
if [ -n "$(find "$base" -mtime -30 2>/dev/null)" ]; then
  tar -x -C "$machine" -f "$base"
else
  make_base
fi

# a clone of what is committed, of the user's own, and nothing else
[ -z "$(git -C "$source" status --porcelain)" ] || say "changes that are not committed are left out"
commit=$(git -C "$source" rev-parse HEAD)
home=$machine/home/$user
quiet git clone --no-local "$source" "$home/thrum"
quiet chroot "$machine" chown -R "$user:" "/home/$user/thrum"
certificates=
if [ -f "${NODE_EXTRA_CA_CERTS:-}" ]; then
  # node and npm trust here what they trust outside
  cp "$NODE_EXTRA_CA_CERTS" "$machine/etc/certificates.pem"
  certificates=NODE_EXTRA_CA_CERTS=/etc/certificates.pem
fi

say "./run $command of $commit; what it says is in $log"
take_time
before=$spent
code=0
# shellcheck disable=SC2086 # no word where there is none
become runuser -u "$user" -- env -i HOME="/home/$user" USER="$user" PATH=/usr/local/bin:/usr/bin:/bin:/usr/games TERM=dumb \
  $certificates bash -c "cd && cd thrum && ${THRUM_RUN_WITH:-} ./run $command" >"$log" 2>&1 &
running=$!
# a shell hears of signals while it waits, and not while a command of its own runs
tail -n +1 -f --pid="$running" "$log" &
wait "$running" || code=$?
running=
wait
take_time

# the last line of the tests, or how the demo ended
result="exit code $code"
case $command in
test) result=$(grep -E '^[0-9]+ passed, [0-9]+ failed$' "$log" | tail -n 1) || result="exit code $code" ;;
demo) [ "$code" != 0 ] || result="done" ;;
esac
version() { chroot "$machine" env -i PATH=/usr/bin:/bin "$@" 2>/dev/null | head -n 1 || true; }
gcc=$(version gcc -dumpfullversion) cmake=$(version cmake --version) node=$(version node --version)
"$here/bare_record.sh" write "$source/packaging/bare_record.md" "$command" "$result" "$commit" \
  "$(cat "$machine/etc/debian_version")" "${gcc:-none}" "${cmake##* }" "${node:-none}" \
  "$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo | head -n 1), $(nproc) of them" "$((spent - before)) s"
if [ "$code" = 0 ]; then
  clear_machine
else
  say "the machine is left in $machine"
fi
exit "$code"
