// SPDX-License-Identifier: Apache-2.0
// Reads flight.mcap of a run by Foxglove's own libraries, by its index and from beginning to end, decodes every message by the
// schema that the file has, and holds what it says against telemetry.csv of the same folder. Exit status 1: something is
// otherwise, with what.
//   npm install && node read.mjs ../../../results/runs/landing-1
import { McapIndexedReader, McapStreamReader } from '@mcap/core';
import { parse } from '@foxglove/rosmsg';
import { MessageReader } from '@foxglove/rosmsg2-serialization';
import { decompress as zstd } from 'fzstd';
import lz4 from 'lz4js';
import { open, readFile } from 'node:fs/promises';

const folder = process.argv[2];
const mistakes = [];
const hold = (is, what) => { if (!is) mistakes.push(what); };
const decompressHandlers = {
  zstd: (bytes, size) => zstd(bytes, new Uint8Array(Number(size))),
  lz4: (bytes) => lz4.decompress(bytes),
};

const decoders = new Map();
const decode = (schema, data) => {
  if (!decoders.has(schema.id)) {
    hold(schema.encoding === 'ros2msg', `${schema.name} is of ${schema.encoding}`);
    decoders.set(schema.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
  }
  return decoders.get(schema.id).readMessage(data);
};

// By the index.
const file = await open(`${folder}/flight.mcap`);
const readable = {
  size: async () => BigInt((await file.stat()).size),
  read: async (offset, size) => {
    const bytes = new Uint8Array(Number(size));
    const { bytesRead } = await file.read(bytes, 0, bytes.length, Number(offset));
    if (bytesRead !== bytes.length) throw new Error(`${bytesRead} of ${bytes.length} bytes at ${offset}`);
    return bytes;
  },
};
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
hold(reader.header.profile === 'ros2', `its profile is '${reader.header.profile}'`);
hold(reader.chunkIndexes.length === reader.statistics.chunkCount, 'the chunks are not those of the statistics');
const topics = new Map();
let last = 0n;
for await (const message of reader.readMessages({ validateCrcs: true })) {
  const channel = reader.channelsById.get(message.channelId);
  hold(message.logTime >= last, `${channel.topic} goes back in time at ${message.logTime}`);
  last = message.logTime;
  const value = decode(reader.schemasById.get(channel.schemaId), message.data);
  if (!topics.has(channel.topic)) topics.set(channel.topic, []);
  topics.get(channel.topic).push({ logTime: message.logTime, publishTime: message.publishTime, value });
}
const count = [...topics.values()].reduce((sum, all) => sum + BigInt(all.length), 0n);
hold(count === reader.statistics.messageCount, `${count} messages, where the statistics have ${reader.statistics.messageCount}`);
for (const [id, channel] of reader.channelsById)
  hold(BigInt(topics.get(channel.topic)?.length ?? 0) === reader.statistics.channelMessageCounts.get(id),
    `${channel.topic} has not as many messages as the statistics say`);

// From beginning to end, with the check sum of each chunk.
const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
stream.append(await readFile(`${folder}/flight.mcap`));
let streamed = 0n;
for (let record; (record = stream.nextRecord());) if (record.type === 'Message') ++streamed;
hold(stream.done(), 'its end is no end');
hold(streamed === count, `${streamed} messages from beginning to end, ${count} by the index`);

// What is beside the messages.
for await (const attachment of reader.readAttachments({ validateCrcs: true }))
  hold(new TextDecoder().decode(attachment.data) === await readFile(`${folder}/${attachment.name}`, 'utf8'),
    `${attachment.name} is another`);
hold(reader.attachmentIndexes.length === 1, 'scenario.yaml is not attached');
const about = {};
for await (const metadata of reader.readMetadata({ name: 'kestrel' })) Object.assign(about, Object.fromEntries(metadata.metadata));
hold(about.seed !== undefined, 'the seed is not told');

// Against the table of the same flight. N is north-east-down, ROS's map east-north-up.
const lines = (await readFile(`${folder}/telemetry.csv`, 'utf8')).trimEnd().split('\n').map((line) => line.split(','));
const columns = new Map(lines[0].map((name, i) => [name, i]));
const rows = lines.slice(1);
const cell = (row, name) => row[columns.get(name)];
const ns = (seconds) => BigInt(Math.round(Number(seconds) * 1e9));
const stampOf = (message) => BigInt(message.header.stamp.sec) * 1000000000n + BigInt(message.header.stamp.nanosec ?? message.header.stamp.nsec);
const near = (a, b, most) => Math.abs(a - Number(b)) <= most;
const at = (topic) => topics.get(topic) ?? [];
for (const [topic, name] of [['/truth', 'truth'], ['/estimate', 'estimate']]) {
  hold(at(topic).length === rows.length, `${topic}: ${at(topic).length} messages of ${rows.length} rows`);
  at(topic).forEach(({ logTime, value }, i) => {
    const row = rows[i], p = value.pose.pose.position, q = value.pose.pose.orientation;
    // The table has microseconds; the log must be within half of one, and is held to the nanosecond elsewhere.
    hold(near(Number(logTime) / 1e9, cell(row, 't_s'), 6e-7), `${topic} ${i}: logged at ${logTime}`);
    hold(near(p.x, cell(row, `${name}_y_m`), 2e-4) && near(p.y, cell(row, `${name}_x_m`), 2e-4) &&
      near(-p.z, cell(row, `${name}_z_m`), 2e-4), `${topic} ${i} is elsewhere`);
    // Forward as ROS's axes have it, against north and east of the heading.
    const forward = [1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.w * q.z)];
    const heading = Math.atan2(forward[0], forward[1]) * 180 / Math.PI;
    const off = ((heading - Number(cell(row, `${name}_yaw_deg`))) % 360 + 540) % 360 - 180;
    hold(Math.abs(off) < 0.02, `${topic} ${i} heads ${heading}, not ${cell(row, `${name}_yaw_deg`)}`);
    if (i > 0) hold(logTime > at(topic)[i - 1].logTime, `${topic} ${i} repeats a time`);
  });
}
const fixes = rows.filter((row) => cell(row, 'fix_x_m') !== '');
hold(at('/fix').length === fixes.length, `/fix: ${at('/fix').length} of ${fixes.length}`);
at('/fix').forEach(({ value }, i) => {
  const p = value.pose.position;
  hold(near(p.x, cell(fixes[i], 'fix_x_m'), 2e-4) && near(-p.y, cell(fixes[i], 'fix_y_m'), 2e-4) &&
    near(-p.z, cell(fixes[i], 'fix_z_m'), 2e-4), `/fix ${i} is elsewhere`);
  hold(near(Number(stampOf(value)) / 1e9, cell(fixes[i], 'exposure_t_s'), 6e-7), `/fix ${i} is of another time`);
});

// Images: as many as frames, each with its calibration and its annotations, all of one stamp.
const compressed = at('/camera/main/image_raw/compressed'), raw = at('/camera/main/image_raw');
const images = compressed.length ? compressed : raw;
const infos = at('/camera/main/camera_info'), drawn = at('/camera/main/annotations');
hold(images.length === rows.length && infos.length === rows.length && drawn.length === rows.length,
  `${images.length} images, ${infos.length} calibrations, ${drawn.length} annotations of ${rows.length} rows`);
images.forEach(({ value }, i) => {
  hold(stampOf(value) === stampOf(infos[i].value), `image ${i} and its calibration are of two times`);
  hold(value.header.frame_id === infos[i].value.header.frame_id, `image ${i} and its calibration are of two frames`);
  hold(near(Number(stampOf(value)) / 1e9, cell(rows[i], 'exposure_t_s'), 6e-7), `image ${i} is of another time`);
  if (raw.length) {
    hold(value.data.length === value.step * value.height && value.width === infos[i].value.width, `image ${i} is of another size`);
  } else {
    hold(value.format === 'jpeg' && value.data[0] === 0xff && value.data[1] === 0xd8 && value.data.at(-1) === 0xd9,
      `image ${i} is no JPEG`);
  }
});

for (const [topic, all] of [...topics].sort())
  console.log(`${topic.padEnd(36)} ${String(all.length).padStart(6)}  ${[...reader.channelsById.values()].filter((c) => c.topic === topic)
    .map((c) => reader.schemasById.get(c.schemaId).name)[0]}`);
console.log(`${count} messages in ${reader.chunkIndexes.length} chunks of ${[...new Set(reader.chunkIndexes.map((c) => c.compression || 'no compression'))]}, ` +
  `by the index and from beginning to end; ${rows.length} rows of telemetry.csv`);
for (const mistake of mistakes.slice(0, 20)) console.error(mistake);
if (mistakes.length) console.error(`${mistakes.length} mistakes`);
process.exit(mistakes.length || rows.length === 0 ? 1 : 0);
