#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A client of `kestrel serve --lockstep`, of Python's standard library alone.

    kestrel serve landing --lockstep /tmp/landing.sock --once &
    examples/lockstep/client.py /tmp/landing.sock --seed 7
"""
import argparse
import json
import mmap
import os
import socket
import struct
import time

TYPES = {"uint8": "B", "int32": "i", "float32": "f"}


class Lockstep:
    """One connection. Each method sends a request and returns the reply as a dict; a refusal is an exception."""

    def __init__(self, address, name="client.py", patience_s=30):
        tcp = address.startswith("tcp:")
        place = ("127.0.0.1", int(address[4:])) if tcp else address
        end = time.monotonic() + patience_s
        while True:  # the server may be about to listen
            self.socket = socket.socket(socket.AF_INET if tcp else socket.AF_UNIX)
            try:
                self.socket.connect(place)
                break
            except (ConnectionRefusedError, FileNotFoundError):
                self.socket.close()
                if time.monotonic() > end:
                    raise
                time.sleep(0.05)
        if tcp:
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.token, self.reply, self.memory, self.mapped, self.inline = None, None, None, None, b""
        self.hello = self.ask("hello", version=1, client=name)

    def ask(self, request, **keys):
        message = json.dumps({"request": request, "token": self.token, **keys}).encode()
        self.socket.sendall(struct.pack("<I", len(message)) + message)
        self.reply = reply = json.loads(self._read(struct.unpack("<I", self._read(4))[0]))
        self.inline = self._read(reply.get("bytes", 0))
        self.token = reply["token"]
        if not reply["ok"]:
            raise RuntimeError("{kind}: {message}".format(**reply["error"]))
        return reply

    def pixels(self, frame, picture="image"):
        """Of a frame of the last reply: a memoryview of shape [rows, columns(, channels)], until the next request."""
        layout = frame[picture]
        if "memory" in self.reply:
            if self.reply["memory"] != self.memory:
                self.memory = self.reply["memory"]
                file = os.open("/dev/shm" + self.memory, os.O_RDONLY)
                self.mapped = mmap.mmap(file, self.reply["memory_bytes"], prot=mmap.PROT_READ)
                os.close(file)
            memory = memoryview(self.mapped)
        else:
            memory = memoryview(self.inline)
        size = layout["strides"][0] * layout["shape"][0]
        part = memory[layout["offset"]:layout["offset"] + size]
        return part.cast("B").cast(TYPES[layout["type"]], layout["shape"])

    def _read(self, size):
        parts = []
        while size > 0:
            part = self.socket.recv(size)
            if not part:
                raise ConnectionError("the server has gone")
            parts.append(part)
            size -= len(part)
        return b"".join(parts)


def fly(client, seed, images):
    """A flight by what the scenario's own mission decides; put your own code in the place of `decide`."""
    now = client.ask("reset", seed=seed, images=images)
    brightest = 0
    while not now["done"]:
        if images:
            image = client.pixels(now["frame"])
            brightest = max(brightest, max(bytes(image[:1])))  # of the first row: that there is an image
            decision = client.ask("decide")["decision"]
            now = client.ask("step", setpoint=decision["setpoint"], aid=decision["aid"])
        else:
            now = client.ask("step", setpoint={"kind": "velocity", "v_H_m_s": [0, 0, 0], "yaw_rate_rad_s": 0})
    return client.ask("summary")["summary"], brightest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("address", help="file of the Unix socket, or tcp:PORT")
    parser.add_argument("--seed", type=int)
    parser.add_argument("--blind", action="store_true", help="without images")
    arguments = parser.parse_args()
    client = Lockstep(arguments.address)
    summary, brightest = fly(client, arguments.seed, not arguments.blind)
    client.ask("bye")
    print("outcome", summary["outcome"])
    print("brightest", brightest)
    print("state_hash", summary["state_hash"])
    print("image_hash", summary["image_hash"])


if __name__ == "__main__":
    main()
