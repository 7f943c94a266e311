#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# mavlink_peers.sh KESTREL FLY: serves a flight as PX4 and as ArduPilot, and by node-mavlink talks with each as ground stations do on
# connecting (station.mjs), and reads what the program for real aircraft tells each of what its camera sees (sightings.mjs). Nothing is
# downloaded: `npm install` in this folder, once and by hand, brings it. Exit status 77, skipped: it is not there.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
if ! command -v node > /dev/null || [ ! -d "$here/node_modules/node-mavlink" ]; then
  echo "skipped: no codec of MAVLink by others; to have it: npm install in tests/peers/mavlink, with Node.js 20"
  exit 77
fi
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
for dialect in px4 ardupilot; do
  node "$here/station.mjs" "$1" "$dialect" "$out/$dialect"
  node "$here/sightings.mjs" "$1" "$2" "$dialect" "$out/sightings-$dialect"
done
