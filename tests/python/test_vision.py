# SPDX-License-Identifier: Apache-2.0
"""What is drawn and seen without a flight, against where it was put."""

import threading
import unittest

import numpy as np

import kestrel


def rotation(roll=0.0, pitch=0.0, yaw=0.0):
    """Turns vectors of the body into north-east-down: yaw, then pitch, then roll."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (roll, pitch, yaw))
    return (np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
            @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]]))


DOWN = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # a camera that looks down, the top of its image forward
PINHOLE = "{model: pinhole, width_px: 640, height_px: 480, fx_px: 500, fy_px: 500, cx_px: 319.5, cy_px: 239.5}"


class Pad(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.world = kestrel.World("landing")
        cls.camera = kestrel.Camera.from_yaml(PINHOLE)

    def seen_from(self, height, roll):
        position = self.world.pad_position + (0.1, -0.2, -height)
        R_NC = rotation(roll=roll, yaw=0.3) @ DOWN
        frame = self.world.render(position, R_NC, self.camera, depth=True, segmentation=True)
        truth = R_NC.T @ (self.world.pad_position - position), R_NC.T @ self.world.pad_rotation
        return frame, truth

    def test_is_where_it_was_drawn(self):
        tracker = kestrel.PadTracker("helipad", self.camera)
        for height, roll in (3.0, 0.0), (2.9, 0.03):
            frame, (position, turned) = self.seen_from(height, roll)
            pad = tracker.track(frame.image)
            self.assertIsNotNone(pad)
            np.testing.assert_allclose(pad.position, position, atol=0.02)
            np.testing.assert_allclose(pad.rotation, turned, atol=0.03)
            self.assertEqual(pad.covariance.shape, (6, 6))
        self.assertFalse(pad.found)
        self.assertIsNone(tracker.track(np.full((480, 640), 128, np.uint8)))

    def test_is_found_by_its_picture_through_a_fisheye(self):
        fisheye = kestrel.Camera.load("fisheye")
        position = self.world.pad_position + (0.0, 0.0, -2.0)
        frame = kestrel.render(self.world, fisheye, (position, DOWN))
        pad = kestrel.PadTracker("helipad", fisheye).track(frame.image)
        np.testing.assert_allclose(pad.position, (0, 0, 2), atol=0.03)

    def test_depth_is_the_distance_along_the_ray(self):
        frame, (position, _) = self.seen_from(3.0, 0.0)
        u, v = np.rint(self.camera.project(position)).astype(int)
        ray = self.camera.unproject([float(u), float(v)])
        self.assertEqual(self.world.geom_names[frame.segmentation[v, u]], "pad")
        self.assertAlmostEqual(frame.depth[v, u] * ray[2], position[2], delta=0.005)

    def test_misuse_is_named(self):
        tracker = kestrel.PadTracker("helipad", self.camera)
        with self.assertRaisesRegex(ValueError, "image is of 320 x 240 pixels"):
            tracker.track(np.zeros((240, 320), np.uint8))
        with self.assertRaisesRegex(TypeError, "image is an array of float64"):
            tracker.track(np.zeros((480, 640)))
        with self.assertRaisesRegex(ValueError, r"image has the shape \(480, 640, 4\)"):
            tracker.track(np.zeros((480, 640, 4), np.uint8))
        with self.assertRaisesRegex(kestrel.InputError, "no_such"):
            kestrel.PadTracker("no_such", self.camera)
        with self.assertRaisesRegex(ValueError, "needs its size"):
            kestrel.PadTracker(np.zeros((100, 100), np.uint8), self.camera)
        with self.assertRaisesRegex(ValueError, "rotation is none"):
            self.world.render((0, 0, -3), 2 * np.eye(3))
        with self.assertRaisesRegex(ValueError, "not finite"):
            self.world.render((np.nan, 0, -3), np.eye(3))
        with self.assertRaisesRegex(TypeError, "a camera is a kestrel.Camera"):
            self.world.render((0, 0, -3), np.eye(3), 5)

    def test_two_threads_at_a_time_are_refused(self):
        refused = []

        def draw():
            for _ in range(20):
                try:
                    self.world.render((0, 0, -3), DOWN, self.camera)
                except kestrel.SimError as error:
                    refused.append(str(error))

        threads = [threading.Thread(target=draw) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertIn("two threads use this World", refused[0])

    def test_images_of_any_strides(self):
        frame, (position, _) = self.seen_from(3.0, 0.0)
        other = np.asfortranarray(frame.image)
        for image in other, frame.image[:, ::-1][:, ::-1]:
            np.testing.assert_allclose(kestrel.PadTracker("helipad", self.camera).track(image).position, position, atol=0.02)


class Ball(unittest.TestCase):
    def test_is_where_it_was_drawn(self):
        camera = kestrel.Camera.from_yaml(PINHOLE)
        centre, radius = np.array([0.3, -0.2, 4.0]), 0.25
        v, u = np.mgrid[:480, :640]
        rays = camera.unproject(np.stack([u, v], axis=-1).astype(float))
        within = rays @ centre / np.linalg.norm(centre) > np.sqrt(1 - (radius / np.linalg.norm(centre)) ** 2)
        image = np.full((480, 640, 3), (150, 140, 130), np.uint8)
        image[within] = (30, 20, 220)
        tracker = kestrel.BallTracker(camera, hue_deg=0)
        for _ in range(3):
            ball = tracker.track(image)
        self.assertEqual(ball.state, "tracked")
        np.testing.assert_allclose(ball.direction, centre / np.linalg.norm(centre), atol=1e-3)
        self.assertAlmostEqual(np.linalg.norm(centre) * np.sin(ball.half_angle), radius, delta=0.005)
        np.testing.assert_allclose(ball.features, (centre[0] / 4, centre[1] / 4, 2 * radius / 4), atol=2e-3)
        self.assertIsNone(tracker.track(np.full((480, 640, 3), 128, np.uint8)).direction)
        with self.assertRaisesRegex(ValueError, "grey"):
            tracker.track(np.zeros((480, 640), np.uint8))


class HorizonAndCompass(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.world = kestrel.World("autumn_clear")
        cls.camera = kestrel.Camera.load("hyperbolic_mirror")

    def drawn(self, **angles):
        return self.world.render((0, 0, -80), rotation(**angles) @ DOWN, self.camera).image

    def test_attitude_is_that_of_the_camera(self):
        horizon = kestrel.Horizon(self.camera, DOWN)
        for roll, pitch in (0.0, 0.0), (0.2, -0.1):
            seen = horizon.measure(self.drawn(roll=roll, pitch=pitch))
            self.assertTrue(seen, seen.reason)
            self.assertAlmostEqual(seen.roll, roll, delta=0.03)
            self.assertAlmostEqual(seen.pitch, pitch, delta=0.03)
            np.testing.assert_allclose(seen.down, (rotation(roll, pitch) @ DOWN).T[:, 2], atol=0.05)
        nothing = horizon.measure(np.zeros((self.camera.height, self.camera.width, 3), np.uint8))
        self.assertFalse(nothing)
        self.assertTrue(nothing.reason)
        self.assertIsNone(nothing.roll)

    def test_heading_is_that_of_the_camera(self):
        compass = kestrel.Compass(self.camera, DOWN)
        for yaw in 0.0, 0.1, 0.25:
            heading = compass.turn(self.drawn(yaw=yaw), (0, 0, 1))
            self.assertTrue(heading, heading.reason)
            self.assertAlmostEqual(heading.turned, yaw, delta=0.02)
        self.assertGreater(compass.keyframes, 0)
        with self.assertRaisesRegex(ValueError, "down must be"):
            compass.turn(self.drawn(), (0, 0, 0))


if __name__ == "__main__":
    unittest.main()
