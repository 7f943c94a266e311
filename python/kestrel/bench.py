# SPDX-License-Identifier: Apache-2.0
"""What a step of Python's costs beside the same step in C++: `python3 -m kestrel.bench`.

Two flights of one seed, one stepped from Python and one in a loop of C++, take turns block by block, so that what else
the machine does meets both; all on one thread, whose time on the processor is told, the medians of the blocks.
"""

from __future__ import annotations

import argparse
import statistics
import time

import kestrel


def compare(images: bool, seconds: float | None, block: int, blocks: int) -> None:
    overrides = {"duration_s": 1e4, "start.settle_s": 1}
    python, cpp = (kestrel.Sim("hover", seed=1, overrides=overrides, images=images, draw_beside=False) for _ in range(2))
    python.reset(), cpp.reset()
    setpoint = kestrel.Velocity(0.1, 0, 0)
    times: tuple[list[float], list[float]] = ([], [])
    begun = python.t
    for i in range(blocks + 1):
        started = time.thread_time()
        if seconds is None:
            for _ in range(block):
                python.step(setpoint)
        else:
            for _ in range(block):
                python.advance(seconds, setpoint)
        between = time.thread_time()
        cpp._repeat(block, setpoint, seconds)
        ended = time.thread_time()
        if i > 0:  # the first warms up
            times[0].append((between - started) / block)
            times[1].append((ended - between) / block)
    assert python.summary()["state_hash"] == cpp.summary()["state_hash"]
    by_python, by_cpp = (statistics.median(each) for each in times)
    step = (python.t - begun) / (block * (blocks + 1))
    what = "step, with images" if images else "step, without" if seconds is None else f"advance({seconds:g})"
    beside = statistics.median(p - c for p, c in zip(*times))
    print(f"{what:18}  Python {1e3 * by_python:8.4f} ms  C++ {1e3 * by_cpp:8.4f} ms  beside {1e3 * beside:8.4f} ms  "
          f"rate {by_cpp / by_python:5.3f} of C++'s, {step / by_python:6.1f} x real time")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python3 -m kestrel.bench", description=__doc__)
    parser.add_argument("--blocks", type=int, default=15, help="blocks of each; default: 15")
    blocks = parser.parse_args().blocks
    sim = kestrel.Sim("hover", images=False)
    sim.reset()
    compare(images=True, seconds=None, block=20, blocks=blocks)
    compare(images=False, seconds=None, block=100, blocks=blocks)
    compare(images=False, seconds=sim.dt, block=2000, blocks=blocks)


if __name__ == "__main__":
    main()
