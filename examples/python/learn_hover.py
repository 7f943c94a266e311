# SPDX-License-Identifier: Apache-2.0
"""Learns to hover over the pad from states, by a plain evolution strategy on two cores."""

import multiprocessing
import sys
import time

import kestrel.gym
import numpy as np

SECONDS = 10  # of an episode
SCALE = np.array([3, 3, 3, 1, 1, 1, 0.3, 0.3, 0.5, 1, 1, 1])  # of each number of the state, about its usual size
SIZE = 4 * 13  # a linear policy: four actions from twelve states and a constant
env = None  # of this process


def fly(weights, seed):
    """The return of an episode and its mean distance from the goal in the last half, m."""
    global env
    env = env or kestrel.gym.make("kestrel/Hover-v0", duration_s=SECONDS, overrides={"start.settle_s": 2})
    weights = weights.reshape(4, 13)
    state, info = env.reset(seed=seed)
    total, errors, over = 0.0, [], False
    while not over:
        state, reward, terminated, truncated, info = env.step(np.tanh(weights @ np.append(state / SCALE, 1)))
        total += reward
        errors.append(np.linalg.norm(state[:3]) if not terminated else env.reach_m)
        over = terminated or truncated
    return total, np.mean(errors[len(errors) // 2:])


def learn(pool, generations, offspring=24, sigma=0.3):
    random = np.random.default_rng(1)
    mean, best = np.zeros(SIZE), offspring // 4
    share = np.log(best + 0.5) - np.log(np.arange(1, best + 1))  # of each parent in the next mean
    share /= share.sum()
    for generation in range(generations):
        children = mean + sigma * random.standard_normal((offspring, SIZE))
        seed = 1000 + generation  # one wind for all of a generation
        returns = [total for total, _ in pool.starmap(fly, [(child, seed) for child in children])]
        order = np.argsort(returns)[::-1]
        mean = share @ children[order[:best]]
        sigma *= 0.98
        if generation % 20 == 19:
            print(f"generation {generation + 1}: the best return is {max(returns):.2f}")
    return mean


def error(pool, weights):
    """On ten flights that nothing was learnt on."""
    return np.mean([distance for _, distance in pool.starmap(fly, [(weights, seed) for seed in range(1, 11)])])


if __name__ == "__main__":
    began = time.monotonic()
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        learnt = learn(pool, int(sys.argv[1]) if len(sys.argv) > 1 else 100)
        print(f"{time.monotonic() - began:.0f} s of learning; mean distance from the goal after {SECONDS // 2} s: "
              f"untrained {error(pool, np.zeros(SIZE)):.2f} m, learnt {error(pool, learnt):.2f} m")
