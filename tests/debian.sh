#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Tries Kestrel on a Debian that debootstrap makes and that has nothing else:
#   tests/debian.sh RELEASE clone [COMMANDS]   a clone of this checkout, and in it COMMANDS of the shell; without
#                                              them, those that README.md starts with. What has not been committed
#                                              is not in the clone.
#   tests/debian.sh RELEASE package FILE       the Debian package FILE, which `cpack -G DEB` made: installs it, lands
#                                              with it, and tells the time that both took
# RELEASE: bookworm or trixie. Needs to be root, debootstrap, the network, and some 6 GB in TMPDIR.
# Exit status: that of the commands.
set -euo pipefail

usage() {
  sed -n '/^#   /,/^# Exit/s/^# //p' "$0" >&2
  exit 2
}
release=${1-} what=${2-}
checkout=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
case $what in
  clone) commands=${3:-./kestrel run landing && ./kestrel test} ;;
  package)
    [[ -f ${3-} ]] || usage
    commands='
      begun=$SECONDS
      apt-get install -y ./kestrel_*.deb
      echo "installed after $((SECONDS - begun)) s"
      kestrel run landing
      echo "landed after $((SECONDS - begun)) s"
      ! command -v c++ gcc clang || { echo "FAILED: there is a compiler" >&2; exit 1; }'
    ;;
  *) usage ;;
esac

# Mounts, and the processes of the commands, end with `unshare`, however it ends.
root=$(mktemp -d --tmpdir "kestrel-$release.XXXXXX")
trap 'rm -rf --one-file-system "$root"' EXIT
chmod 755 "$root"  # or no other user of that Debian could run anything
unshare --mount debootstrap --variant=minbase "$release" "$root" http://deb.debian.org/debian
cp /etc/resolv.conf /etc/hosts "$root/etc/"
case $what in
  clone) git clone --quiet "$checkout" "$root/root/kestrel" ;;
  package) install -D "$3" -t "$root/root/kestrel" ;;
esac

# Pseudoterminals are serial ports of the tests.
unshare --mount --pid --fork --root="$root" --mount-proc \
  env --ignore-environment HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin DEBIAN_FRONTEND=noninteractive \
  bash -euc "
    mount -t devpts -o ptmxmode=666 devpts /dev/pts
    ln -sf pts/ptmx /dev/ptmx
    apt-get update
    cd /root/kestrel
    $commands"
