#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// A client of `kestrel serve --lockstep tcp:PORT` for Node, with images inline, of its own library alone.
//   examples/lockstep/client.mjs PORT SEED
import net from "node:net";

const [port, seed] = process.argv.slice(2).map(Number);
const socket = net.connect({ host: "127.0.0.1", port, noDelay: true });

async function* chunks() {
  for await (const chunk of socket) yield chunk;
}
const incoming = chunks();
let pending = Buffer.alloc(0);
async function read(size) {
  const parts = [pending];
  let have = pending.length;
  while (have < size) {
    const { value, done } = await incoming.next();
    if (done) throw new Error("the server has gone");
    parts.push(value);
    have += value.length;
  }
  const all = Buffer.concat(parts);
  pending = all.subarray(size);
  return all.subarray(0, size);
}

let token = null;
async function ask(request, keys = {}) {
  const message = Buffer.from(JSON.stringify({ request, token, ...keys }));
  const head = Buffer.alloc(4);
  head.writeUInt32LE(message.length);
  socket.write(Buffer.concat([head, message]));
  const reply = JSON.parse(await read((await read(4)).readUInt32LE()));
  reply.pixels = await read(reply.bytes ?? 0);
  token = reply.token;
  if (!reply.ok) throw new Error(`${reply.error.kind}: ${reply.error.message}`);
  return reply;
}

await ask("hello", { version: 1, client: "client.mjs", inline: true });
let now = await ask("reset", { seed });
let brightest = 0;
while (!now.done) {
  const { offset, shape, strides } = now.frame.image;
  const image = now.pixels.subarray(offset, offset + shape[0] * strides[0]);
  for (const pixel of image.subarray(0, strides[0])) brightest = Math.max(brightest, pixel);
  const { decision } = await ask("decide"); // your own code in its place
  now = await ask("step", { setpoint: decision.setpoint, aid: decision.aid });
}
const { summary } = await ask("summary");
await ask("bye");
socket.end();
console.log(`outcome ${summary.outcome}\nbrightest ${brightest}`);
console.log(`state_hash ${summary.state_hash}\nimage_hash ${summary.image_hash}`);
