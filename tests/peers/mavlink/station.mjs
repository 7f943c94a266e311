// SPDX-License-Identifier: Apache-2.0
// station.mjs KESTREL DIALECT FOLDER: serves a flight and asks of it what QGroundControl, MAVProxy and MAVSDK ask on connecting, then lands and
// takes off as they do; all by node-mavlink. Each question must be answered, or refused by its acknowledgement. Exit status 1: one was not, or
// the answer is otherwise than an autopilot's, with what.
import {spawn} from "node:child_process";
import {createSocket} from "node:dgram";
import {PassThrough} from "node:stream";
import {createInterface} from "node:readline";
import {ardupilotmega, common, minimal, standard} from "mavlink-mappings";
import {MavLinkPacketParser, MavLinkPacketSplitter, MavLinkProtocolV2} from "node-mavlink";

const [kestrel, dialect, folder] = process.argv.slice(2);
const px4 = dialect === "px4";
const registry = {...minimal.REGISTRY, ...standard.REGISTRY, ...common.REGISTRY, ...ardupilotmega.REGISTRY};
const mistakes = [];
const hold = (is, what) => { if (!is) mistakes.push(what); };

const flight = spawn(kestrel, ["serve", "hover", "--mavlink", dialect, "--mavlink-port", "0", "--for", "170", "--out", folder],
  {stdio: ["ignore", "pipe", "ignore"]});
const ended = new Promise((done) => flight.on("exit", done));
const port = await new Promise((found, missing) => {
  const lines = createInterface({input: flight.stdout});
  lines.on("line", (line) => {
    const told = line.match(/udp:\/\/127\.0\.0\.1:(\d+)/);
    if (told) found(Number(told[1]));
  });
  lines.on("close", () => missing(new Error("it has told no address")));
});

const socket = createSocket("udp4"), bytes = new PassThrough();
const heard = [], waiting = new Set();
socket.on("message", (datagram) => bytes.write(datagram));
bytes.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser()).on("data", (packet) => {
  const type = registry[packet.header.msgid];
  if (!type) return void mistakes.push(`message ${packet.header.msgid} is of no dialect`);
  const entry = {name: type.MSG_NAME, value: packet.protocol.data(packet.payload, type)};
  heard.push(entry);
  for (const one of waiting) if (one.is(entry)) one.done(entry.value);
});
const us = new MavLinkProtocolV2(255, 190);
let sequence = 0;
const say = (type, fields) => {
  const message = Object.assign(new type(), fields);
  for (const each of ["targetSystem", "targetComponent"])
    if (fields[each] === undefined && each in message) message[each] = 1;
  socket.send(us.serialize(message, sequence++ % 256), port, "127.0.0.1");
};
const wait = (what, is, seconds = 3) => new Promise((done) => {
  const one = {is: (entry) => is(entry), done: (value) => { clearTimeout(late); waiting.delete(one); done(value); }};
  const late = setTimeout(() => { waiting.delete(one); mistakes.push(`no answer: ${what}`); done(undefined); }, 1000 * seconds);
  waiting.add(one);
});
const answer = (name, also = () => true) => (entry) => entry.name === name && also(entry.value);
const command = async (number, params = {}, type = common.CommandLong) => {
  const result = wait(`command ${number} ${JSON.stringify(params)}`, answer("COMMAND_ACK", (ack) => ack.command === number));
  say(type, {command: number, confirmation: 0, ...params});
  const ack = await result;
  if (ack) hold(ack.targetSystem === 255 && ack.targetComponent === 190, `the acknowledgement of ${number} is to ${ack.targetSystem}`);
  return ack?.result;
};
const asks = async (what, name, also, type, fields) => {
  const found = wait(what, answer(name, also));
  say(type, fields);
  return found;
};
const once = async (id, name) => {
  const found = wait(`${name} once`, answer(name));
  hold(await command(512, {_param1: id}) === 0, `${name} is refused`);
  return found;
};
// As pymavlink names a mode of PX4 by its heartbeat.
const px4Mode = ({baseMode, customMode}) => {
  const main = customMode >> 16 & 255, sub = customMode >> 24 & 255;
  if (baseMode & 64) return ["", "MANUAL", "ALTCTL", "POSCTL", "", "ACRO", "", "STABILIZED"][main] || "UNKNOWN";
  if ((baseMode & 28) !== 28) return "UNKNOWN";
  if (main === 6) return "OFFBOARD";
  return main === 4 ? ["", "READY", "TAKEOFF", "LOITER", "MISSION", "RTL", "LAND"][sub] || "UNKNOWN" : "UNKNOWN";
};
const modeName = (heartbeat) => px4 ? px4Mode(heartbeat)
  : {0: "STABILIZE", 4: "GUIDED", 5: "LOITER", 6: "RTL", 9: "LAND", 17: "BRAKE"}[heartbeat.customMode] ?? "UNKNOWN";

say(minimal.Heartbeat, {type: 6, autopilot: 8, baseMode: 0, customMode: 0, systemStatus: 4, mavlinkVersion: 3});
const beat = setInterval(() => say(minimal.Heartbeat, {type: 6, autopilot: 8, baseMode: 0, customMode: 0, systemStatus: 4, mavlinkVersion: 3}), 1000);
const first = await wait("HEARTBEAT", answer("HEARTBEAT"), 20);
hold(first.autopilot === (px4 ? 12 : 3), `the autopilot is ${first.autopilot}`);
hold(modeName(first) === "LOITER", `the mode is ${modeName(first)}`);

// QGroundControl: version, protocol, parameters, mission, fence, rally points, home.
const version = await once(148, "AUTOPILOT_VERSION");
hold(version.flightSwVersion >>> 24 === (px4 ? 1 : 4), `the version is ${version.flightSwVersion}`);
hold(Number(version.capabilities) & 8192, "it cannot speak MAVLink 2");
for (const id of [300, 395, 397, 435, 259]) hold(await command(512, {_param1: id}) === 3, `message ${id} is not refused as unsupported`);
hold(await command(519, {_param1: 1}) === 3, "the protocol version is not refused as unsupported");
const before = heard.length;
const list = await asks("PARAM_REQUEST_LIST", "PARAM_VALUE", (p) => p.paramIndex === p.paramCount - 1, common.ParamRequestList, {});
const values = heard.slice(before).filter(({name}) => name === "PARAM_VALUE").map(({value}) => value);
hold(list && new Set(values.map((p) => p.paramIndex)).size === list.paramCount, `of ${list?.paramCount} parameters came ${values.length}`);
for (const p of values) {
  const again = await asks(`PARAM_REQUEST_READ ${p.paramId}`, "PARAM_VALUE", (q) => q.paramId === p.paramId, common.ParamRequestRead,
    {paramId: p.paramId, paramIndex: -1});
  hold(again?.paramValue === p.paramValue, `${p.paramId} is ${p.paramValue} and ${again?.paramValue}`);
}
const timeout = px4 ? "COM_OF_LOSS_T" : "GUID_TIMEOUT";
const set = await asks("PARAM_SET", "PARAM_VALUE", (q) => q.paramId === timeout, common.ParamSet,
  {paramId: timeout, paramValue: 2.5, paramType: 9});
hold(set?.paramValue === 2.5, `${timeout} is ${set?.paramValue} after it was set`);
for (const missionType of [0, 1, 2]) {
  const count = await asks("MISSION_REQUEST_LIST", "MISSION_COUNT", (m) => m.missionType === missionType, common.MissionRequestList, {missionType});
  hold(count?.count === 0, `there are ${count?.count} items`);
  const refused = await asks("MISSION_COUNT", "MISSION_ACK", (m) => m.missionType === missionType, common.MissionCount, {count: 3, missionType});
  hold(refused?.type === 3, `a mission is answered with ${refused?.type}`);
}
const home = await once(242, "HOME_POSITION");
hold(Math.abs(home.latitude - 404168000) < 100 && home.altitude === 657000, `home is ${home.latitude}, ${home.altitude}`);

// MAVProxy: streams, version and home by the older commands, the line.
for (const reqStreamId of [0, 1, 2, 3, 6, 10, 11, 12])
  say(common.RequestDataStream, {reqStreamId, reqMessageRate: 4, startStop: 1});
for (const name of ["SYS_STATUS", "GPS_RAW_INT", "ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "VFR_HUD", "RC_CHANNELS", "SYSTEM_TIME",
  "BATTERY_STATUS", "MISSION_CURRENT"]) await wait(`stream of ${name}`, answer(name));
hold(await command(520, {_param1: 1}) === 0, "REQUEST_AUTOPILOT_CAPABILITIES is refused");
hold(await command(410) === 0, "GET_HOME_POSITION is refused");
const ping = await asks("PING", "PING", (p) => p.seq === 7, common.Ping, {seq: 7, timeUsec: 5n, targetSystem: 0, targetComponent: 0});
hold(ping?.targetSystem === 255, "PING is answered to another");
await asks("TIMESYNC", "TIMESYNC", (t) => t.ts1 === 11n, common.TimeSync, {tc1: 0n, ts1: 11n});

// MAVSDK: intervals.
for (const [id, name] of [[1, "SYS_STATUS"], [24, "GPS_RAW_INT"], [33, "GLOBAL_POSITION_INT"], [147, "BATTERY_STATUS"], [242, "HOME_POSITION"],
  [245, "EXTENDED_SYS_STATE"]]) {
  hold(await command(511, {_param1: id, _param2: 200000}) === 0, `the interval of ${name} is refused`);
  await wait(`${name} at its interval`, answer(name));
}
hold(await command(31010) === 3, "a command that nobody has is not refused as unsupported");
hold(await command(300) === 2, "a mission that is not there begins");

// Down, and up again as each asks for it.
const until = (what, is, seconds) => wait(what, (entry) => entry.name === "HEARTBEAT" && is(entry.value), seconds);
hold(await command(21) === 0, "NAV_LAND is refused");
await until("the mode LAND", (h) => modeName(h) === "LAND", 5);
await until("disarmed on the ground", (h) => !(h.baseMode & 128), 60);
if (px4) {
  hold(await command(22, {_param7: 657 + 4, _param4: NaN, _param5: NaN, _param6: NaN}) === 0, "NAV_TAKEOFF is refused");
  hold(await command(400, {_param1: 1}) === 0, "it does not arm");
  await until("the mode TAKEOFF", (h) => modeName(h) === "TAKEOFF", 5);
} else {
  hold(await command(176, {_param1: 1, _param2: 4}) === 0, "GUIDED is refused");
  hold(await command(400, {_param1: 1}) === 0, "it does not arm");
  hold(await command(22, {frame: 3, _param7: 4}, common.CommandInt) === 0, "NAV_TAKEOFF is refused");
}
await wait("3.5 m above home", answer("GLOBAL_POSITION_INT", (g) => g.relativeAlt > 3500), 30);
hold(await command(20) === 0, "NAV_RETURN_TO_LAUNCH is refused");
await until("the mode RTL", (h) => modeName(h) === "RTL", 5);
const names = new Set(heard.filter(({name}) => name === "HEARTBEAT").map(({value}) => modeName(value)));
hold(!names.has("UNKNOWN"), `modes: ${[...names]}`);

clearInterval(beat);
socket.close();
flight.kill("SIGINT");
const status = await ended;
hold(status === 0 || status === 1, `the flight ended with ${status}`);
console.log(`${dialect}: ${heard.length} messages of ${new Set(heard.map(({name}) => name)).size} kinds; modes ${[...names].join(", ")}`);
for (const mistake of mistakes.slice(0, 20)) console.error(mistake);
if (mistakes.length) console.error(`${mistakes.length} mistakes`);
process.exit(mistakes.length ? 1 : 0);
