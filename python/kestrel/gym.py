# SPDX-License-Identifier: Apache-2.0
"""Kestrel's flights as environments of Gymnasium (https://gymnasium.farama.org).

    import gymnasium, kestrel.gym
    env = gymnasium.make("kestrel/Hover-v0")
    env = gymnasium.make("kestrel/Landing-v0", observation="image", render_mode="rgb_array")
    envs = gymnasium.make_vec("kestrel/Hover-v0", num_envs=8, vectorization_mode="async")  # a process each

Without Gymnasium, kestrel.gym.make() and the classes give the same environments; nothing wraps them then.

Arguments of each environment:
  observation  "state" (default): a vector, see Flight. "image": what the camera sees, (height, width, 1 or 3), uint8,
               of three channels RGB. "both": a dict of both.
  action       "velocity" (default): forward, right, down in the heading frame and yaw rate. Each is from -1 to 1, as a
               share of the environment's `limits`. A step is one image of the camera (0.05 s at the usual 20 Hz).
               "rates" (Hover, "state" alone): roll, pitch and yaw rate, and thrust from -1 (none) to 1 (all). A step is
               0.01 s.
  render_mode  None or "rgb_array": render() returns the last image of the camera, (height, width, 3).
  duration_s   when an episode is truncated; None: after the environment's `duration_s`.
  overrides    of the scenario, such as {"wind.mean_m_s": 5}.

reset(seed=7) begins the flight that `kestrel run SCENARIO --seed 7` flies; without a seed the next is drawn. The same
seed and actions give the same observations and rewards, in any process.

info has always: t, seed, truth (position, velocity, attitude as w, x, y, z) and estimate (the same by the autopilot);
and with the last step: outcome and metrics, as in the summary of a run.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import kestrel

try:
    import gymnasium
    from gymnasium import Env
    from gymnasium.spaces import Box, Dict
except ImportError:  # Debian 12 has no Gymnasium
    gymnasium = None
    from kestrel._environment import Box, Dict, Env

_RATE_LIMITS = np.array([3.0, 3.0, 1.5])  # rad/s
_RATE_STEP_S = 0.01


class Flight(Env):
    """What the environments share. The state is the truth, as a perfect observer of aircraft and goal has it (float32):

        0..2    from the aircraft to its goal, in the heading frame: forward, right, down, in m
        3..5    velocity, in the heading frame, in m/s
        6..8    roll, pitch, and by how much the goal's heading is to the right, in rad
        9..11   body rates, in rad/s
        12..    of each other thing in the air: where it is from the aircraft, and its velocity less the aircraft's, in
                the heading frame

    The goal is what the environment says. Who gets farther from it than `reach_m`, or touches the ground where it must
    not, is `terminated`.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}
    scenario = ""
    duration_s = 60.0
    limits = (1.5, 1.5, 0.8, 0.7)  # of velocity setpoints: forward, right, down in m/s, yaw rate in rad/s
    reach_m = 15.0
    targets = 0
    actions: tuple[str, ...] = ("velocity",)

    def __init__(self, observation: str = "state", action: str = "velocity", render_mode: str | None = None,
                 duration_s: float | None = None, overrides: dict[str, Any] | None = None):
        if observation not in ("state", "image", "both"):
            raise ValueError(f'observation="{observation}": give "state", "image" or "both"')
        if action not in self.actions:
            raise ValueError(f'action="{action}": {type(self).__name__} has {" and ".join(self.actions)}')
        if action == "rates" and (observation != "state" or render_mode):
            raise ValueError('action="rates" needs observation="state" and no render_mode: images are not as frequent')
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f'render_mode="{render_mode}": give None or "rgb_array"')
        self.render_mode = render_mode
        self._observation, self._action = observation, action
        images = observation != "state" or render_mode is not None
        if duration_s is not None:
            self.duration_s = float(duration_s)
        overrides = {**(overrides or {}), "duration_s": self.duration_s}
        self._sim = kestrel.Sim(self.scenario, overrides=overrides, images=images, draw_beside=False)
        self._image: Any = None
        self._over = True
        self.action_space = Box(-1.0, 1.0, (4,), np.float32)
        own, each_target = [100.0] * 3 + [20.0] * 3 + [np.pi] * 3 + [35.0] * 3, [200.0] * 3 + [40.0] * 3
        bound = np.array(own + each_target * self.targets, np.float32)
        state = Box(-bound, bound, bound.shape, np.float32)
        if observation == "state":
            self.observation_space = state
        else:
            self._look(self._sim.reset()[0])  # the image's size is the camera's
            image = Box(0, 255, self._image.shape, np.uint8)
            self.observation_space = image if observation == "image" else Dict({"image": image, "state": state})

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        super().reset(seed=seed)
        self._seed = int(seed) if seed is not None else int(self.np_random.integers(2**31))
        frame, state = self._sim.reset(seed=self._seed)
        self._look(frame)
        self._over = False
        self._begin(self._sim.truth)
        return self._observe(), self._info(state)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        if self._over:
            raise kestrel.SimError("a step before reset() or after the end of an episode: call reset() first")
        before_s = self._sim.t
        if self._action == "rates":
            frame, state = self._sim.advance(_RATE_STEP_S, self._setpoint(action))
        else:
            frame, state = self._sim.step(self._setpoint(action))
        self._look(frame)
        reward, terminated, outcome = self._judge(self._sim.truth, self._sim.t - before_s)
        truncated = self._sim.done and not terminated
        self._over = terminated or truncated
        if terminated and not self._sim.done:
            self._sim.finish(outcome)
        info = self._info(state)
        if self._over:
            info["outcome"] = outcome if terminated else self._sim.outcome
            info["metrics"] = dict(self._sim.summary()["metrics"])
        return self._observe(), float(reward), terminated, truncated, info

    def render(self) -> np.ndarray | None:
        if self.render_mode is None or self._image is None:
            return None
        return np.repeat(self._image, 3, axis=2) if self._image.shape[2] == 1 else self._image.copy()

    def _setpoint(self, action):
        action = np.asarray(action, np.float64)
        if action.shape != (4,) or not np.all(np.isfinite(action)):
            raise ValueError(f"an action is four finite numbers from -1 to 1, and not {action}")
        action = np.clip(action, -1, 1)
        if self._action == "rates":
            return kestrel.Rates(*(action[:3] * _RATE_LIMITS), thrust=(action[3] + 1) / 2)
        return kestrel.Velocity(*(action * self.limits))

    def _look(self, frame):
        if frame is None or frame.image is None:
            return
        image = frame.image
        self._image = image[:, :, None] if image.ndim == 2 else np.ascontiguousarray(image[:, :, ::-1])

    def _observe(self):
        if self._observation == "state":
            return self._state(self._sim.truth)
        image = self._image.copy()
        return image if self._observation == "image" else {"image": image, "state": self._state(self._sim.truth)}

    def _state(self, truth):
        R, yaw = truth.rotation, truth.yaw
        roll, pitch = np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(np.clip(R[2, 0], -1, 1))
        c, s = np.cos(yaw), np.sin(yaw)
        to_heading = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        goal, goal_yaw = self._goal(truth)
        angles = [roll, pitch, _turn(yaw, goal_yaw)]
        parts = [to_heading @ (goal - truth.position), to_heading @ truth.velocity, angles, truth.rates]
        for target in truth.targets[:self.targets]:
            parts += [to_heading @ (target.position - truth.position), to_heading @ (target.velocity - truth.velocity)]
        space = self.observation_space if self._observation == "state" else self.observation_space["state"]
        return np.clip(np.concatenate(parts).astype(np.float32), space.low, space.high)

    def _info(self, state):
        truth = self._sim.truth
        return {
            "t": self._sim.t,
            "seed": self._seed,
            "truth": {"position": np.array(truth.position), "velocity": np.array(truth.velocity),
                      "attitude": np.array(truth.attitude)},
            "estimate": {"position": np.array(state.position), "velocity": np.array(state.velocity),
                         "attitude": np.array(state.attitude)},
        }

    def _begin(self, truth):
        """Called at the beginning of each episode."""

    def _goal(self, truth):
        """The goal in the frame N, m, and its heading, rad."""
        raise NotImplementedError

    def _judge(self, truth, dt_s):
        """Reward of a step of dt_s, terminated, and why."""
        raise NotImplementedError

    def _keep(self, truth, dt_s):
        """For who is to stay at a goal: the distance from it and a fifth of the turn to its heading, times the time, as
        a cost. Who crashes pays as if it were at reach_m until the end."""
        goal, goal_yaw = self._goal(truth)
        distance = np.linalg.norm(goal - truth.position)
        turn = abs(_turn(truth.yaw, goal_yaw))
        cost = (distance + turn / 5) * dt_s
        if truth.touching or distance > self.reach_m:
            left_s = max(self.duration_s - self._sim.t, 0)
            return -cost - self.reach_m * left_s, True, "crashed" if truth.touching else "left"
        return -cost, False, ""


def _turn(from_yaw, to_yaw):
    return (to_yaw - from_yaw + np.pi) % (2 * np.pi) - np.pi


def _pad(truth):
    return np.array(truth.pad_position), np.arctan2(truth.pad_rotation[1, 0], truth.pad_rotation[0, 0])


class Hover(Flight):
    """Hovers 3 m above the pad, in the pad's heading, from about 6 m in wind (scenario `hover`, 45 s).

    Reward of a step: -(distance from the goal in m + turn / 5) * time in s."""

    scenario = "hover"
    duration_s = 45.0
    actions = ("velocity", "rates")

    def _goal(self, truth):
        pad, yaw = _pad(truth)
        return pad - [0, 0, 3], yaw

    def _judge(self, truth, dt_s):
        return self._keep(truth, dt_s)


class Landing(Flight):
    """Lands on the pad from about 5 m in wind (scenario `landing`, 60 s). The goal is the pad.

    Reward of a step: by how many m it has come nearer to the pad. The first touch ends the episode, with 10, less 10
    for each metre from the pad's centre, less 10 for each m/s beyond the 0.4 m/s of the scenario's criterion; at the
    least -10. Who leaves gets -10."""

    scenario = "landing"

    def _begin(self, truth):
        self._distance_m = np.linalg.norm(self._goal(truth)[0] - truth.position)

    def _goal(self, truth):
        return _pad(truth)

    def _judge(self, truth, dt_s):
        distance = np.linalg.norm(self._goal(truth)[0] - truth.position)
        nearer, self._distance_m = self._distance_m - distance, distance
        if truth.touching:
            touch = self._sim.summary()["metrics"]
            score = 10 - 10 * touch["touchdown_error_m"] - 10 * max(touch["touchdown_sink_m_s"] - 0.4, 0)
            return nearer + max(score, -10), True, "landed"
        if distance > self.reach_m:
            return nearer - 10, True, "left"
        return nearer, False, ""


class Following(Flight):
    """Follows a balloon on a random path in wind (scenario `follow`, 60 s). The goal is 4 m before the balloon on the
    way to it, with the nose to it; the observation has the balloon too.

    Reward of a step: -(distance from the goal in m + turn / 5) * time in s."""

    scenario = "follow"
    limits = (3.0, 3.0, 1.5, 1.0)
    targets = 1

    def _goal(self, truth):
        way = truth.targets[0].position - truth.position
        yaw = np.arctan2(way[1], way[0])
        return truth.targets[0].position - 4 * np.array([np.cos(yaw), np.sin(yaw), 0]), yaw

    def _judge(self, truth, dt_s):
        return self._keep(truth, dt_s)


class Avoiding(Flight):
    """Flies 80 m straight on past two other aircraft that cross its way (scenario `avoid`, 60 s). The goal is the end
    of that course; the observation has both of the others.

    Reward of a step: by how many m it has come nearer to the goal. Within 1 m of it the episode ends with 20 more,
    within 2 m of another aircraft with -50; so it does on the ground or far away."""

    scenario = "avoid"
    limits = (6.0, 6.0, 1.5, 1.0)
    reach_m = 120.0
    targets = 2

    def _begin(self, truth):
        self._yaw = truth.yaw
        self._end = truth.position + 80 * np.array([np.cos(self._yaw), np.sin(self._yaw), 0])
        self._distance_m = 80.0

    def _goal(self, truth):
        return self._end, self._yaw

    def _judge(self, truth, dt_s):
        distance = np.linalg.norm(self._end - truth.position)
        nearer, self._distance_m = self._distance_m - distance, distance
        if min(np.linalg.norm(target.position - truth.position) for target in truth.targets) < 2:
            return nearer - 50, True, "too near"
        if truth.touching or distance > self.reach_m:
            return nearer - 50, True, "crashed" if truth.touching else "left"
        if distance < 1:
            return nearer + 20, True, "arrived"
        return nearer, False, ""


ENVIRONMENTS = {f"kestrel/{flight.__name__}-v0": flight for flight in (Hover, Landing, Following, Avoiding)}


def make(id: str, **arguments: Any) -> Flight:
    """The environment of that name, bare: what gymnasium.make() does without its wrappers, and without Gymnasium."""
    if id not in ENVIRONMENTS:
        raise ValueError(f'no environment is named "{id}": there are {", ".join(ENVIRONMENTS)}')
    return ENVIRONMENTS[id](**arguments)


if gymnasium is not None:
    for _id, _flight in ENVIRONMENTS.items():
        gymnasium.register(_id, entry_point=f"kestrel.gym:{_flight.__name__}")
