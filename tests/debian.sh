#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs commands in a clone of this checkout on a Debian that debootstrap makes and that has nothing else:
#   tests/debian.sh RELEASE [COMMANDS]
# RELEASE: bookworm or trixie. COMMANDS: of the shell; without them, those that README.md starts with. What has not
# been committed is not in the clone. Needs to be root, debootstrap, the network, and some 6 GB in TMPDIR.
# Exit status: that of the commands.
set -euo pipefail

release=${1:?RELEASE, such as bookworm or trixie}
commands=${2:-./kestrel run landing && ./kestrel test}
checkout=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")

# Mounts, and the processes of the commands, end with `unshare`, however it ends.
root=$(mktemp -d --tmpdir "kestrel-$release.XXXXXX")
trap 'rm -rf --one-file-system "$root"' EXIT
unshare --mount debootstrap --variant=minbase "$release" "$root" http://deb.debian.org/debian
cp /etc/resolv.conf /etc/hosts "$root/etc/"
git clone --quiet "$checkout" "$root/root/kestrel"

# Pseudoterminals are serial ports of the tests.
unshare --mount --pid --fork --root="$root" --mount-proc \
  env --ignore-environment HOME=/root LANG=C.UTF-8 PATH=/usr/sbin:/usr/bin:/sbin:/bin bash -euc "
    mount -t devpts -o ptmxmode=666 devpts /dev/pts
    ln -sf pts/ptmx /dev/ptmx
    cd /root/kestrel
    $commands"
