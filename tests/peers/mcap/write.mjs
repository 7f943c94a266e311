// SPDX-License-Identifier: Apache-2.0
// Writes a log anew by Foxglove's own libraries: every message decoded and encoded by them, in a file of another layout. What
// then reads it reads what others write.
//   node write.mjs FROM.mcap TO.mcap chunks|plain
import { McapStreamReader, McapWriter } from '@mcap/core';
import { parse } from '@foxglove/rosmsg';
import { MessageReader, MessageWriter } from '@foxglove/rosmsg2-serialization';
import { decompress as zstd } from 'fzstd';
import { open, readFile } from 'node:fs/promises';

const [from, to, layout] = process.argv.slice(2);
const file = await open(to, 'w');
let position = 0n;
const writable = {
  write: async (bytes) => { await file.write(bytes); position += BigInt(bytes.length); },
  position: () => position,
};
const writer = new McapWriter({ writable, useChunks: layout === 'chunks', useSummaryOffsets: layout === 'chunks',
  useStatistics: layout === 'chunks', useMessageIndex: layout === 'chunks', useChunkIndex: layout === 'chunks', chunkSize: 200000 });
await writer.start({ profile: 'ros2', library: 'others' });

const stream = new McapStreamReader({ decompressHandlers: { zstd: (b, n) => zstd(b, new Uint8Array(Number(n))) } });
stream.append(await readFile(from));
const schemas = new Map(), channels = new Map();
for (let record; (record = stream.nextRecord());) {
  if (record.type === 'Schema' && !schemas.has(record.id)) {
    const definitions = parse(new TextDecoder().decode(record.data), { ros2: true });
    schemas.set(record.id, { id: await writer.registerSchema(record), reader: new MessageReader(definitions), writer: new MessageWriter(definitions) });
  } else if (record.type === 'Channel' && !channels.has(record.id)) {
    const schema = schemas.get(record.schemaId);
    channels.set(record.id, { id: await writer.registerChannel({ ...record, schemaId: schema.id }), schema });
  } else if (record.type === 'Message') {
    const { id, schema } = channels.get(record.channelId);
    await writer.addMessage({ ...record, channelId: id, data: schema.writer.writeMessage(schema.reader.readMessage(record.data)) });
  }
}
await writer.end();
await file.close();
