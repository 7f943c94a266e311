# SPDX-License-Identifier: Apache-2.0
"""Holds a horizon detector of one's own against the truth: where it is good, and where it is not."""

import sys

import cv2
import kestrel
import numpy as np

F, CX, CY = 378.38, 319.5, 239.5  # px, of models/cameras/thesis_2_8mm.yaml
AHEAD = {"camera": "thesis_2_8mm", "mount.pitch_deg": 90, "mount.position_m": [0.3, 0, 0]}


def horizon(image):
    """Roll and pitch, rad: sky is what is bright in blue, down to the row of each column that parts it best."""
    blue = cv2.GaussianBlur(image[:, :, 0], (5, 5), 0).astype(float)
    above = np.cumsum(blue, axis=0)[:-1]
    rows = np.arange(1, len(blue))[:, None]
    below = blue.sum(axis=0) - above
    contrast = rows * (len(blue) - rows) * (above / rows - below / (len(blue) - rows))
    edge = np.column_stack([np.arange(blue.shape[1]), contrast.argmax(axis=0)]).astype(np.float32)
    right, down, x, y = cv2.fitLine(edge, cv2.DIST_HUBER, 0, 0.01, 0.01).ravel()
    if right < 0:
        right, down = -right, -down
    # The plane through the line and the lens: its normal is the world's down, in right, down and forward of the camera.
    normal = np.array([-down, right, (-down * (CX - x) + right * (CY - y)) / F])
    normal /= np.linalg.norm(normal)
    return np.arctan2(normal[0], normal[1]), -np.arcsin(normal[2])


def evaluate(world, seconds):
    """RMS errors of roll and pitch, degrees, of a flight that swings about."""
    sim = kestrel.Sim("attitude_1", seed=1, overrides={"world": world, "duration_s": seconds, **AHEAD})
    frame, state = sim.reset()
    errors = []
    while not sim.done:
        R = sim.exposure_truth.rotation
        truth = np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0])
        errors.append(np.degrees(np.subtract(horizon(frame.image), truth)))
        frame, state = sim.step(kestrel.Velocity(4 * np.sin(sim.t), 4 * np.cos(0.7 * sim.t), 0, yaw_rate=0.4))
    return np.sqrt(np.mean(np.square(errors), axis=0)), len(errors)


if __name__ == "__main__":
    for world in ("autumn_clear", "winter_cloudy"):
        (roll, pitch), images = evaluate(world, float(sys.argv[1]) if len(sys.argv) > 1 else 15)
        print(f"{world:14} roll {roll:5.2f}, pitch {pitch:5.2f} degrees RMS in {images} images")
