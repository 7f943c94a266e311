# SPDX-License-Identifier: Apache-2.0
"""A Sim of Python's against the program, and against what it promises."""

import json
import math
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import kestrel

SHORT = {"duration_s": 1.5, "start.settle_s": 2}
PROGRAM = os.environ.get("KESTREL_PROGRAM", "kestrel")


def flown(seed, scenario="hover", images=True):
    """The hashes of a flight by setpoints of our own."""
    sim = kestrel.Sim(scenario, seed=seed, overrides=SHORT, images=images)
    frame, state = sim.reset()
    while not sim.done:
        frame, state = sim.step(kestrel.Velocity(0.3, -0.1, 0, yaw_rate=0.2))
    summary = sim.summary()
    return summary["state_hash"], summary["image_hash"]


class TheSameFlight(unittest.TestCase):
    def test_as_the_program_flies_it(self):
        sim = kestrel.Sim("landing", seed=5, overrides=SHORT)
        sim.reset()
        while not sim.done:
            sim.step(sim.decide())
        stepped = sim.summary()
        with tempfile.TemporaryDirectory() as folder:
            command = [PROGRAM, "run", "landing", "--seed", "5", "--out", folder]
            for key, value in SHORT.items():
                command += ["--set", f"{key}={value}"]
            subprocess.run(command, capture_output=True)  # it does not land in so short a time
            with open(os.path.join(folder, "summary.json")) as file:
                run = json.load(file)
        for key in "state_hash", "image_hash", "metrics", "outcome", "seed":
            self.assertEqual(stepped[key], run[key], key)

    def test_in_processes_and_threads(self):
        expected = [flown(seed) for seed in (1, 2)]
        self.assertNotEqual(expected[0], expected[1])
        for method in "fork", "spawn":
            with multiprocessing.get_context(method).Pool(2) as pool:
                self.assertEqual(pool.map(flown, (1, 2)), expected, method)
        found = [None, None]

        def fly(index):
            found[index] = flown(index + 1)

        threads = [threading.Thread(target=fly, args=(i,)) for i in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(found, expected)

    def test_without_images_in_its_states(self):
        self.assertEqual(flown(3, images=False)[0], flown(3)[0])

    def test_by_single_steps_of_the_physics(self):
        sim = kestrel.Sim("hover", overrides=SHORT, images=False)
        sim.reset()
        begun = sim.t
        for _ in range(100):
            sim.advance(sim.dt)
        self.assertAlmostEqual(sim.t, begun + 100 * sim.dt, places=9)


class WhatAStepGives(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = kestrel.Sim("landing", seed=5, overrides=SHORT, depth=True, segmentation=True, flow=True)
        cls.first, _ = cls.sim.reset()
        cls.frame, cls.state = cls.sim.step()
        cls.truth, cls.exposure = cls.sim.truth, cls.sim.exposure_truth

    def test_images_of_the_shapes_that_are_told(self):
        image = self.frame.image
        height, width = image.shape[:2]
        self.assertEqual(image.dtype, np.uint8)
        self.assertEqual((self.frame.depth.shape, self.frame.depth.dtype), ((height, width), np.float32))
        self.assertEqual((self.frame.segmentation.shape, self.frame.segmentation.dtype), ((height, width), np.int32))
        self.assertEqual((self.frame.flow.shape, self.frame.flow.dtype), ((height, width, 2), np.float32))
        self.assertIsNone(self.first.flow)
        self.assertEqual(self.frame.sequence, self.first.sequence + 1)

    def test_views_that_outlive_their_frame_and_cannot_be_written(self):
        sim = kestrel.Sim("hover", overrides=SHORT)
        frame, _ = sim.reset()
        image = frame.image
        self.assertTrue(np.shares_memory(image, frame.image))
        with self.assertRaises(ValueError):
            image[0, 0] = 0
        copy = image.copy()
        del frame
        sim.step()
        del sim
        np.testing.assert_array_equal(image, copy)

    def test_the_pad_where_the_truth_has_it(self):
        names = self.sim.geom_names
        pad = self.frame.segmentation == names.index("pad")
        self.assertGreater(pad.sum(), 100)
        distance = np.linalg.norm(self.exposure.pad_position - self.exposure.camera_position)
        v, u = np.nonzero(pad)
        middle = self.frame.depth[int(v.mean()), int(u.mean())]
        self.assertAlmostEqual(middle, distance, delta=0.1 * distance)

    def test_a_state_near_the_truth_and_not_it(self):
        height = -self.truth.position[2]
        self.assertAlmostEqual(-self.state.position[2], height, delta=2)
        np.testing.assert_allclose(self.state.rotation @ self.state.rotation.T, np.eye(3), atol=1e-12)
        w, x, y, z = self.state.attitude
        self.assertAlmostEqual(self.state.rotation[2, 0], 2 * (x * z - w * y), places=12)
        self.assertAlmostEqual(self.state.yaw, math.atan2(self.state.rotation[1, 0], self.state.rotation[0, 0]))
        self.assertIsInstance(self.state.mode, str)
        self.assertFalse(self.state.landed)
        self.assertLess(self.exposure.t, self.truth.t)
        self.assertEqual(self.exposure.t, self.frame.t)

    def test_the_scenario_with_its_overrides(self):
        self.assertRegex(self.sim.scenario, r"(?m)^duration_s: 1.5$")


class SensorsAndCameras(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.sim = kestrel.Sim("landing_sensors", seed=2, overrides=SHORT)
        cls.sim.reset()

    def test_every_sample_since_the_last_step(self):
        stamps = []
        for step in range(6):
            before = self.sim.t
            self.sim.advance(0.1) if step % 2 else self.sim.step()
            imu = self.sim.imu
            self.assertAlmostEqual(len(imu), (self.sim.t - before) * 500, delta=1)
            self.assertEqual((imu.dtype["t_ns"], imu["gyro"].shape), (np.int64, (len(imu), 3)))
            self.assertTrue((abs(imu["accel"][:, 2] + 9.8) < 3).all())
            np.testing.assert_array_equal(self.sim.imu_truth["t_ns"], imu["t_ns"])
            stamps.extend(imu["t_ns"])
        self.assertTrue((np.diff(stamps) == 2_000_000).all())
        truth = self.sim.imu_truth[-1]
        np.testing.assert_allclose(truth["position"], self.sim.truth.position, atol=0.01)
        for table in self.sim.gps, self.sim.barometer, self.sim.magnetometer, self.sim.rangefinder:
            self.assertIn("t_ns", table.dtype.names)

    def test_frames_of_all_cameras(self):
        self.sim.reset()
        frame, _ = self.sim.step()
        cameras = self.sim.cameras
        self.assertEqual(list(cameras), ["left", "right"])
        left, right = cameras["left"][-1], cameras["right"][-1]
        self.assertEqual((left.t, right.t), (frame.t, frame.t))
        self.assertAlmostEqual(np.linalg.norm(left.camera_position - right.camera_position), 0.2, places=9)
        self.assertEqual(left.image.dtype, np.uint8)
        np.testing.assert_array_equal(frame.camera_position, self.sim.exposure_truth.camera_position)

    def test_events_are_the_same_in_whatever_slices(self):
        flights = []
        for step in (lambda sim: sim.step(), lambda sim: sim.advance(0.03)):
            sim = kestrel.Sim("hover", seed=3, overrides={**SHORT, "duration_s": 0.5, "criteria": {}}, images=False, events=True)
            sim.reset()
            events = [sim.events]
            while not sim.done:
                step(sim)
                events.append(sim.events)
            flights.append(np.concatenate(events))
        by_frames, by_time = flights
        self.assertGreater(len(by_frames), 1000)
        self.assertTrue((np.diff(by_frames["t_ns"]) >= 0).all())
        self.assertLess(by_frames["x"].max(), 640)
        common = by_time["t_ns"].max() - 20_000_000  # the one ends a little earlier than the other
        np.testing.assert_array_equal(by_frames[by_frames["t_ns"] < common], by_time[by_time["t_ns"] < common])
        with self.assertRaisesRegex(kestrel.SimError, "no event camera"):
            self.sim.events

    def test_of_instruments_that_are_not_there(self):
        sim = kestrel.Sim("hover", overrides=SHORT, images=False)
        sim.reset()
        self.assertEqual(sim.cameras, {})
        with self.assertRaisesRegex(kestrel.SimError, "instruments.gps"):
            sim.gps

    def test_an_imu_where_the_scenario_has_none(self):
        sim = kestrel.Sim("hover", overrides=SHORT, images=False)
        sim.reset()
        sim.advance(0.5)
        self.assertAlmostEqual(len(sim.imu), 100, delta=1)
        self.assertTrue((abs(sim.imu["accel"][:, 2] + 9.8) < 3).all())


class Misuse(unittest.TestCase):
    def test_is_named(self):
        sim = kestrel.Sim("hover", overrides=SHORT, images=False)
        with self.assertRaisesRegex(kestrel.SimError, "call reset first"):
            sim.step()
        sim.reset()
        with self.assertRaisesRegex(kestrel.SimError, "without an image|no image|there is none"):
            sim.decide()
        with self.assertRaisesRegex(TypeError, "a setpoint is .* and not \\(1, 2, 3\\)"):
            sim.step((1, 2, 3))
        sim.finish("tired")
        self.assertTrue(sim.done)
        self.assertEqual(sim.summary()["outcome"], "tired")
        with self.assertRaisesRegex(kestrel.SimError, "tired"):
            sim.step()

    def test_changes_that_cannot_be_made(self):
        sim = kestrel.Sim("hover", overrides=SHORT)
        sim.reset()
        sim.change("wind.mean_m_s", 6)
        sim.change("sensors.faults", [{"component": "gps", "type": "off"}])
        with self.assertRaisesRegex(kestrel.SimError, "wind.mean_m_s: 60 is out of range; valid: 0 to 10"):
            sim.change("wind.mean_m_s", 60)
        with self.assertRaisesRegex(kestrel.SimError, "not among what this scenario lets change"):
            sim.change("seed", 3)
        sim.step()

    def test_setpoints_that_are_no_numbers(self):
        with self.assertRaisesRegex(ValueError, "Velocity: vy is nan"):
            kestrel.Velocity(0, math.nan, 0)
        with self.assertRaisesRegex(ValueError, "Rates: thrust is inf"):
            kestrel.Rates(0, 0, 0, math.inf)
        with self.assertRaises(TypeError):
            kestrel.Velocity("fast", 0, 0)
        with self.assertRaises(AttributeError):
            kestrel.Velocity(0, 0, 0).vx = 1

    def test_every_mistake_of_a_scenario_at_once(self):
        with self.assertRaises(kestrel.InputError) as caught:
            kestrel.Sim("hover", overrides={"wind.mean_m_z": 5, "duration_s": -1})
        self.assertIn("wind.mean_m_z", str(caught.exception))
        self.assertIn("duration_s", str(caught.exception))
        self.assertIsInstance(caught.exception, ValueError)
        self.assertTrue(issubclass(kestrel.SimError, RuntimeError))
        with self.assertRaisesRegex(kestrel.InputError, "no_such"):
            kestrel.Sim("no_such")
        with self.assertRaisesRegex(TypeError, "overrides are"):
            kestrel.Sim("hover", overrides="duration_s=1")
        with self.assertRaisesRegex(TypeError, "override wind.mean_m_s"):
            kestrel.Sim("hover", overrides={"wind.mean_m_s": object()})
        with self.assertRaisesRegex(ValueError, "without images"):
            kestrel.Sim("hover", images=False, depth=True)

    def test_in_a_process_that_did_not_make_it(self):
        sim = kestrel.Sim("hover", overrides=SHORT)
        sim.reset()
        child = os.fork()
        if child == 0:
            try:
                sim.step()
            except kestrel.SimError as error:
                os._exit(0 if "another process" in str(error) else 1)
            os._exit(2)
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), 0)
        sim.step()

    def test_by_two_threads_at_a_time(self):
        sim = kestrel.Sim("hover", overrides={"duration_s": 3600}, images=False)
        sim.reset()
        stepping = threading.Thread(target=sim.advance, args=(600.0,))  # some seconds of real time
        stepping.start()
        refused = False
        while stepping.is_alive() and not refused:
            try:
                sim.t
            except kestrel.SimError as error:
                refused = "two threads" in str(error)
        stepping.join()
        self.assertTrue(refused)


    def test_of_flow_by_a_renderer_without_it(self):
        with self.assertRaisesRegex(kestrel.InputError, "render.backend is osmesa"):
            kestrel.Sim("hover", overrides={"render.backend": "osmesa"}, flow=True)

    def test_times_that_are_none(self):
        sim = kestrel.Sim("hover", overrides=SHORT, images=False)
        sim.reset()
        for seconds in (0, -1, float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "seconds"):
                sim.advance(seconds)

    def test_is_left_by_an_interrupt_in_the_middle(self):
        sim = kestrel.Sim("hover", overrides={"duration_s": 3600}, images=False)
        sim.reset()
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
        with self.assertRaises(KeyboardInterrupt):
            sim.advance(3500)
        self.assertLess(sim.t, 3500)
        self.assertFalse(sim.done)
        sim.step()


class Values(unittest.TestCase):
    def test_overrides_of_every_kind(self):
        sim = kestrel.Sim("hover", overrides={"duration_s": np.float64(2.5), "start.on_ground": False,
                                              "start.offset_m": np.array([1.0, 2.0]), "vehicle": "pelican"})
        self.assertRegex(sim.scenario, r"offset_m: \[1, 2\]")
        kestrel.Sim("hover", overrides=["duration_s=2.5"])

    def test_setpoints_through_pickle(self):
        for setpoint in (kestrel.Velocity(1, 2, 3, 4), kestrel.Position(1, 2, 3, yaw=4),
                         kestrel.Attitude(0.1, 0.2, 0.3, 0.4), kestrel.Rates(1, 2, 3, 0.5)):
            self.assertEqual(repr(pickle.loads(pickle.dumps(setpoint))), repr(setpoint))


class BesideOpenCv(unittest.TestCase):
    def test_in_either_order(self):
        try:
            import cv2  # noqa: F401
        except ImportError:
            self.skipTest("without python3-opencv")
        for order in "import cv2, kestrel", "import kestrel, cv2":
            code = order + "; import numpy; s = kestrel.Sim('hover', overrides={'duration_s': 2}); f, _ = s.reset(); " \
                "g = cv2.GaussianBlur(f.image, (5, 5), 1); c = cv2.findContours((g[..., 0] if g.ndim == 3 else g) // 128, " \
                "cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE); s.step(s.decide())"
            subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


if __name__ == "__main__":
    unittest.main()
