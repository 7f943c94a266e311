// SPDX-License-Identifier: Apache-2.0
// Writes mavlink_vectors.inc: frames as node-mavlink, an implementation by others, encodes given values. It
// also decodes each of them, and breaks off if that does not give the values again: so a frame of ours that is
// the same byte by byte is one that it understands. The tests need the frames only. To write them again:
//   mkdir /tmp/vectors && cp mavlink_vectors.mjs /tmp/vectors && cd /tmp/vectors
//   npm install node-mavlink@2.3.0 mavlink-mappings@1.0.21-20250824-1
//   node mavlink_vectors.mjs > mavlink_vectors.inc
import { minimal, standard, common, development } from 'mavlink-mappings';
import { MavLinkProtocolV1, MavLinkProtocolV2, x25crc } from 'node-mavlink';

const messages = ['Heartbeat', 'SystemTime', 'SetMode', 'Attitude', 'AttitudeQuaternion', 'LocalPositionNed',
  'GlobalPositionInt', 'RcChannels', 'CommandLong', 'CommandAck', 'SetAttitudeTarget', 'SetPositionTargetLocalNed',
  'PositionTargetLocalNed', 'HilActuatorControls', 'VisionPositionEstimate', 'HilSensor', 'TimeSync', 'HilGps',
  'HilStateQuaternion', 'DistanceSensor', 'LandingTarget', 'ExtendedSysState', 'StatusText', 'SysStatus', 'Ping', 'ParamRequestRead', 'ParamRequestList', 'ParamValue', 'ParamSet', 'GpsRawInt', 'MissionRequest', 'MissionSetCurrent', 'MissionCurrent', 'MissionRequestList', 'MissionCount', 'MissionClearAll', 'MissionAck', 'GpsGlobalOrigin', 'MissionRequestInt', 'RequestDataStream', 'VfrHud', 'CommandInt', 'BatteryStatus', 'AutopilotVersion', 'HomePosition', 'MessageInterval', 'Odometry', 'TargetRelative'];
const ours = { TimeSync: 'Timesync', StatusText: 'Statustext' };

let state = 12345n;  // Knuth's generator
const random = () => Number((state = (state * 6364136223846793005n + 1442695040888963407n) & ((1n << 64n) - 1n)) >> 32n);

const bits = { 'uint8_t_mavlink_version': 8, 'uint8_t': 8, 'int8_t': 8, 'uint16_t': 16, 'int16_t': 16, 'uint32_t': 32,
  'int32_t': 32, 'uint64_t': 64, 'int64_t': 64 };
const integer = (type, pick) => {
  const n = BigInt(bits[type]), signed = type[0] === 'i';
  const least = signed ? -(1n << (n - 1n)) : 0n, greatest = (1n << (signed ? n - 1n : n)) - 1n;
  if (pick === 'least') return least;
  if (pick === 'greatest') return greatest;
  const raw = ((BigInt(random()) << 32n) | BigInt(random())) & ((1n << n) - 1n);
  return signed ? raw + least : raw;
};
const float = (pick) => {
  if (pick === 'least') return Math.fround(-3.4028234663852886e38);
  if (pick === 'greatest') return Math.fround(1.401298464324817e-45);
  return Math.fround((random() / 2 ** 32 - 0.5) * 10 ** (random() % 7 - 2));
};
const scalar = (type, pick) => type.startsWith('float') ? float(pick) : integer(type, pick);
const literal = (type, value) => {
  if (type.startsWith('float')) return `${Number.isInteger(value) && Math.abs(value) < 1e21 ? value + '.0' : value}f`;
  if (type === 'int32_t') return value === -(1n << 31n) ? `-2147483647 - 1` : `${value}`;
  if (type === 'int64_t') return value === -(1n << 63n) ? `-9223372036854775807 - 1` : `${value}`;
  return type.startsWith('uint64') || type.startsWith('uint32') ? `${value}U` : `${value}`;
};

const hex = (bytes) => bytes.toString('hex');
const same = (a, b) => Array.isArray(a) ? a.every((each, i) => same(each, b[i])) : a === b;
function decoded(frame, type, message) {
  const protocol = frame[0] === 0xfe ? new MavLinkProtocolV1() : new MavLinkProtocolV2();
  const head = protocol.header(frame);
  if (head.msgid !== type.MSG_ID) throw new Error(`${type.MSG_NAME}: decoded as message ${head.msgid}`);
  const end = protocol.constructor.PAYLOAD_OFFSET + head.payloadLength;
  const sum = x25crc(frame.subarray(0, end + 2), 1, 2, type.MAGIC_NUMBER);
  if (sum !== protocol.crc(frame)) throw new Error(`${type.MSG_NAME}: check sum`);
  const back = protocol.data(protocol.payload(frame), type);
  for (const { name, type: wire } of type.FIELDS) {
    if (!same(message[name], back[name])) throw new Error(`${type.MSG_NAME}.${name} (${wire}): ${message[name]} became ${back[name]}`);
  }
}
const line = (name, fields, frame, header, type, message) => {
  decoded(frame, type, message);
  console.log(`{${ours[name] ?? name}{${fields.join(', ')}},\n "${hex(frame)}", ${header}},`);
};

function fill(type, all, zeros) {
  const message = new type(), fields = [], channels = [];
  for (const field of type.FIELDS) {
    // Of a payload of zeros alone node-mavlink sends nothing, not the first byte as it should.
    const pick = all === 'least' && field === type.FIELDS[0] ? 'greatest' : all;
    const zero = zeros && field.extension;
    const base = field.type.replace('[]', '');
    let text;
    if (base === 'char') {
      const value = zero ? '' : Array.from({ length: pick === 'any' ? Math.min(20, field.length) : field.length },
        () => String.fromCharCode(97 + random() % 26)).join('');
      message[field.name] = value;
      text = `Text<${field.length}>("${value}")`;
    } else if (field.type.endsWith('[]')) {
      const values = Array.from({ length: field.length }, () => zero ? (base === 'float' ? 0 : 0n) : scalar(base, pick));
      message[field.name] = bits[base] && bits[base] < 64 ? values.map(Number) : values;
      text = `{${values.map(v => literal(base, v)).join(', ')}}`;
    } else {
      const value = zero ? (base === 'float' ? 0 : 0n) : scalar(base, pick);
      message[field.name] = base === 'float' || bits[base] === 64 ? value : Number(value);
      text = literal(base, value);
      if (/^chan\d+_raw$/.test(field.source)) {
        channels.push(text);
        if (channels.length < 18) continue;
        fields.push(`.chan_raw = {${channels.join(', ')}}`);
        continue;
      }
    }
    fields.push(`.${field.source} = ${text}`);
  }
  return [message, fields];
}

console.log('// Written by mavlink_vectors.mjs: {values, frame, {version, signed, sequence, system, component}}.');
for (const name of messages) {
  const type = minimal[name] ?? standard[name] ?? common[name] ?? development[name];
  for (const [pick, zeros] of [['any', false], ['any', true], ['least', false], ['greatest', false]]) {
    const [message, fields] = fill(type, pick, zeros);
    const sequence = random() % 256, system = 1 + random() % 255, component = 1 + random() % 255;
    const header = `${sequence}, ${system}, ${component}`;
    line(name, fields, new MavLinkProtocolV2(system, component).serialize(message, sequence), `{2, false, ${header}}`, type, message);
    if (pick !== 'any' || zeros) continue;
    const signing = new MavLinkProtocolV2(system, component, MavLinkProtocolV2.IFLAG_SIGNED);
    line(name, fields, signing.sign(signing.serialize(message, sequence), 1, Buffer.alloc(32, 7), 1.7e12),
      `{2, true, ${header}}`, type, message);
    if (type.MSG_ID < 256 && type.FIELDS.every(field => !field.extension))  // which node-mavlink would send in version 1 too
      line(name, fields, new MavLinkProtocolV1(system, component).serialize(message, sequence), `{1, false, ${header}}`, type, message);
  }
}
