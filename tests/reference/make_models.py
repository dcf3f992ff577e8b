#!/usr/bin/env python3
"""Makes the meshes and images of the cases with meshes: cases/models.  Needs numpy, pillow and OpenEXR.  Run it in this folder.

glass.glb    closed, normals, 3,000 triangles: a ball with lobes; a node turns and moves it
vase.obj     no normals, coordinates with a seam, 576 triangles: an open wall, to be smooth or flat
figure.ply   closed, normals, coordinates, 1,280 triangles: for pictures of variables
checks.png   8 x 8, sRGB      glow.exr   6 x 4, linear, up to 3
sky.exr      24 x 12, halves, all directions: another colour at each side, with a bright patch, nowhere black
"""
import json, math, struct
import numpy as np
import OpenEXR
from PIL import Image

FOLDER = 'cases/models/'


def ball(radius, rings, columns):
    """A closed surface of the radius radius(polar angle, longitude), +y up, front outside.
    -> positions, analytic normals, (longitude / 2 pi, polar angle / pi from the south), triangles counter-clockwise; a seam at longitude 0"""
    def point(theta, phi):
        return radius(theta, phi) * np.array((math.sin(theta) * math.sin(phi), -math.cos(theta), math.sin(theta) * math.cos(phi)))

    positions, normals, uv, triangles = [], [], [], []
    for i in range(rings + 1):
        for j in range(columns + 1):
            theta, phi, e = math.pi * i / rings, 2 * math.pi * (j % columns) / columns, 1e-6
            # the normal from differences of places nearby; at a pole it is the axis
            near = min(max(theta, 1e-3), math.pi - 1e-3)
            n = np.cross(point(near, phi + e) - point(near, phi - e), point(near + e, phi) - point(near - e, phi))
            positions.append(point(theta, phi) if 0 < i < rings else np.array((0, -math.cos(theta) * radius(theta, 0), 0)))
            normals.append(n / np.linalg.norm(n) if 0 < i < rings else np.array((0, -math.cos(theta), 0)))
            uv.append((j / columns, i / rings))
    at = lambda i, j: i * (columns + 1) + j
    for i in range(rings):
        for j in range(columns):
            if i > 0:
                triangles.append((at(i, j), at(i, j + 1), at(i + 1, j)))
            if i < rings - 1:
                triangles.append((at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)))
    return np.array(positions), np.array(normals), np.array(uv), np.array(triangles)


def check(positions, normals, triangles):
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    assert (np.linalg.norm(face, axis=1) > 1e-7).all(), 'no triangle without area'
    if normals is not None:
        assert ((face * sum(normals[triangles[:, k]] for k in range(3))).sum(axis=1) > 0).all(), 'normals on the outside'


def glass():
    positions, normals, _, triangles = ball(lambda t, p: 1 + 0.1 * math.sin(t) ** 3 * math.sin(3 * p) + 0.06 * math.cos(2 * t), 31, 50)
    check(positions, normals, triangles)
    indices = triangles.astype('<u2').tobytes()
    data = positions.astype('<f4').tobytes() + normals.astype('<f4').tobytes() + indices
    size = len(positions) * 12
    document = {
        'asset': {'version': '2.0'}, 'scene': 0, 'scenes': [{'nodes': [0]}],
        'nodes': [{'mesh': 0, 'rotation': [math.sin(0.2), 0, 0, math.cos(0.2)], 'translation': [3, 1, -2]}],
        'meshes': [{'primitives': [{'attributes': {'POSITION': 0, 'NORMAL': 1}, 'indices': 2}]}],
        'buffers': [{'byteLength': len(data)}],
        'bufferViews': [{'buffer': 0, 'byteOffset': 0, 'byteLength': size}, {'buffer': 0, 'byteOffset': size, 'byteLength': size},
                        {'buffer': 0, 'byteOffset': 2 * size, 'byteLength': len(indices)}],
        'accessors': [{'bufferView': 0, 'componentType': 5126, 'count': len(positions), 'type': 'VEC3',
                       'min': positions.astype('<f4').min(axis=0).tolist(), 'max': positions.astype('<f4').max(axis=0).tolist()},
                      {'bufferView': 1, 'componentType': 5126, 'count': len(positions), 'type': 'VEC3'},
                      {'bufferView': 2, 'componentType': 5123, 'count': 3 * len(triangles), 'type': 'SCALAR'}]}
    text = json.dumps(document, separators=(',', ':')).encode()
    text += b' ' * (-len(text) % 4)
    data += b'\0' * (-len(data) % 4)
    with open(FOLDER + 'glass.glb', 'wb') as f:
        f.write(struct.pack('<4sII', b'glTF', 2, 12 + 8 + len(text) + 8 + len(data)))
        f.write(struct.pack('<I4s', len(text), b'JSON') + text + struct.pack('<I4s', len(data), b'BIN\0') + data)


def vase():
    rings, columns = 12, 24
    with open(FOLDER + 'vase.obj', 'w') as f:
        for i in range(rings + 1):
            for j in range(columns):
                h, phi = i / rings, 2 * math.pi * j / columns
                r = 0.45 + 0.2 * math.sin(2.4 * math.pi * h + 0.4) + 0.03 * math.cos(4 * phi)
                f.write('v %.5f %.5f %.5f\n' % (r * math.sin(phi), 1.6 * h, r * math.cos(phi)))
        for i in range(rings + 1):
            for j in range(columns + 1):
                f.write('vt %.5f %.5f\n' % (2 * j / columns, 1.5 * i / rings - 0.2))
        place = lambda i, j: '%d/%d' % (i * columns + j % columns + 1, i * (columns + 1) + j + 1)
        for i in range(rings):
            for j in range(columns):
                f.write('f %s %s %s\n' % (place(i, j), place(i, j + 1), place(i + 1, j)))
                f.write('f %s %s %s\n' % (place(i, j + 1), place(i + 1, j + 1), place(i + 1, j)))


def figure():
    positions, normals, uv, triangles = ball(lambda t, p: 1 + 0.18 * math.sin(t) ** 2 * math.cos(2 * p) + 0.1 * math.cos(3 * t), 21, 32)
    check(positions, normals, triangles)
    with open(FOLDER + 'figure.ply', 'wb') as f:
        fields = ''.join('property float %s\n' % name for name in 'x y z nx ny nz s t'.split())
        f.write(('ply\nformat binary_little_endian 1.0\nelement vertex %d\n%selement face %d\nproperty list uchar ushort vertex_indices\nend_header\n'
                 % (len(positions), fields, len(triangles))).encode())
        f.write(np.hstack((positions, normals, uv)).astype('<f4').tobytes())
        for t in triangles:
            f.write(struct.pack('<B3H', 3, *t))


def images():
    random = np.random.default_rng(36)
    base = np.indices((8, 8)).sum(axis=0) % 2
    colours = np.where(base[..., None] == 1, (214, 150, 92), (60, 88, 132)) + random.integers(-40, 41, (8, 8, 3))
    Image.fromarray(colours.clip(0, 255).astype(np.uint8)).save(FOLDER + 'checks.png')
    glow = (random.random((4, 6, 3)) * 0.9).astype(np.float32)
    glow[1, 2] = (3, 2.5, 1)
    glow[3, 5] = (0.25, 1.5, 2)
    header = {'compression': OpenEXR.ZIP_COMPRESSION, 'type': OpenEXR.scanlineimage}
    OpenEXR.File(header, {c: glow[..., k].copy() for k, c in enumerate('RGB')}).write(FOLDER + 'glow.exr')


def sky():
    """Blue on top, brown below, red towards +z (the middle), green towards +x (left of it); a lamp high at the right, with a tail to the left."""
    j, i = np.meshgrid(np.arange(12), np.arange(24), indexing='ij')
    lat, lon = math.pi / 2 - (j + 0.5) / 12 * math.pi, (0.5 - (i + 0.5) / 24) * 2 * math.pi
    x, y, z = np.cos(lat) * np.sin(lon), np.sin(lat), np.cos(lat) * np.cos(lon)
    map_ = 0.25 + np.stack((0.5 * np.maximum(z, 0) + 0.1 * np.maximum(-y, 0), 0.5 * np.maximum(x, 0) + 0.1 * np.abs(y), 0.6 * np.maximum(y, 0)), axis=-1)
    map_[3, 17:19] += (4, 3.5, 2.5)
    map_[2, 17] += (2, 1, 1)
    map_[3, 15:17] += (0.75, 1, 0.25)
    header = {'compression': OpenEXR.ZIP_COMPRESSION, 'type': OpenEXR.scanlineimage}
    OpenEXR.File(header, {c: map_[..., k].astype(np.float16) for k, c in enumerate('RGB')}).write(FOLDER + 'sky.exr')


glass()
vase()
figure()
images()
sky()
