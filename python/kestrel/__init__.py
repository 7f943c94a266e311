# SPDX-License-Identifier: Apache-2.0
"""Kestrel, a simulator for flight by vision: your own flight code in its loop, and its parts by themselves.

    sim = kestrel.Sim("landing", seed=7, overrides={"wind.mean_m_s": 5})
    frame, state = sim.reset()
    while not sim.done:
        frame, state = sim.step(kestrel.Velocity(vx, vy, vz, yaw_rate))

Frames: the world is north, east, down; the body is forward, right, down; the heading frame is the world turned by
the yaw alone; a camera is right, down, forward; a pad is x along its long side, z down. Lengths are in m, angles in
rad, times in s, unless a name says otherwise. Pixels: the centre of the first is (0, 0). Colours are blue, green, red.
"""

from ._core import (
    Attitude,
    Decision,
    Frame,
    InputError,
    Position,
    Rates,
    Sim,
    SimError,
    State,
    Target,
    Truth,
    Velocity,
)

__all__ = [
    "Attitude",
    "Decision",
    "Frame",
    "InputError",
    "Position",
    "Rates",
    "Sim",
    "SimError",
    "State",
    "Target",
    "Truth",
    "Velocity",
]

for _name in __all__:  # what a reader, pickle and an error message call them
    globals()[_name].__module__ = __name__
