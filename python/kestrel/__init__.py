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

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from ._core import (
    Attitude,
    Ball,
    BallTracker,
    Camera,
    Compass,
    Decision,
    Frame,
    Heading,
    Horizon,
    InputError,
    PadPose,
    PadTracker,
    Position,
    Rates,
    Sim,
    SimError,
    Skyline,
    State,
    Target,
    Truth,
    Velocity,
    World,
)
from . import laws

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = [
    "Attitude",
    "Ball",
    "BallTracker",
    "Camera",
    "Compass",
    "Decision",
    "Frame",
    "Heading",
    "Horizon",
    "InputError",
    "PadPose",
    "PadTracker",
    "Position",
    "Rates",
    "Sim",
    "SimError",
    "Skyline",
    "State",
    "Target",
    "Truth",
    "Velocity",
    "World",
    "laws",
    "render",
]


def render(
    world: World | str | os.PathLike[str],
    camera: Camera | str | os.PathLike[str] | None,
    pose: tuple[ArrayLike, ArrayLike],
    *,
    depth: bool = False,
    segmentation: bool = False,
) -> Frame:
    """What a camera sees, without a flight.

    world: a World, or the name of a scenario or a world, or a scenario's file; for many images make a World once.
    camera: a Camera, or the name or the file of one; None: the scenario's. pose: position (3,), north, east, down, m;
    and rotation (3, 3), which turns vectors of the camera into north-east-down.
    """
    position, rotation = pose
    if not isinstance(world, World):
        world = World(world)
    return world.render(position, rotation, camera, depth=depth, segmentation=segmentation)


for _name in __all__:  # what a reader, pickle and an error message call them
    if isinstance(globals()[_name], type):
        globals()[_name].__module__ = __name__
