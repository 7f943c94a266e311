// SPDX-License-Identifier: Apache-2.0
// watch.mjs KESTREL FOLDER: flies the beginning of a landing into the folder, and watches it by Foxglove's own client, as its older and
// its newer application and its tools do. Every channel must have a schema that Foxglove reads, every message be what telemetry.csv says.
// Exit status 1: something is otherwise, with what.
import {spawn} from "node:child_process";
import {readFile} from "node:fs/promises";
import {createInterface} from "node:readline";
import protocol from "@foxglove/ws-protocol";
import {parse} from "@foxglove/rosmsg";
import {MessageReader} from "@foxglove/rosmsg2-serialization";
import {WebSocket} from "ws";

const {FoxgloveClient} = protocol;
const [kestrel, folder] = process.argv.slice(2);
const seconds = 3;
const mistakes = [];
const hold = (is, what) => { if (!is) mistakes.push(what); };

const flight = spawn(kestrel, ["run", "landing", "--set", `duration_s=${seconds}`, "--no-video", "--quiet", "--live", "0", "--out", folder],
  {stdio: ["ignore", "pipe", "ignore"]});
const ended = new Promise((done) => flight.on("exit", done));
const lines = createInterface({input: flight.stdout});
const address = await new Promise((found, missing) => {
  lines.on("line", (line) => {
    const told = line.match(/http:\/\/([^/]+)\//);
    if (told) found(told[1]);
  });
  lines.on("close", () => missing(new Error("it has told no address")));
});

// Until the time of the flight no longer goes on.
const watch = (name, protocols, options = {}) => new Promise((done, failed) => {
  const seen = {name, channels: new Map(), topics: new Map(), times: [], problems: []};
  const socket = new WebSocket(`ws://${address}`, protocols, options);
  const client = new FoxgloveClient({ws: socket});
  const readers = new Map();
  let quiet;
  const goesOn = () => {
    clearTimeout(quiet);
    quiet = setTimeout(() => {
      client.close();
      done(seen);
    }, 2500);
  };
  goesOn();
  client.on("error", failed);
  client.on("status", ({message}) => seen.problems.push(message));
  client.on("serverInfo", (info) => { seen.info = info; });
  client.on("advertise", (channels) => {
    for (const channel of channels) {
      seen.channels.set(channel.id, channel);
      const reader = new MessageReader(parse(channel.schema, {ros2: true}));
      readers.set(client.subscribe(channel.id), {channel, reader});
    }
  });
  client.on("time", ({timestamp}) => {
    seen.times.push(timestamp);
    goesOn();
  });
  client.on("message", ({subscriptionId, timestamp, data}) => {
    const {channel, reader} = readers.get(subscriptionId);
    if (!seen.topics.has(channel.topic)) seen.topics.set(channel.topic, []);
    seen.topics.get(channel.topic).push({timestamp, value: reader.readMessage(data)});
  });
  client.on("open", () => { seen.protocol = socket.protocol; });
});
const watchers = await Promise.all([
  watch("ws-protocol", [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
  watch("the application", ["foxglove.sdk.v1", "foxglove.websocket.v1"], {origin: "file://"}),
]);
const status = await ended;
hold(status === 0 || status === 1, `the flight ended with ${status}`);  // 1: it does not land in that time

const table = (await readFile(`${folder}/telemetry.csv`, "utf8")).trimEnd().split("\n").map((line) => line.split(","));
const rowOf = new Map();  // by ns, rounded to the table's microseconds
const cell = (row, name) => Number(row[table[0].indexOf(name)]);
const keyOf = (timestamp) => Math.round(Number(timestamp) / 1000);
for (const row of table.slice(1)) rowOf.set(Math.round(cell(row, "t_s") * 1e6), row);
const rowAt = (timestamp) => [0, 1, -1].map((off) => rowOf.get(keyOf(timestamp) + off)).find(Boolean);
const near = (a, b, most = 2e-4) => Math.abs(a - b) <= most;

hold(watchers[0].protocol === "foxglove.websocket.v1", `spoken was ${watchers[0].protocol}`);
hold(watchers[1].protocol === "foxglove.sdk.v1", `spoken was ${watchers[1].protocol}`);
for (const {name, info, channels, topics, times, problems} of watchers) {
  hold(info?.capabilities.includes("time"), `${name}: the server is ${JSON.stringify(info)}`);
  hold(problems.length === 0, `${name}: ${problems[0]}`);
  for (const {topic, encoding, schemaEncoding} of channels.values())
    hold(encoding === "cdr" && schemaEncoding === "ros2msg", `${name}: ${topic} is ${encoding} by ${schemaEncoding}`);
  const topicNames = [...channels.values()].map(({topic}) => topic);
  for (const topic of ["/truth", "/estimate", "/fix", "/tf", "/camera/main/camera_info", "/camera/main/image_raw/compressed"])
    hold(topicNames.includes(topic) && topics.get(topic)?.length, `${name}: nothing of ${topic}`);
  hold(times.every((time, i) => i === 0 || time > times[i - 1]), `${name}: time goes back`);
  for (const [topic, of] of [["/truth", "truth"], ["/estimate", "estimate"]]) {
    const all = topics.get(topic) ?? [];
    hold(all.length > 0.5 * table.length, `${name}: ${all.length} of ${topic} in ${table.length - 1} rows`);
    for (const {timestamp, value} of all) {
      const row = rowAt(timestamp), p = value.pose.pose.position;  // of ROS: east, north, up
      hold(row && near(p.x, cell(row, `${of}_y_m`)) && near(p.y, cell(row, `${of}_x_m`)) && near(-p.z, cell(row, `${of}_z_m`)),
        `${name}: ${topic} at ${timestamp} ns is ${JSON.stringify(p)}`);
    }
  }
  for (const {timestamp, value} of topics.get("/fix") ?? []) {
    const row = rowAt(timestamp), p = value.pose.position;
    hold(row && near(p.x, cell(row, "fix_x_m")) && near(-p.y, cell(row, "fix_y_m")) && near(-p.z, cell(row, "fix_z_m")),
      `${name}: /fix at ${timestamp} ns is ${JSON.stringify(p)}`);
  }
  const images = topics.get("/camera/main/image_raw/compressed") ?? [];
  for (const {value} of images) hold(value.format === "jpeg" && value.data[0] === 0xff && value.data.at(-1) === 0xd9, `${name}: an image is no JPEG`);
  console.log(`${name}: ${channels.size} channels; of ${table.length - 1} rows ${[...topics].map(([topic, all]) => `${topic} ${all.length}`).sort().join(", ")}`);
}
for (const mistake of mistakes.slice(0, 20)) console.error(mistake);
if (mistakes.length) console.error(`${mistakes.length} mistakes`);
process.exit(mistakes.length ? 1 : 0);
