# SPDX-License-Identifier: Apache-2.0
"""Laws of visual servoing: what a camera does so that an image becomes the one that is wanted.

Image-based: servo, ibvs, bearing_servo, with their interaction matrices. Position-based: pbvs, pbvs_target, setpoint.
Of a sphere: follow. See and avoid: hold_bearing.
"""

from ._core import (
    ServoStep,
    bearing_interaction,
    bearing_servo,
    follow,
    hold_bearing,
    ibvs,
    pbvs,
    pbvs_target,
    point_interaction,
    servo,
    setpoint,
    sphere_interaction,
)

__all__ = [
    "ServoStep",
    "bearing_interaction",
    "bearing_servo",
    "follow",
    "hold_bearing",
    "ibvs",
    "pbvs",
    "pbvs_target",
    "point_interaction",
    "servo",
    "setpoint",
    "sphere_interaction",
]

ServoStep.__module__ = __name__
