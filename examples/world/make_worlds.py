# SPDX-License-Identifier: Apache-2.0
"""Makes the meshes of models/worlds/village: python3 make_worlds.py FOLDER."""
import pathlib
import sys

import numpy as np

import pictures
from meshes import Model


def house(file, length, width, storeys, wall=(1, 1, 1), timber=False, roof=(0.62, 0.30, 0.21)):
    """Its ridge along x, its door to the north."""
    m = Model()
    m.material('windows', pictures.bay(timber=timber), wall)
    m.material('door', pictures.bay(door=True, timber=timber), wall)
    m.material('wall', pictures.plaster(), wall)
    m.material('roof', pictures.tiles(rgb=roof))
    m.material('stone', pictures.gravel(256), (0.85, 0.85, 0.85))
    m.material('wood', pictures.planks(128), (0.8, 0.8, 0.8))
    storey, l, w = 2.8, length / 2, width / 2
    top, ridge = storey * storeys + 0.3, storey * storeys + 0.3 + 0.48 * width
    m.box('stone', (-l - 0.05, -0.5, -w - 0.05), (l + 0.05, 0.3, w + 0.05), 3)
    for s in range(storeys):
        y0, y1 = 0.3 + storey * s, 0.3 + storey * (s + 1)
        bays, ends = max(2, round(length / 3)), max(1, round(width / 3.3))
        for k in range(bays):
            a, b = -l + length * k / bays, -l + length * (k + 1) / bays
            name = 'door' if s == 0 and k == bays // 2 else 'windows'
            m.quad(name, (a, y0, w), (b, y0, w), (b, y1, w), (a, y1, w))
            m.quad('windows', (-a, y0, -w), (-b, y0, -w), (-b, y1, -w), (-a, y1, -w))
        for k in range(ends):
            a, b = w - width * k / ends, w - width * (k + 1) / ends
            m.quad('windows', (l, y0, a), (l, y0, b), (l, y1, b), (l, y1, a))
            m.quad('windows', (-l, y0, -a), (-l, y0, -b), (-l, y1, -b), (-l, y1, -a))
    m.triangle('wall', (l, top, w), (l, top, -w), (l, ridge, 0))
    m.triangle('wall', (-l, top, -w), (-l, top, w), (-l, ridge, 0))
    o, t = 0.55, 0.18  # how far the roof reaches over, how thick it is
    drop = o * 0.48 * 2
    for side in (1, -1):
        ll = l + o
        low, high = np.array([0, top - drop + 0.1, side * (w + o)]), np.array([0, ridge + 0.1, 0])
        a, b = (-ll, ll) if side > 0 else (ll, -ll)
        x = np.array([1, 0, 0])
        down = np.array([0, t, 0])
        slope = np.linalg.norm(high - low)
        m.quad('roof', low + a * x, low + b * x, high + b * x, high + a * x, (2 * ll / 2, slope / 2))
        m.quad('wood', low + b * x - down, low + a * x - down, high + a * x - down, high + b * x - down, (4, 2))
        m.quad('wood', low + a * x - down, low + b * x - down, low + b * x, low + a * x, (8, 0.2))
        m.quad('wood', low + b * x - down, high + b * x - down, high + b * x, low + b * x, (3, 0.2))
        m.quad('wood', high + a * x - down, low + a * x - down, low + a * x, high + a * x, (3, 0.2))
    m.box('stone', (0.3 * l, ridge - 1.4, 0.3), (0.3 * l + 0.7, ridge + 0.9, 1.0), 3)
    m.write(file)


def church(file):
    m = Model()
    m.material('wall', pictures.plaster(), (0.97, 0.95, 0.90))
    m.material('roof', pictures.tiles(rgb=(0.33, 0.35, 0.40)))
    m.material('glass', None, (0.22, 0.28, 0.36))
    m.material('stone', pictures.gravel(256), (0.8, 0.8, 0.82))
    m.material('wood', pictures.planks(128), (0.6, 0.55, 0.5))
    m.box('wall', (-9, 0, -4.5), (9, 7, 4.5), 3)
    m.box('stone', (-9.1, -0.5, -4.6), (9.1, 0.6, 4.6), 3)
    for side in (1, -1):
        a, b = (-9.5, 9.5) if side > 0 else (9.5, -9.5)
        m.quad('roof', (a, 6.7, side * 5.1), (b, 6.7, side * 5.1), (b, 12, 0), (a, 12, 0), (9.5, 4))
        m.quad('wood', (b, 6.6, side * 5.1), (a, 6.6, side * 5.1), (a, 11.9, 0), (b, 11.9, 0), (9.5, 4))
        for x in (-6, -2, 2, 6):
            z = side * 4.52
            p, q = (x - 0.6, x + 0.6) if side > 0 else (x + 0.6, x - 0.6)
            m.quad('glass', (p, 2, z), (q, 2, z), (q, 5, z), (p, 5, z))
            m.triangle('glass', (p, 5, z), (q, 5, z), (x, 6, z))
    m.triangle('wall', (-9, 7, -4.5), (-9, 7, 4.5), (-9, 11.8, 0))
    m.triangle('wall', (9, 7, 4.5), (9, 7, -4.5), (9, 11.8, 0))
    m.box('wall', (9, 0, -2.5), (14, 17, 2.5), 3)
    m.box('stone', (8.9, -0.5, -2.6), (14.1, 0.8, 2.6), 3)
    m.box('stone', (8.85, 12.5, -2.65), (14.15, 12.8, 2.65), 3)
    corners = [(8.7, 17, 2.8), (14.3, 17, 2.8), (14.3, 17, -2.8), (8.7, 17, -2.8)]
    for k in range(4):
        m.triangle('roof', corners[k], corners[(k + 1) % 4], (11.5, 27, 0), 2)
    for n in ((0, 1), (0, -1), (1, 0)):
        for y in (8.0, 13.6):
            c = np.array([11.5 + 2.52 * n[0], y, 2.52 * n[1]])
            t = np.array([n[1], 0, -n[0]])
            up = np.array([0, 2.0, 0])
            m.quad('glass', c - 0.5 * t, c + 0.5 * t, c + 0.5 * t + up, c - 0.5 * t + up)
    m.quad('wood', (14.02, 0.8, 0.8), (14.02, 0.8, -0.8), (14.02, 3.4, -0.8), (14.02, 3.4, 0.8))
    m.write(file)


def ball(m, material, centre, radii, seed, bands=9, around=14, repeat=2.0):
    """A rough ball of leaves, its normals smooth."""
    rng = np.random.default_rng(seed)
    bumps = rng.uniform(0.86, 1.1, (bands + 1, around))
    bumps[0], bumps[-1] = 1, 1
    points, normals, st = [], [], []
    for i in range(bands + 1):
        for j in range(around + 1):
            polar, turn = np.pi * i / bands, 2 * np.pi * j / around
            n = np.array([np.sin(polar) * np.cos(turn), np.cos(polar), np.sin(polar) * np.sin(turn)])
            points.append(np.asarray(centre) + bumps[i, j % around] * n * radii)
            normals.append(n / np.asarray(radii) / np.linalg.norm(n / np.asarray(radii)))
            st.append([repeat * 2 * j / around, repeat * i / bands])
    w = around + 1
    faces = []
    for i in range(bands):
        for j in range(around):
            a, b, c, d = i * w + j, i * w + j + 1, (i + 1) * w + j, (i + 1) * w + j + 1
            faces += [[a, b, c], [b, d, c]]
    m.add(material, points, normals, st, faces)


def trunk(m, material, base, tip, r0, r1, around=8):
    base, tip = np.asarray(base, float), np.asarray(tip, float)
    axis = (tip - base) / np.linalg.norm(tip - base)
    u = np.cross(axis, [0.3, 0.1, 1])
    u /= np.linalg.norm(u)
    v = np.cross(axis, u)
    points, normals, st, faces = [], [], [], []
    for j in range(around + 1):
        n = u * np.cos(2 * np.pi * j / around) + v * np.sin(2 * np.pi * j / around)
        points += [base + r0 * n, tip + r1 * n]
        normals += [n, n]
        st += [[j / around, 0], [j / around, 2]]
    for j in range(around):
        a = 2 * j
        faces += [[a, a + 1, a + 2], [a + 1, a + 3, a + 2]]
    m.add(material, points, normals, st, faces)


def tree(file, height, seed, rgb):
    rng = np.random.default_rng(seed)
    m = Model()
    m.material('bark', pictures.bark(), both_sides=True)
    m.material('leaves', pictures.leaves(rgb=rgb, seed=seed))
    crown = 0.36 * height
    trunk(m, 'bark', (0, -0.3, 0), (0, 0.55 * height, 0), 0.035 * height, 0.018 * height)
    ball(m, 'leaves', (0, 0.66 * height, 0), np.array([0.62, 0.72, 0.62]) * crown, seed)
    for k in range(8):
        turn, up = 2.4 * k + rng.uniform(-0.3, 0.3), rng.uniform(0.46, 0.84)
        out = crown * (0.62 if up < 0.7 else 0.38)
        c = (out * np.cos(turn), up * height, out * np.sin(turn))
        trunk(m, 'bark', (0, 0.36 * height, 0), c, 0.013 * height, 0.004 * height, 5)
        r = crown * rng.uniform(0.38, 0.5)
        ball(m, 'leaves', c, np.array([r, 0.85 * r, r]), seed + k + 1, 7, 11, 1.5)
    m.write(file)


def conifer(file, height, seed):
    rng = np.random.default_rng(seed)
    m = Model()
    m.material('bark', pictures.bark(), both_sides=True)
    m.material('needles', pictures.leaves(rgb=(0.15, 0.28, 0.14), seed=seed), both_sides=True)
    trunk(m, 'bark', (0, -0.3, 0), (0, 0.9 * height, 0), 0.025 * height, 0.005 * height)
    around = 22
    for k in range(9):
        share = k / 9
        y0, y1 = (0.10 + 0.78 * share) * height, (0.30 + 0.72 * share) * height
        r = 0.21 * height * (1 - share) ** 0.85 + 0.02 * height
        points, normals, st, faces = [], [], [], []
        for j in range(around + 1):
            turn = 2 * np.pi * j / around + k
            rim = r * (1.0 if j % 2 else 0.72) * (rng.uniform(0.9, 1.1) if j < around else 1)
            y = y0 - (0.03 * height if j % 2 else 0)
            n = np.array([np.cos(turn), 0.7, np.sin(turn)])
            points += [[rim * np.cos(turn), y, rim * np.sin(turn)], [0, y1, 0]]
            normals += [n / np.linalg.norm(n)] * 2
            st += [[3 * j / around, 1.2], [3 * j / around, 0]]
        points[2 * around], normals[2 * around] = points[0], normals[0]
        for j in range(around):
            faces.append([2 * j, 2 * j + 1, 2 * j + 2])
        m.add('needles', points, normals, st, faces)
    m.write(file)


def hedge_and_fence(m, a, b, kind):
    a, b = np.asarray(a, float), np.asarray(b, float)
    length = np.linalg.norm(b - a)
    x = (b - a) / length
    side = np.array([-x[2], 0, x[0]])

    def piece(material, s0, s1, low, high, half, metres):
        p = [a + x * s + side * h for s, h in ((s0, half), (s1, half), (s1, -half), (s0, -half))]
        p = [np.array([q[0], 0, q[2]]) for q in p]
        if np.cross(p[1] - p[0], [0, 1, 0]) @ (p[0] - p[3]) < 0:
            p = p[::-1]
        up0, up1 = np.array([0, low, 0]), np.array([0, high, 0])
        for k in range(4):
            q, r = p[k], p[(k + 1) % 4]
            m.quad(material, q + up0, r + up0, r + up1, q + up1,
                   (np.linalg.norm(r - q) / metres, (high - low) / metres))
        m.quad(material, p[0] + up1, p[1] + up1, p[2] + up1, p[3] + up1, ((s1 - s0) / metres, 2 * half / metres))

    if kind == 'hedge':
        return piece('leaves', 0, length, 0, 1.15, 0.4, 1.6)
    for s in np.arange(0, length + 0.01, 2.0):
        piece('wood', s - 0.06, s + 0.06, 0, 1.1, 0.06, 1)
    for y in (0.35, 0.85):
        piece('wood', 0, length, y, y + 0.09, 0.025, 1)
    for s in np.arange(0.2, length, 0.4):
        piece('wood', s - 0.05, s + 0.05, 0.12, 1.02, 0.03, 1)


def strip(m, material, line, width, height, metres):
    """A path along north, east."""
    line = np.asarray(line, float)
    sides, gone = [], 0.0
    for k, p in enumerate(line):
        d = line[min(k + 1, len(line) - 1)] - line[max(k - 1, 0)]
        d /= np.linalg.norm(d)
        if k:
            gone += np.linalg.norm(p - line[k - 1])
        across = np.array([-d[1], d[0]]) * width / 2
        sides.append((p + across, p - across, gone / metres))
    for (r0, l0, s0), (r1, l1, s1) in zip(sides, sides[1:]):
        points = [(-q[1], height, q[0]) for q in (r0, l0, l1, r1)]
        m.add(material, points, [(0, 1, 0)] * 4, [(0, s0), (width / metres, s0), (width / metres, s1), (0, s1)],
              [[0, 2, 1], [0, 3, 2]] if np.cross(np.subtract(points[1], points[0]),
                                                 np.subtract(points[2], points[0]))[1] < 0 else [[0, 1, 2], [0, 2, 3]])


def plain(m, material, low, high, height, metres):
    (n0, e0), (n1, e1) = low, high
    m.quad(material, (-e0, height, n0), (-e1, height, n0), (-e1, height, n1), (-e0, height, n1),
           ((e1 - e0) / metres, (n1 - n0) / metres))


def curve(points, steps=12):
    p = np.asarray([points[0]] + list(points) + [points[-1]], float)
    out = []
    for k in range(1, len(p) - 2):
        for t in np.arange(steps) / steps:
            a, b, c, d = p[k - 1:k + 3]
            out.append(0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3))
    return np.array(out + [p[-2]])


def village_ground(file):
    m = Model()
    m.material('grass', pictures.grass())
    m.material('gravel', pictures.gravel())
    m.material('asphalt', pictures.asphalt())
    m.material('wood', pictures.planks(128))
    m.material('leaves', pictures.leaves(rgb=(0.20, 0.36, 0.13), seed=31))
    plain(m, 'grass', (-110, -110), (110, 110), 0.006, 8)
    strip(m, 'asphalt', curve([(-110, 34), (-50, 30), (0, 33), (55, 28), (110, 40)]), 6, 0.012, 5)
    for line, width in ((curve([(8, 31), (14, 14), (11, -6), (18, -24), (40, -40), (80, -52)]), 2.2),
                        (curve([(-30, 31), (-26, 8), (-14, -12), (-20, -40), (-40, -70)]), 2.2),
                        (curve([(14, 6), (30, 4), (47, 8)]), 1.6)):
        strip(m, 'gravel', line, width, 0.009, 3)
    for n, e in ((34, 44), (6, 47), (-25, 45), (-60, 44), (62, 42)):
        strip(m, 'gravel', [(n, 33), (n, e)], 2.5, 0.010, 3)
    for a, b, kind in (((45, 39), (24, 39), 'fence'), ((16, 39), (-8, 39), 'fence'), ((-14, 39), (-34, 39), 'hedge'),
                       ((-48, 38), (-72, 38), 'fence'), ((50, 37), (75, 37), 'hedge'), ((22, -34), (27, -58), 'hedge'),
                       ((-2, -33), (-18, -36), 'fence')):
        hedge_and_fence(m, (-a[1], 0, a[0]), (-b[1], 0, b[0]), kind)
    m.write(file)


def village(folder):
    folder.mkdir(parents=True, exist_ok=True)
    village_ground(folder / 'ground.glb')
    house(folder / 'house_white.glb', 12, 8, 2)
    house(folder / 'house_timber.glb', 9, 8, 2, timber=True, roof=(0.50, 0.27, 0.20))
    house(folder / 'house_yellow.glb', 15, 9, 1, wall=(1.0, 0.90, 0.66), roof=(0.58, 0.33, 0.24))
    church(folder / 'church.glb')
    tree(folder / 'tree_oak.glb', 11, 21, (0.24, 0.38, 0.13))
    tree(folder / 'tree_lime.glb', 8, 22, (0.33, 0.46, 0.16))
    conifer(folder / 'tree_spruce.glb', 12, 23)


if __name__ == '__main__':
    village(pathlib.Path(sys.argv[1]) / 'village')
