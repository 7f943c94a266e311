# SPDX-License-Identifier: Apache-2.0
"""Meshes with pictures as glTF binary, from numpy alone: y up, z to the north, x to the west."""
import json
import struct

import cv2
import numpy as np


class Model:
    """Triangles by material, each with a picture that may repeat."""

    def __init__(self):
        self.materials = {}

    def material(self, name, picture=None, colour=(1, 1, 1), both_sides=False):
        self.materials[name] = dict(picture=picture, colour=colour, both=both_sides, p=[], n=[], t=[], i=[])
        return name

    def add(self, material, points, normals, st, faces):
        m = self.materials[material]
        first = sum(len(p) for p in m['p'])
        m['p'].append(np.asarray(points, np.float32))
        m['n'].append(np.asarray(normals, np.float32))
        m['t'].append(np.asarray(st, np.float32))
        m['i'].append(np.asarray(faces, np.uint32) + first)

    def quad(self, material, a, b, c, d, repeat=(1, 1), at=(0, 0)):
        """Corners from the lower left on, against the clock as seen; repeat: of the picture along and up."""
        a, b, c, d = (np.asarray(x, float) for x in (a, b, c, d))
        n = np.cross(b - a, d - a)
        n = n / np.linalg.norm(n)
        u, v = repeat
        s, t = at
        self.add(material, [a, b, c, d], [n] * 4, [[s, t + v], [s + u, t + v], [s + u, t], [s, t]],
                 [[0, 1, 2], [0, 2, 3]])

    def triangle(self, material, a, b, c, metres=3.0):
        a, b, c = (np.asarray(x, float) for x in (a, b, c))
        n = np.cross(b - a, c - a)
        along = (b - a) / np.linalg.norm(b - a)
        up = np.cross(n / np.linalg.norm(n), along)
        st = [[(p - a) @ along / metres, -((p - a) @ up) / metres] for p in (a, b, c)]
        self.add(material, [a, b, c], [n / np.linalg.norm(n)] * 3, st, [[0, 1, 2]])

    def box(self, material, low, high, metres=1.0):
        (x0, y0, z0), (x1, y1, z1) = low, high
        w, h, d = (x1 - x0) / metres, (y1 - y0) / metres, (z1 - z0) / metres
        self.quad(material, (x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1), (w, h))
        self.quad(material, (x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0), (w, h))
        self.quad(material, (x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (d, h))
        self.quad(material, (x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0), (d, h))
        self.quad(material, (x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0), (w, d))

    def write(self, file):
        blob, views, accessors, primitives, materials = b'', [], [], [], []
        images, seen = [], {}

        def view(data):
            nonlocal blob
            views.append(dict(buffer=0, byteOffset=len(blob), byteLength=len(data)))
            blob += data + b'\0' * (-len(data) % 4)
            return len(views) - 1

        def accessor(array, kind, component):
            a = dict(bufferView=view(array.tobytes()), componentType=component, count=len(array), type=kind)
            if kind == 'SCALAR':
                a['count'] = array.size
            if kind == 'VEC3':
                a.update(min=array.min(0).tolist(), max=array.max(0).tolist())
            accessors.append(a)
            return len(accessors) - 1

        for name, m in self.materials.items():
            if not m['p']:
                continue
            p, n, t, i = (np.concatenate(m[k]) for k in 'pnti')
            i = i.astype(np.uint16) if len(p) < 65536 else i
            linear = [float(c) ** 2.2 for c in m['colour']]
            pbr = dict(baseColorFactor=linear + [1.0], metallicFactor=0, roughnessFactor=1)
            if m['picture'] is not None:
                key = id(m['picture'])
                if key not in seen:
                    seen[key] = len(images)
                    jpeg = cv2.imencode('.jpg', m['picture'], [cv2.IMWRITE_JPEG_QUALITY, 82])[1].tobytes()
                    images.append(dict(bufferView=view(jpeg), mimeType='image/jpeg'))
                pbr['baseColorTexture'] = dict(index=seen[key])
            materials.append(dict(name=name, doubleSided=m['both'], pbrMetallicRoughness=pbr))
            primitives.append(dict(
                attributes=dict(POSITION=accessor(p, 'VEC3', 5126), NORMAL=accessor(n, 'VEC3', 5126),
                                TEXCOORD_0=accessor(t, 'VEC2', 5126)),
                indices=accessor(i.reshape(-1), 'SCALAR', 5123 if i.dtype == np.uint16 else 5125),
                material=len(materials) - 1))
        gltf = dict(asset=dict(version='2.0', generator='examples/world', copyright='Apache-2.0'), scene=0,
                    scenes=[dict(nodes=[0])], nodes=[dict(mesh=0)], meshes=[dict(primitives=primitives)],
                    materials=materials, accessors=accessors, bufferViews=views, buffers=[dict(byteLength=len(blob))])
        if images:
            gltf.update(images=images, textures=[dict(source=k) for k in range(len(images))])
        text = json.dumps(gltf, separators=(',', ':')).encode()
        text += b' ' * (-len(text) % 4)
        with open(file, 'wb') as out:
            out.write(struct.pack('<4sII', b'glTF', 2, 28 + len(text) + len(blob)))
            out.write(struct.pack('<I4s', len(text), b'JSON') + text)
            out.write(struct.pack('<I4s', len(blob), b'BIN\0') + blob)
