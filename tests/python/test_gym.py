# SPDX-License-Identifier: Apache-2.0
"""kestrel.gym: Gymnasium's contract, what observations and rewards are, and that a seed gives one episode alone."""

import hashlib
import multiprocessing
import subprocess
import sys
import textwrap
import unittest

import gym_contract
import kestrel
import kestrel.gym
import numpy as np

try:
    import gymnasium
    from gymnasium.utils.env_checker import check_env
except ImportError:
    gymnasium = None


def episode_hash(id, seed, steps, arguments):
    """Of all observations and rewards of an episode of drawn actions."""
    env = kestrel.gym.make(id, **arguments)
    actions = np.random.default_rng(seed).uniform(-1, 1, (steps, 4))
    observation, _ = env.reset(seed=seed)
    seen = hashlib.sha256()
    for action in actions:
        parts = observation.values() if isinstance(observation, dict) else [observation]
        for part in parts:
            seen.update(part.tobytes())
        observation, reward, terminated, truncated, _ = env.step(action)
        seen.update(np.float64(reward).tobytes())
        if terminated or truncated:
            break
    return seen.hexdigest()


def fly(env, pilot, seed):
    """The return, and the end's outcome, observation and metrics."""
    state, _ = env.reset(seed=seed)
    total = 0.0
    while True:
        state, reward, terminated, truncated, info = env.step(pilot(state))
        total += reward
        if terminated or truncated:
            return total, info["outcome"], state, info["metrics"]


def to_goal(env, state, gain=1.0):
    """A proportional pilot: velocities and yaw rate in proportion to what is left."""
    return gain * np.append(state[:3], state[8]) / env.limits


class Contract(unittest.TestCase):
    def test_states(self):
        for id in kestrel.gym.ENVIRONMENTS:
            with self.subTest(id):
                gym_contract.check(kestrel.gym.make(id))

    def test_images_and_both(self):
        gym_contract.check(kestrel.gym.make("kestrel/Landing-v0", observation="image", render_mode="rgb_array"))
        gym_contract.check(kestrel.gym.make("kestrel/Following-v0", observation="both", render_mode="rgb_array"))

    def test_rates(self):
        gym_contract.check(kestrel.gym.make("kestrel/Hover-v0", action="rates"))

    @unittest.skipIf(gymnasium, "Gymnasium is installed")
    def test_registers_with_a_gymnasium(self):
        program = textwrap.dedent("""
            import pkgutil, sys, types
            from kestrel import _environment
            registered = {}
            sys.modules["gymnasium"] = types.SimpleNamespace(
                Env=type("Env", (_environment.Env,), {}),
                register=lambda id, entry_point: registered.update({id: entry_point}))
            sys.modules["gymnasium.spaces"] = _environment
            import kestrel.gym
            for id, entry_point in registered.items():
                assert kestrel.gym.ENVIRONMENTS[id] is pkgutil.resolve_name(entry_point), id
                assert issubclass(kestrel.gym.ENVIRONMENTS[id], sys.modules["gymnasium"].Env)
            print(len(registered))
            """)
        self.assertEqual(subprocess.check_output([sys.executable, "-c", program], text=True), "4\n")

    @unittest.skipUnless(gymnasium, "Gymnasium is not installed")
    def test_gymnasium_finds_no_fault(self):
        for id in kestrel.gym.ENVIRONMENTS:
            with self.subTest(id):
                check_env(gymnasium.make(id, render_mode="rgb_array").unwrapped)

    @unittest.skipUnless(gymnasium, "Gymnasium is not installed")
    def test_vector_of_processes(self):
        envs = gymnasium.vector.AsyncVectorEnv([lambda: kestrel.gym.make("kestrel/Hover-v0")] * 2)
        together, _ = envs.reset(seed=[1, 2])
        for row, seed in zip(together, (1, 2)):
            np.testing.assert_array_equal(row, kestrel.gym.make("kestrel/Hover-v0").reset(seed=seed)[0])
        envs.close()


class Determinism(unittest.TestCase):
    def test_the_same_in_another_process(self):
        flights = [("kestrel/Hover-v0", 5, 40, {"action": "rates"}), ("kestrel/Avoiding-v0", 5, 20, {}),
                   ("kestrel/Landing-v0", 5, 10, {"observation": "both"})]
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            elsewhere = pool.starmap(episode_hash, flights)
        self.assertEqual(elsewhere, [episode_hash(*flight) for flight in flights])
        self.assertNotEqual(elsewhere[0], episode_hash("kestrel/Hover-v0", 6, 40, {"action": "rates"}))

    def test_a_seed_is_that_of_the_scenario(self):
        env = kestrel.gym.make("kestrel/Hover-v0")
        _, info = env.reset(seed=7)
        sim = kestrel.Sim("hover", seed=7, images=False)
        sim.reset()
        np.testing.assert_array_equal(info["truth"]["position"], sim.truth.position)

    def test_seeds_that_are_drawn_are_told_and_come_again(self):
        env = kestrel.gym.make("kestrel/Hover-v0")
        env.reset(seed=1)
        state, info = env.reset()
        np.testing.assert_array_equal(state, env.reset(seed=info["seed"])[0])


class Meaning(unittest.TestCase):
    def test_the_state_is_the_truth_in_the_heading_frame(self):
        env = kestrel.gym.make("kestrel/Hover-v0")
        env.reset(seed=3)
        state, reward, _, _, info = env.step(np.array([0.5, -0.5, 0.2, 0.3]))
        w, x, y, z = info["truth"]["attitude"]
        yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        turn = np.exp(-1j * yaw)
        to_goal = np.array([0, 0, -3]) - info["truth"]["position"]
        for part, vector in ((state[:3], to_goal), (state[3:6], info["truth"]["velocity"])):
            ahead = turn * complex(vector[0], vector[1])
            np.testing.assert_allclose(part, [ahead.real, ahead.imag, vector[2]], atol=0.03)  # the pad's thickness
        self.assertAlmostEqual(state[6], np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), places=5)
        self.assertAlmostEqual(state[7], np.arcsin(2 * (w * y - z * x)), places=5)
        self.assertAlmostEqual(reward, -(np.linalg.norm(state[:3]) + abs(state[8]) / 5) * 0.05, places=5)

    def test_a_proportional_pilot_hovers_at_the_goal(self):
        env = kestrel.gym.make("kestrel/Hover-v0", duration_s=12)
        _, outcome, state, metrics = fly(env, lambda state: to_goal(env, state), 1)
        self.assertEqual(outcome, "completed")
        self.assertLess(np.linalg.norm(state[:3]), 0.3)
        self.assertIn("max_tilt_deg", metrics)

    def test_a_proportional_pilot_lands(self):
        env = kestrel.gym.make("kestrel/Landing-v0")

        def pilot(state):
            action = to_goal(env, state)
            action[2] = (0.25 if state[2] < 1 else 0.6) / env.limits[2]
            return action

        total, outcome, _, metrics = fly(env, pilot, 1)
        self.assertEqual(outcome, "landed")
        self.assertLess(metrics["touchdown_error_m"], 0.12)
        self.assertGreater(total, 10)

    def test_a_proportional_pilot_follows(self):
        env = kestrel.gym.make("kestrel/Following-v0", duration_s=10)
        total, outcome, state, _ = fly(env, lambda state: to_goal(env, state, 1.5), 1)
        self.assertEqual(outcome, "completed")
        self.assertGreater(total, -10)

    def test_who_avoids_nothing_comes_too_near(self):
        env = kestrel.gym.make("kestrel/Avoiding-v0")
        ahead = np.array([4 / 6, 0, 0, 0])
        total, outcome, _, _ = fly(env, lambda state: ahead, 1)
        self.assertEqual(outcome, "too near")
        self.assertLess(total, 0)

    def test_who_flies_below_them_arrives(self):
        env = kestrel.gym.make("kestrel/Avoiding-v0")

        def pilot(state):
            action = to_goal(env, state)
            action[:2] *= min(1, 1 / np.hypot(*action[:2]))
            if state[0] > 20:
                action[2] = 1 - state[2] / -8 if state[2] > -8 else 0  # to 8 m below the course
            return action

        total, outcome, _, _ = fly(env, pilot, 1)
        self.assertEqual(outcome, "arrived")
        self.assertGreater(total, 90)

    def test_a_crash_costs_as_much_as_staying_away(self):
        env = kestrel.gym.make("kestrel/Hover-v0")
        total, outcome, _, _ = fly(env, lambda state: np.array([0, 0, 1, 0]), 1)
        self.assertEqual(outcome, "crashed")
        self.assertLess(total, -15 * 30)

    def test_it_is_truncated_when_time_is_up(self):
        env = kestrel.gym.make("kestrel/Hover-v0", duration_s=1)
        env.reset(seed=1)
        steps = [env.step(np.zeros(4)) for _ in range(18)]
        self.assertFalse(any(terminated or truncated for _, _, terminated, truncated, _ in steps))
        while not (last := env.step(np.zeros(4)))[3]:
            self.assertFalse(last[2])
        self.assertIn("metrics", last[4])
        with self.assertRaisesRegex(kestrel.SimError, "reset"):
            env.step(np.zeros(4))


class BadUse(unittest.TestCase):
    def test_arguments(self):
        for arguments, why in (({"observation": "smell"}, "smell"), ({"action": "stick"}, "stick"),
                               ({"render_mode": "human"}, "human"),
                               ({"action": "rates", "observation": "image"}, "state")):
            with self.subTest(why), self.assertRaisesRegex(ValueError, why):
                kestrel.gym.make("kestrel/Hover-v0", **arguments)
        with self.assertRaisesRegex(ValueError, "kestrel/Hover-v0"):
            kestrel.gym.make("kestrel/Hovering-v0")

    def test_actions(self):
        env = kestrel.gym.make("kestrel/Hover-v0")
        with self.assertRaisesRegex(kestrel.SimError, "reset"):
            env.step(np.zeros(4))
        env.reset(seed=1)
        for action in (np.zeros(3), np.array([0, np.nan, 0, 0])):
            with self.assertRaisesRegex(ValueError, "four finite"):
                env.step(action)


if __name__ == "__main__":
    unittest.main()
