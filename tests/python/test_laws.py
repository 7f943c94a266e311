# SPDX-License-Identifier: Apache-2.0
"""Laws of servoing against their definitions in numpy."""

import math
import unittest

import numpy as np

import kestrel
from kestrel import laws


def rotation_about(axis, angle):
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K


class ImageBased(unittest.TestCase):
    points = np.array([[0.1, 0.2], [-0.2, 0.1], [-0.1, -0.3], [0.25, -0.15]])
    depths = np.array([2.0, 2.5, 1.5, 3.0])

    def test_interaction_is_the_derivative_of_the_image(self):
        L = laws.point_interaction(self.points, self.depths)
        P = np.c_[self.points * self.depths[:, None], self.depths]
        h = 1e-6
        for i in range(6):
            v, w = np.zeros(3), np.zeros(3)
            (v if i < 3 else w)[i % 3] = 1
            moved = P + h * (-v - np.cross(w, P))
            slope = ((moved[:, :2] / moved[:, 2:] - self.points) / h).ravel()
            np.testing.assert_allclose(L[:, i], slope, atol=1e-5)

    def test_the_law_by_a_pseudo_inverse(self):
        wanted = self.points * 0.9
        L = laws.point_interaction(self.points, self.depths)
        step = laws.ibvs(self.points, self.depths, wanted, self.depths, gain=0.7)
        self.assertTrue(step.regular)
        np.testing.assert_allclose(step.velocity, -0.7 * np.linalg.pinv(L) @ (self.points - wanted).ravel(), atol=1e-9)
        np.testing.assert_allclose(laws.servo(L, (self.points - wanted).ravel(), 0.7).velocity, step.velocity, atol=1e-12)

    def test_bearings(self):
        s = np.c_[self.points, np.ones(4)]
        s /= np.linalg.norm(s, axis=1, keepdims=True)
        L = laws.bearing_interaction(s[:1], [2.0])
        u = s[0]
        np.testing.assert_allclose(L[:, :3], -(np.eye(3) - np.outer(u, u)) / 2, atol=1e-12)
        np.testing.assert_allclose(L[:, 3:] @ np.array([1.0, 2, 3]), np.cross(u, [1, 2, 3]), atol=1e-12)

    def test_misuse_is_named(self):
        with self.assertRaisesRegex(ValueError, "4 points and 3 depths"):
            laws.point_interaction(self.points, self.depths[:3])
        with self.assertRaisesRegex(ValueError, "gain is -1"):
            laws.ibvs(self.points, self.depths, self.points, self.depths, -1)
        with self.assertRaisesRegex(ValueError, "interaction 'best'"):
            laws.ibvs(self.points, self.depths, self.points, self.depths, 1, "best")


class PoseBased(unittest.TestCase):
    def test_the_decoupled_law(self):
        t, axis = np.array([0.3, -0.5, 1.0]), np.array([1.0, 2, -1])
        R = rotation_about(axis, 0.6)
        velocity = laws.pbvs(t, R, 0.5)
        np.testing.assert_allclose(velocity[:3], -0.5 * R.T @ t, atol=1e-12)
        np.testing.assert_allclose(velocity[3:], -0.5 * 0.6 * axis / np.linalg.norm(axis), atol=1e-12)

    def test_a_setpoint_within_its_limits(self):
        setpoint = laws.setpoint((-10, 0, 0), 0.0, speed_limit=2.0)
        self.assertIsInstance(setpoint, kestrel.Velocity)
        self.assertAlmostEqual(setpoint.vx, 2.0)
        self.assertAlmostEqual(laws.setpoint((-0.1, 0, 0.2), 0.0, gain=1, vertical_gain=1).vz, -0.2)


class Targets(unittest.TestCase):
    def test_following_lets_the_error_fall_exponentially(self):
        image, wanted, Z = np.array([0.1, -0.05, 0.12]), np.array([0, 0, 0.1]), 4.0
        v_y, v_z, w_y = laws.follow(image, wanted, Z, (0.5, 0.5, 0.5))
        rate = laws.sphere_interaction(image, Z) @ np.array([0, v_y, v_z, 0, w_y, 0])
        np.testing.assert_allclose(rate, -0.5 * (image - wanted), atol=1e-12)

    def test_a_bearing_that_is_held(self):
        rate, side = laws.hold_bearing(math.radians(20), bearing=math.radians(50), gain=1.0)
        self.assertAlmostEqual(rate, math.radians(20 - 50))
        self.assertEqual(side, "left")


if __name__ == "__main__":
    unittest.main()
