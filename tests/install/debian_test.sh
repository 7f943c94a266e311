#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A fresh Debian installs the package and lands, without a compiler. Needs root, the network, debootstrap and some
# 3 GB; ctest does not run it.
#   tests/install/debian_test.sh [BUILD [SUITE [MIRROR]]]
set -euo pipefail
build=$(readlink -f "${1:-build}") suite=${2:-bookworm} mirror=${3:-http://deb.debian.org/debian}
((EUID == 0)) || { echo "debian_test.sh: only root can make a Debian of its own" >&2; exit 2; }

(cd "$build" && cpack -G DEB)
package=$(ls -t "$build"/kestrel_*.deb | head -1)
root=$(mktemp -d --tmpdir kestrel-debian.XXXX)
trap 'umount -q "$root/proc" || true; rm -rf --one-file-system "$root"' EXIT
debootstrap --variant=minbase "$suite" "$root" "$mirror"
mount -t proc proc "$root/proc"
cp "$package" "$root/tmp/"
chroot "$root" apt-get update

begun=$SECONDS
chroot "$root" env DEBIAN_FRONTEND=noninteractive apt-get install -y "/tmp/$(basename "$package")"
echo "installed after $((SECONDS - begun)) s"
chroot "$root" sh -c 'cd /tmp && kestrel run landing'
echo "landed after $((SECONDS - begun)) s"
! chroot "$root" sh -c 'command -v c++ gcc clang' || { echo "FAILED: there is a compiler" >&2; exit 1; }
