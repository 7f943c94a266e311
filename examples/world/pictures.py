# SPDX-License-Identifier: Apache-2.0
"""Pictures of walls, roofs, leaves and grounds that repeat, blue green red, from a seed."""
import cv2
import numpy as np


def noise(size, power, seed):
    """Mean 0, deviation 1, amplitude 1/f^power: joins at its edges."""
    rng = np.random.default_rng(seed)
    f = np.hypot(*np.meshgrid(np.fft.fftfreq(size), np.fft.fftfreq(size)))
    f[0, 0] = 1
    x = np.fft.ifft2(np.fft.fft2(rng.standard_normal((size, size))) / f**power).real
    return (x - x.mean()) / x.std()


def picture(rgb, shade):
    """A colour times 1 + shade."""
    out = np.asarray(rgb[::-1])[None, None] * 255 * (1 + shade[..., None])
    return np.ascontiguousarray(np.clip(out, 0, 255).astype(np.uint8))


def mixed(a, b, share):
    return (a * (1 - share[..., None]) + b * share[..., None]).astype(np.uint8)


def grass(size=1024):
    fine, clump = noise(size, 0.45, 1), noise(size, 1.0, 2)
    base = picture((0.33, 0.43, 0.17), 0.17 * fine)
    dry = picture((0.47, 0.47, 0.24), 0.15 * fine)
    return mixed(base, dry, np.clip(0.35 + 0.16 * clump, 0, 1))


def gravel(size=512):
    return picture((0.60, 0.55, 0.47), 0.15 * noise(size, 0.35, 3) + 0.05 * noise(size, 1.2, 4))


def asphalt(size=512):
    return picture((0.29, 0.29, 0.31), 0.12 * noise(size, 0.2, 5) + 0.06 * noise(size, 1.4, 6))


def plaster(size=256):
    return picture((0.90, 0.87, 0.80), 0.03 * noise(size, 0.8, 7))


def bark(size=128):
    x = noise(size, 0.9, 8)
    return picture((0.34, 0.27, 0.20), 0.3 * cv2.resize(x[: size // 8], (size, size)))


def leaves(size=256, rgb=(0.25, 0.40, 0.13), seed=9):
    rng = np.random.default_rng(seed)
    out = picture(np.asarray(rgb) * 0.42, 0.1 * noise(size, 0.5, seed))
    for layer in range(3):
        for _ in range(520):
            x, y = rng.integers(0, size, 2)
            light = (0.62 + 0.22 * layer) * rng.uniform(0.75, 1.25)
            tint = np.asarray(rgb) * light * np.array([rng.uniform(0.85, 1.2), 1, rng.uniform(0.7, 1.1)])
            a, b = rng.integers(4, 9), rng.integers(2, 5)
            for dx in (-size, 0, size):
                for dy in (-size, 0, size):
                    cv2.ellipse(out, (int(x + dx), int(y + dy)), (int(a), int(b)), rng.uniform(0, 180), 0, 360,
                                tuple(float(min(255, 255 * c)) for c in tint[::-1]), -1, cv2.LINE_AA)
    return out


def tiles(size=256, rgb=(0.62, 0.30, 0.21)):
    """Two metres of a roof: ten rows of eight tiles."""
    rng = np.random.default_rng(10)
    out = np.zeros((size, size, 3), np.uint8)
    rows, columns = 10, 8
    y, x = np.mgrid[0:size, 0:size] / size
    row = np.floor(y * rows).astype(int)
    column = np.floor(x * columns + 0.5 * (row % 2)).astype(int) % columns
    tone = rng.uniform(0.82, 1.12, (rows, columns))[row, column]
    u, v = (x * columns + 0.5 * (row % 2)) % 1, (y * rows) % 1
    shade = tone * (0.72 + 0.34 * np.sin(np.pi * u)) * np.where(v > 0.86, 0.6, 0.92 + 0.12 * v) - 1
    out[:] = picture(rgb, shade + 0.04 * noise(size, 0.6, 11))
    return out


def planks(size=256, rgb=(0.52, 0.38, 0.25), count=8):
    x = np.arange(size) / size
    edge = np.where((x * count) % 1 < 0.06, -0.45, 0)
    tone = np.random.default_rng(12).uniform(-0.12, 0.12, count)[(x * count).astype(int)]
    grain = cv2.resize(noise(size, 0.6, 13)[: size // 16], (size, size), interpolation=cv2.INTER_LINEAR)
    return picture(rgb, (edge + tone)[None, :] + 0.08 * grain)


def metal(size=256):
    """Four metres of corrugated sheet."""
    x = np.arange(size) / size
    return picture((0.66, 0.70, 0.74), (0.13 * np.sin(2 * np.pi * 24 * x))[None, :] + 0.03 * noise(size, 1.2, 14))


def bay(door=False, timber=False, size=256):
    """Three metres of a wall, one storey high, with a window or a door."""
    out = plaster(size)
    k = size / 3.0

    def rectangle(x, y, w, h, rgb):
        cv2.rectangle(out, (round(x * k), round(y * k)), (round((x + w) * k) - 1, round((y + h) * k) - 1),
                      tuple(255 * c for c in rgb[::-1]), -1)

    if timber:
        for x, y, w, h in ((0, 0, 3, .16), (0, 2.84, 3, .16), (0, 0, .16, 3), (2.84, 0, .16, 3), (0.16, 1.9, 2.7, .12)):
            rectangle(x, y, w, h, (0.30, 0.21, 0.15))
        for a, b in (((0.1, 2.9), (0.8, 2.0)), ((2.9, 2.9), (2.2, 2.0))):
            cv2.line(out, tuple(round(c * k) for c in a), tuple(round(c * k) for c in b), (38, 54, 77), round(.12 * k))
    if door:
        rectangle(0.95, 0.75, 1.1, 2.25, (0.93, 0.91, 0.86))
        rectangle(1.02, 0.82, 0.96, 2.18, (0.27, 0.36, 0.30))
        for y in (1.0, 1.7, 2.35):
            rectangle(1.15, y, 0.7, 0.5, (0.22, 0.30, 0.25))
    else:
        rectangle(0.85, 0.70, 1.3, 1.35, (0.95, 0.94, 0.91))
        glass = np.linspace(0.55, 0.20, 100)
        for i, g in enumerate(glass):
            rectangle(0.93, 0.78 + 1.19 * i / 100, 1.14, 0.02, (g * 0.75, g * 0.88, g))
        rectangle(0.97, 0.80, 0.24, 1.13, (0.80, 0.76, 0.70))
        rectangle(1.79, 0.80, 0.24, 1.13, (0.80, 0.76, 0.70))
        rectangle(1.47, 0.78, 0.06, 1.19, (0.95, 0.94, 0.91))
        rectangle(0.93, 1.15, 1.14, 0.05, (0.95, 0.94, 0.91))
        rectangle(0.78, 2.05, 1.44, 0.09, (0.62, 0.60, 0.57))
        for x in (0.45, 2.18):
            rectangle(x, 0.72, 0.37, 1.32, (0.25, 0.38, 0.31))
            for y in np.arange(0.80, 2.0, 0.12):
                rectangle(x + 0.04, y, 0.29, 0.03, (0.18, 0.29, 0.23))
    return out
