# SPDX-License-Identifier: Apache-2.0
"""What Gymnasium's documentation asks of an environment and its spaces, checked without it."""

import copy
import inspect

import numpy as np


def same(a, b):
    """Whether two observations are the same, bit for bit."""
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return a.dtype == b.dtype and np.array_equal(a, b)


def check_spaces(env):
    action = env.action_space
    assert action.shape == action.low.shape == action.high.shape
    assert np.all(action.low == -1) and np.all(action.high == 1), "actions are normalised"
    spaces = getattr(env.observation_space, "spaces", {"": env.observation_space})
    for space in spaces.values():
        assert space.shape == space.low.shape == space.high.shape
        assert np.all(space.low < space.high)
        assert np.all(np.isfinite(np.asarray(space.low, float))) and np.all(np.isfinite(np.asarray(space.high, float)))
        assert space.sample() in space


def check_reset(env):
    parameters = inspect.signature(env.reset).parameters
    for name in ("seed", "options"):
        assert parameters[name].kind is inspect.Parameter.KEYWORD_ONLY and parameters[name].default is None
    first, info = env.reset(seed=123)
    assert first in env.observation_space and isinstance(info, dict)
    drawn = env.np_random.bit_generator.state
    again, _ = env.reset(seed=123)
    assert same(first, again), "the same seed gives the same first observation"
    assert env.np_random.bit_generator.state == drawn, "the seed seeds np_random"
    other, _ = env.reset(seed=456)
    assert not same(first, other) and env.np_random.bit_generator.state != drawn
    unseeded, _ = env.reset(options={})
    assert unseeded in env.observation_space
    assert not same(other, unseeded), "without a seed each episode is another"


def check_step(env):
    env.reset(seed=1)
    result = env.step(env.action_space.sample())
    assert isinstance(result, tuple) and len(result) == 5
    observation, reward, terminated, truncated, info = result
    assert observation in env.observation_space
    assert isinstance(reward, float) and np.isfinite(reward)
    assert type(terminated) is bool and type(truncated) is bool and isinstance(info, dict)
    kept = copy.deepcopy(observation)
    env.step(env.action_space.sample())
    assert same(kept, observation), "an observation that was given does not change"


def check_render(env):
    assert env.metadata["render_modes"] == ["rgb_array"] and env.metadata["render_fps"] > 0
    assert env.render_mode in (None, *env.metadata["render_modes"])
    if env.render_mode:
        image = env.render()
        assert image.dtype == np.uint8 and image.ndim == 3 and image.shape[2] == 3


def check(env):
    assert env.unwrapped is env
    check_spaces(env)
    check_reset(env)
    check_step(env)
    check_render(env)
    env.close()
    env.close()
