# SPDX-License-Identifier: Apache-2.0
"""Lands by a pad detector of one's own: SIFT features of the pad's picture, found in the image, give the pad's pose."""

import sys

import cv2
import kestrel
import numpy as np

K = np.array([[810.81, 0, 319.5], [0, 810.81, 239.5], [0, 0, 1]])  # of models/cameras/thesis_6mm.yaml
PAD = (1.19, 0.91)  # m, along the picture's up and right (models/pads/helipad)


class PadFinder:
    def __init__(self, picture):
        self.sift, self.matcher = cv2.SIFT_create(600), cv2.FlannBasedMatcher({"algorithm": 1, "trees": 4}, {})
        height, width = picture.shape
        keys, descriptors = cv2.SIFT_create().detectAndCompute(picture, None)
        self.matcher.add([descriptors])
        self.points = np.array([(PAD[0] * (0.5 - k.pt[1] / height), PAD[1] * (k.pt[0] / width - 0.5), 0) for k in keys])

    def find(self, image):
        """Where the pad's middle is from the camera: right, down, ahead, m; None: not seen."""
        half = cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        keys, descriptors = self.sift.detectAndCompute(half, None)
        if len(keys) < 8:
            return None
        pairs = self.matcher.knnMatch(descriptors, k=2)
        good = [a for a, b in pairs if a.distance < 0.75 * b.distance]
        if len(good) < 8:
            return None
        pad = self.points[[m.trainIdx for m in good]]
        seen = np.array([keys[m.queryIdx].pt for m in good]) * 2 + 0.5
        _, inliers = cv2.findHomography(pad[:, :2], seen, cv2.RANSAC, 3.0)
        if inliers is None or inliers.sum() < 10:
            return None
        inliers = inliers.ravel() > 0
        return cv2.solvePnP(pad[inliers], seen[inliers], K, None)[2].ravel()


def land(finder, seed):
    sim = kestrel.Sim("landing", seed=seed)
    frame, state = sim.reset()
    offset, seen_s = np.zeros(3), 0.0  # from the aircraft to the pad in the heading frame, m, and when that was
    hold = np.zeros(2)  # m/s, what it takes to stay: the autopilot errs a little in its velocity
    while not sim.done and not state.landed:
        pose = finder.find(frame.image)
        if pose is not None:
            right, down, ahead = pose  # of the camera, whose image has the aircraft's nose on top
            c, s = np.cos(state.yaw), np.sin(state.yaw)
            to_heading = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
            offset, seen_s = to_heading @ state.rotation @ [-down, right, ahead], sim.t
            if np.hypot(*offset[:2]) < 0.3:
                hold += 0.02 * offset[:2]
        blind, low = sim.t - seen_s > 0.2, 0 < offset[2] < 0.35  # too low to see enough of the pad
        centred = not blind and np.hypot(*offset[:2]) < 0.05 + 0.1 * offset[2]
        way = np.zeros(2) if blind else np.clip(offset[:2], -0.6, 0.6)
        sink = np.clip(0.3 * offset[2], 0.2, 0.6) if centred or low else 0.0
        frame, state = sim.step(kestrel.Velocity(*(way + hold), sink))
    if not sim.done:
        sim.finish("landed")
    return sim.summary()


if __name__ == "__main__":
    finder = PadFinder(cv2.resize(cv2.imread(sys.argv[1], cv2.IMREAD_GRAYSCALE), (1024, 1024)))
    for seed in map(int, sys.argv[2:]):
        summary = land(finder, seed)
        print(f"seed {seed}: {'passed' if summary['passed'] else 'FAILED'} ({summary['outcome']}), touched down "
              f"{100 * summary['metrics'].get('touchdown_error_m', np.nan):.1f} cm from the middle")
