// SPDX-License-Identifier: Apache-2.0
// sightings.mjs KESTREL FLY DIALECT FOLDER: lands a served aircraft by the program for real ones, with a relay between them that reads by
// node-mavlink what goes up. What the camera saw must be told as the truth of the flight was: place, signs, heading, and a covariance that
// is one and in MAVLink's order. Exit status 1: something is otherwise, with what.
import {spawn} from "node:child_process";
import {createSocket} from "node:dgram";
import {readFile} from "node:fs/promises";
import {PassThrough} from "node:stream";
import {createInterface} from "node:readline";
import {common, development, minimal, standard} from "mavlink-mappings";
import {MavLinkPacketParser, MavLinkPacketSplitter} from "node-mavlink";

const [kestrel, fly, dialect, folder] = process.argv.slice(2);
const px4 = dialect === "px4", camera = px4 ? 5712 : 5722;
const registry = {...minimal.REGISTRY, ...standard.REGISTRY, ...common.REGISTRY, ...development.REGISTRY};
const mistakes = [];
const hold = (is, what) => { if (!is) mistakes.push(what); };

const server = spawn(kestrel, ["serve", "landing", "--mavlink", dialect, "--mavlink-port", "0", "--camera", `rtp:${camera}`, "--for", "120",
  "--set", "start.height_m=3", "--out", `${folder}/served`], {stdio: ["ignore", "pipe", "ignore"]});
const served = new Promise((done) => server.on("exit", done));
const port = await new Promise((found, missing) => {
  const lines = createInterface({input: server.stdout});
  lines.on("line", (line) => {
    const told = line.match(/mavlink:udp:\/\/127\.0\.0\.1:(\d+)/);
    if (told) found(Number(told[1]));
  });
  lines.on("close", () => missing(new Error("it has told no address")));
});

const below = createSocket("udp4"), above = createSocket("udp4"), bytes = new PassThrough(), heard = [];
let client;
below.on("message", (datagram, from) => {
  client = from;
  bytes.write(datagram);
  above.send(datagram, port, "127.0.0.1");
});
above.on("message", (datagram) => { if (client) below.send(datagram, client.port, client.address); });
bytes.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser()).on("data", (packet) => {
  const type = registry[packet.header.msgid];
  if (type) heard.push({name: type.MSG_NAME, value: packet.protocol.data(packet.payload, type)});
});
await new Promise((done) => below.bind(0, "127.0.0.1", done));

const aircraft = [`mavlink.landing_target=${px4 ? "target_relative" : "landing_target"}`,
  `mavlink.vision_position=${px4 ? "odometry" : "vision_position_estimate"}`];
const flown = spawn(fly, ["fly", "landing", "--camera", `rtp://127.0.0.1:${camera}`, "--autopilot",
  `mavlink:udp://127.0.0.1:${below.address().port}`, "--take-control", "--no-video", "--for", "90", "--out", `${folder}/flown`,
  ...aircraft.flatMap((each) => ["--set-aircraft", each])], {stdio: ["ignore", "inherit", "inherit"]});
await new Promise((done) => flown.on("exit", done));
server.kill("SIGINT");
await served;
below.close();
above.close();

// The aircraft in the pad's frame by the truth, in which the pad of this scenario lies as N does.
const table = (await readFile(`${folder}/served/telemetry.csv`, "utf8")).trimEnd().split("\n").map((line) => line.split(","));
const column = (name) => table[0].indexOf(name);
const truth = table.slice(1).map((row) => ["truth_x_m", "truth_y_m", "truth_z_m"].map((name) => Number(row[column(name)])));
const of = (name) => heard.filter((one) => one.name === name).map(({value}) => value);
const poses = of(px4 ? "ODOMETRY" : "VISION_POSITION_ESTIMATE"), targets = of(px4 ? "TARGET_RELATIVE" : "LANDING_TARGET");
hold(poses.length > 50, `${poses.length} poses came`);
hold(targets.length === poses.length, `${targets.length} targets came`);

// The truth at the height that is told, on the way down, nearest in place.
const distance = (p) => Math.min(...truth.filter((t) => Math.abs(t[2] - p[2]) < 0.1).map((t) => Math.hypot(t[0] - p[0], t[1] - p[1])));
let worst = 0, known = 0;
for (const pose of poses) {
  const covariance = pose.poseCovariance ?? pose.covariance;
  const away = distance([pose.x, pose.y, pose.z]);
  if (Number.isFinite(away)) worst = Math.max(worst, away);
  if (Number.isNaN(covariance[0])) {  // unknown: it is about to touch down
    hold(pose.z > -0.5, `no covariance at ${pose.z} m`);
    continue;
  }
  ++known;
  const sigma = [0, 6, 11, 15, 18, 20].map((at) => Math.sqrt(covariance[at]));
  hold(sigma.every((s) => s > 0 && s < 1), `deviations ${sigma}`);
  // Across the axis of a camera that looks down a place is confused with a tilt: more is known of height and heading.
  hold(sigma[2] < sigma[0] && sigma[2] < sigma[1] && sigma[5] < sigma[3] && sigma[5] < sigma[4], `the order of ${sigma}`);
}
hold(known > 0.5 * poses.length, `of ${poses.length} poses ${known} have a covariance`);
hold(worst < 0.25, `a place is off by ${worst} m`);
const times = poses.map((pose) => Number(pose.timeUsec ?? pose.usec));
hold(times.every((time, i) => i === 0 || time > times[i - 1]), "a time goes back");
for (const [i, target] of targets.entries()) {
  const range = Math.hypot(target.x, target.y, target.z), pose = poses[i];
  hold(Math.abs(range - Math.hypot(pose.x, pose.y, pose.z)) < 0.01, `the pad is ${range} m away`);
  hold(target.z > 0, "the pad is above");
  if (px4) hold(target.posStd.every((s) => Number.isNaN(s) || (s > 0 && s < 1)) && target.frame === 2, `TARGET_RELATIVE of frame ${target.frame}, ${target.posStd}`);
  else hold(target.frame === 12 && target.positionValid === 1, `LANDING_TARGET of frame ${target.frame}`);
}
if (px4) hold(poses.every((p) => p.frameId === 20 && p.childFrameId === 12 && Number.isNaN(p.vx)), "ODOMETRY is in other frames");
console.log(`${dialect}: ${poses.length} poses, at most ${worst.toFixed(3)} m beside the truth; ${targets.length} targets`);
for (const mistake of [...new Set(mistakes)].slice(0, 20)) console.error(mistake);
if (mistakes.length) console.error(`${mistakes.length} mistakes`);
process.exit(mistakes.length ? 1 : 0);
