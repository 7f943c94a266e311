# SPDX-License-Identifier: Apache-2.0
"""The little of Gymnasium that the environments of kestrel.gym need, for where it is not installed.

Names, arguments and behaviour are Gymnasium's, as far as they are here."""

import numpy as np


class Box:
    """Arrays of one shape and type between low and high, which are numbers or arrays."""

    def __init__(self, low, high, shape=None, dtype=np.float32, seed=None):
        self.dtype = np.dtype(dtype)
        self.shape = tuple(shape) if shape is not None else np.shape(low)
        self.low = np.full(self.shape, low, self.dtype)
        self.high = np.full(self.shape, high, self.dtype)
        self.seed(seed)

    def seed(self, seed=None):
        self._np_random = np.random.default_rng(seed)

    def sample(self):
        """An array, drawn evenly."""
        if self.dtype.kind == "f":
            return self._np_random.uniform(self.low, self.high).astype(self.dtype)
        return self._np_random.integers(self.low, self.high, dtype=self.dtype, endpoint=True)

    def contains(self, x):
        return (isinstance(x, np.ndarray) and np.can_cast(x.dtype, self.dtype) and x.shape == self.shape
                and bool(np.all(x >= self.low)) and bool(np.all(x <= self.high)))

    __contains__ = contains


class Dict:
    """Several spaces by name."""

    def __init__(self, spaces):
        self.spaces = dict(spaces)

    def __getitem__(self, key):
        return self.spaces[key]

    def sample(self):
        return {key: space.sample() for key, space in self.spaces.items()}

    def contains(self, x):
        return (isinstance(x, dict) and x.keys() == self.spaces.keys()
                and all(x[key] in space for key, space in self.spaces.items()))

    __contains__ = contains


class Env:
    """An environment with random numbers of its own, which reset() seeds."""

    metadata: dict = {"render_modes": []}
    render_mode = None
    spec = None
    _np_random = None

    @property
    def np_random(self):
        if self._np_random is None:
            self._np_random = np.random.default_rng()
        return self._np_random

    @property
    def unwrapped(self):
        return self

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            self._np_random = np.random.default_rng(seed)

    def close(self):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.close()
