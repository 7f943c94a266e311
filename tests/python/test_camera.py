# SPDX-License-Identifier: Apache-2.0
"""Camera models against OpenCV's and against their definitions, and the files that they come from."""

import os
import pickle
import tempfile
import unittest

import numpy as np

import kestrel

NAMES = ("thesis_6mm", "fisheye", "fisheye_190", "hyperbolic_mirror", "real_6mm")


def points(count=500, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform((-1, -1, 0.5), (1, 1, 4), (count, 3))


class Models(unittest.TestCase):
    def test_unproject_is_the_inverse_of_project(self):
        for name in NAMES:
            camera = kestrel.Camera.load(name)
            p = points()
            pixels = camera.project(p)
            valid = ~np.isnan(pixels[:, 0])
            self.assertGreater(valid.sum(), 100, name)
            rays = camera.unproject(pixels[valid])
            seen = ~np.isnan(rays[:, 0])
            self.assertGreater(seen.sum(), 100, name)
            direction = p[valid][seen] / np.linalg.norm(p[valid][seen], axis=1, keepdims=True)
            np.testing.assert_allclose(rays[seen], direction, atol=1e-8, err_msg=name)

    def test_jacobian_is_the_derivative(self):
        for name in NAMES:
            camera = kestrel.Camera.load(name)
            p = points(50)
            jacobian = camera.jacobian(p)
            self.assertEqual(jacobian.shape, (50, 2, 3))
            for axis in range(3):
                step = np.zeros(3)
                step[axis] = 1e-6
                slope = (camera.project(p + step) - camera.project(p - step)) / 2e-6
                valid = ~np.isnan(slope[:, 0]) & ~np.isnan(jacobian[:, 0, 0])
                self.assertGreater(valid.sum(), 10, name)
                np.testing.assert_allclose(jacobian[valid, :, axis], slope[valid], atol=1e-3, rtol=1e-5, err_msg=name)

    def test_a_pinhole_by_its_definition(self):
        camera = kestrel.Camera.from_yaml("{model: pinhole, width_px: 640, height_px: 480, fx_px: 500, fy_px: 510, cx_px: 320, cy_px: 240}")
        p = points()
        expected = p[:, :2] / p[:, 2:] * (500, 510) + (320, 240)
        np.testing.assert_allclose(camera.project(p), expected, rtol=1e-13)
        self.assertEqual((camera.model, camera.width, camera.height), ("pinhole", 640, 480))
        self.assertEqual(camera.parameters, {"fx": 500, "fy": 510, "cx": 320, "cy": 240})
        self.assertTrue(np.isnan(camera.project([0.0, 0.0, -1.0])).all())
        self.assertEqual(camera.project(np.ones((2, 3, 3))).shape, (2, 3, 2))

    def test_opencv_projects_the_same(self):
        try:
            import cv2
        except ImportError:
            self.skipTest("without python3-opencv")
        matrix = np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]])
        p = points()
        distortion = np.array([-0.2, 0.05, 0.001, -0.002])
        kalibr = ("cam0: {{camera_model: pinhole, distortion_model: {}, intrinsics: [500, 510, 320, 240], "
                  "distortion_coeffs: {}, resolution: [640, 480]}}")
        camera = kestrel.Camera.from_yaml(kalibr.format("radtan", distortion.tolist()))
        pixels = camera.project(p)
        valid = ~np.isnan(pixels[:, 0])
        self.assertGreater(valid.sum(), 300)
        expected, _ = cv2.projectPoints(p[valid], np.zeros(3), np.zeros(3), matrix, distortion)
        np.testing.assert_allclose(pixels[valid], expected[:, 0], atol=1e-9)

        fisheye = np.array([0.02, -0.01, 0.003, -0.001])
        camera = kestrel.Camera.from_yaml(kalibr.format("equidistant", fisheye.tolist()))
        expected, _ = cv2.fisheye.projectPoints(p[:, None], np.zeros(3), np.zeros(3), matrix, fisheye)
        np.testing.assert_allclose(camera.project(p), expected[:, 0], atol=1e-9)


class Files(unittest.TestCase):
    def test_what_is_saved_reads_back(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in NAMES:
                camera = kestrel.Camera.load(name)
                file = os.path.join(folder, name + ".yaml")
                camera.save(file)
                again = kestrel.Camera.load(file)
                np.testing.assert_array_equal(again.project(points()), camera.project(points()))
                np.testing.assert_array_equal(pickle.loads(pickle.dumps(camera)).project(points()), camera.project(points()))

    def test_of_a_chain_of_kalibr(self):
        chain = "\n".join(f"cam{i}: {{camera_model: pinhole, distortion_model: none, distortion_coeffs: [], "
                          f"intrinsics: [{400 + i}, 400, 320, 240], resolution: [640, 480]}}" for i in range(2))
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "chain.yaml")
            with open(file, "w") as out:
                out.write(chain)
            self.assertEqual(kestrel.Camera.names(file), ["cam0", "cam1"])
            self.assertEqual(kestrel.Camera.load(file, camera="cam1").parameters["fx"], 401)
        self.assertEqual(kestrel.Camera.from_yaml(kestrel.Camera.load("thesis_6mm").yaml("kalibr")).width,
                         kestrel.Camera.load("thesis_6mm").width)

    def test_of_opencv(self):
        try:
            import cv2
        except ImportError:
            self.skipTest("without python3-opencv")
        matrix = np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]])
        distortion = np.array([[-0.2, 0.05, 0.001, -0.002, 0.01]])
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "camera.yml")
            storage = cv2.FileStorage(file, cv2.FILE_STORAGE_WRITE)
            storage.write("camera_matrix", matrix)
            storage.write("distortion_coefficients", distortion)
            storage.release()
            with self.assertRaisesRegex(kestrel.InputError, "image_width"):
                kestrel.Camera.load(file)
            camera = kestrel.Camera.load(file, size=(640, 480))
        p = points()
        pixels = camera.project(p)
        valid = ~np.isnan(pixels[:, 0])
        self.assertGreater(valid.sum(), 300)
        expected, _ = cv2.projectPoints(p[valid], np.zeros(3), np.zeros(3), matrix, distortion)
        np.testing.assert_allclose(pixels[valid], expected[:, 0], atol=1e-9)

    def test_mistakes_are_named(self):
        with self.assertRaisesRegex(kestrel.InputError, "no_such"):
            kestrel.Camera.load("no_such")
        with self.assertRaisesRegex(kestrel.InputError, "fx"):
            kestrel.Camera.from_yaml("{model: pinhole, width_px: 640, height_px: 480, fx_px: -3, fy_px: 510, cx_px: 320, cy_px: 240}")
        camera = kestrel.Camera.load("thesis_6mm")
        with self.assertRaisesRegex(ValueError, r"points have the shape \(5, 2\)"):
            camera.project(np.zeros((5, 2)))
        with self.assertRaisesRegex(ValueError, r"pixels have the shape"):
            camera.unproject(np.zeros(3))
        with self.assertRaisesRegex(ValueError, "form 'xml'"):
            camera.yaml("xml")
        self.assertTrue(np.isnan(camera.project([np.nan, 0, 1])).all())


if __name__ == "__main__":
    unittest.main()
