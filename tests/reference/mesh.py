"""Meshes for reference.py: language 2.1 (mesh, transforms, flat, smooth) and 1.4 (u, v, Ng).

trimesh reads the files, and Embree (single precision, by embreex) proposes triangles.  The hit itself is computed here in double
precision, among the proposed triangles and all that share a corner with them.  brute_force() needs no Embree; selftest_mesh.py compares both.
"""
import math
import numpy as np
import trimesh
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

UP = np.array((0.0, 1.0, 0.0))


def unit(a):
    return a / np.sqrt((a * a).sum(axis=-1, keepdims=True))


def read(path):
    """-> positions, triangles (counter-clockwise seen from the front), normals or None, coordinates (v upwards) or None"""
    mesh = trimesh.load(path, process=False, fix_texture=not path.endswith('.ply'))
    place = np.eye(4)
    if isinstance(mesh, trimesh.Scene):          # glTF: one mesh, which a node moves
        (node,) = mesh.graph.nodes_geometry
        place, geometry = mesh.graph[node]
        mesh = mesh.geometry[geometry]
    given = 'vertex_normals' in mesh._cache.cache                        # else trimesh would make some up
    normals = np.array(mesh.vertex_normals, float) if given else None
    if given:
        normals = normals @ np.linalg.inv(place[:3, :3])
    positions = np.array(mesh.vertices, float) @ place[:3, :3].T + place[:3, 3]
    uv = getattr(mesh.visual, 'uv', None) if mesh.visual.kind == 'texture' else None
    return positions, np.array(mesh.faces), normals, None if uv is None else np.array(uv, float)[:, :2]


def angle_weighted(positions, triangles):
    """Normals of the corners: of all triangles at the same position, weighted by their angles there."""
    _, place = np.unique(positions, axis=0, return_inverse=True)
    place = place.reshape(-1)
    total = np.zeros((place.max() + 1, 3))
    corners = positions[triangles]
    face = unit(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arccos(np.clip((unit(a) * unit(b)).sum(axis=1), -1, 1))
        np.add.at(total, place[triangles[:, k]], face * angle[:, None])
    return unit(total)[place]


def rotation(axis, degrees):                     # counter-clockwise seen from where the axis points to (Rodrigues)
    x, y, z = unit(np.array(axis, float))
    k = np.array(((0, -z, y), (z, 0, -x), (-y, x, 0)))
    a = math.radians(degrees)
    return np.eye(3) + math.sin(a) * k + (1 - math.cos(a)) * (k @ k)


class Mesh:
    index = None
    opaque = matte = False

    def __init__(self, path, transforms, smooth):
        """transforms: (word, numbers...) in the order written; smooth: True, False, or None where the scene says neither"""
        positions, self.triangles, normals, self.uv = read(path)
        linear, shift = np.eye(3), np.zeros(3)
        for word, *numbers in transforms:
            if word == 'scale':
                m, s = np.diag(np.broadcast_to(np.array(numbers[0], float), 3)), np.zeros(3)
            elif word == 'rotate':
                m, s = rotation(*numbers), np.zeros(3)
            elif word == 'translate':
                m, s = np.eye(3), np.array(numbers[0])
            else:                                # fit: the bounding box, as the transforms before made it
                now = positions @ linear.T + shift
                low, high = now.min(axis=0), now.max(axis=0)
                factor = numbers[1] / (high - low).max()
                m, s = np.eye(3) * factor, np.array(numbers[0]) - factor * (low + high) / 2
            linear, shift = m @ linear, m @ shift + s
        self.smooth = smooth if smooth is not None else normals is not None
        self.own_normals = normals if normals is not None else angle_weighted(positions, self.triangles)   # [CHOICE 33]
        self.own_normals = unit(self.own_normals)
        mirrored = np.linalg.det(linear) < 0     # the front stays the front
        self.linear, self.normal_matrix, self.own_positions = linear, np.linalg.inv(linear).T, positions
        positions = positions @ linear.T + shift
        self.corners = [tuple(positions.min(axis=0)), tuple(positions.max(axis=0))]
        self.a = positions[self.triangles[:, 0]]
        self.e1, self.e2 = (positions[self.triangles[:, k]] - self.a for k in (1, 2))
        self.cross = np.cross(self.e1, self.e2)
        if (np.linalg.norm(self.cross, axis=1) == 0).any():
            raise ValueError('triangles without area are not for this renderer')
        self.normals = unit(self.cross) * (-1 if mirrored else 1)
        self.low, self.high = self.corners
        self.size = float(np.linalg.norm(np.subtract(self.high, self.low)))
        self.around()
        self.embree = rtcore_scene.EmbreeScene(robust=True)
        TriangleMesh(self.embree, positions[self.triangles].astype(np.float32))

    def around(self):
        """near[i]: triangle i and all that share a position with it"""
        at = {}
        keys = [[tuple(p) for p in (self.a[i], self.a[i] + self.e1[i], self.a[i] + self.e2[i])] for i in range(len(self.a))]
        keys = [[tuple(np.round(p, 9)) for p in three] for three in keys]
        for i, three in enumerate(keys):
            for p in three:
                at.setdefault(p, []).append(i)
        self.near = [np.array(sorted({j for p in three for j in at[p]} | {i})) for i, three in enumerate(keys)]

    def nearest(self, which, o, d, part, eps):
        """The nearest of these triangles, but not `part`, farther than eps: (t, triangle, u, v) or None."""
        a, e1, e2 = self.a[which], self.e1[which], self.e2[which]
        n = self.cross[which]
        with np.errstate(divide='ignore', invalid='ignore'):
            det = -(n @ d)
            q = o - a
            t = (q * n).sum(axis=1) / det
            r = np.cross(q, d)
            u, v = (e2 * r).sum(axis=1) / det, -(e1 * r).sum(axis=1) / det
            good = (det != 0) & (t > eps) & (u >= -1e-12) & (v >= -1e-12) & (u + v <= 1 + 1e-12)
        if part is not None:
            good &= which != part[0]
        if not good.any():
            return None
        t = np.where(good, t, np.inf)
        i = int(np.argmin(t))
        return float(t[i]), int(which[i]), float(u[i]), float(v[i])

    def brute_force(self, o, d, part, eps):
        return self.nearest(np.arange(len(self.a)), np.array(o), np.array(d), part, eps)

    def box(self, o, d):
        """Whether the ray meets the bounding box, made a little larger."""
        margin = 1e-6 * self.size
        near, far = 0.0, math.inf
        for x, s, low, high in zip(o, d, self.low, self.high):
            low, high = low - margin, high + margin
            if s == 0:
                if not low <= x <= high:
                    return False
                continue
            one, other = (low - x) / s, (high - x) / s
            near, far = max(near, min(one, other)), min(far, max(one, other))
        return near <= far

    def hit(self, o, d, part, eps):
        """-> (t, (triangle, u, v)) or None.  part: the triangle on which the ray starts, or None."""
        if not self.box(o, d):
            return None
        o, d = np.array(o), np.array(d)
        best = self.nearest(self.near[part[0]], o, d, part, eps) if part is not None else None
        start, slack = 0.0, 1e-5 * self.size
        while True:
            origin = (o + start * d).astype(np.float32)[None]
            answer = self.embree.run(origin, d.astype(np.float32)[None], query='INTERSECT', output=1)
            triangle = int(answer['primID'][0])
            if triangle < 0:
                break
            reached = start + float(answer['tfar'][0])
            found = self.nearest(self.near[triangle], o, d, part, eps)
            if found and (best is None or found[0] < best[0]):
                best = found
            if best and best[0] <= reached + slack:
                break
            start = reached + slack
        return best and (best[0], best[1:])

    def at(self, point, part):
        """-> geometric and shading normal on the outside, T, u, v"""
        triangle, b, c = part
        weights, three = np.array((1 - b - c, b, c)), self.triangles[triangle]
        outward = self.normals[triangle]
        own = self.linear.T @ outward            # in the file's coordinates
        if self.smooth:                          # interpolated there, then transformed  [CHOICE 34]
            own = weights @ self.own_normals[three]
        own, shading = unit(own), unit(self.normal_matrix @ own)
        u = v = 0.0
        tangent = np.zeros(3)
        if self.uv is not None:
            uv, (a, b, c) = self.uv[three], self.own_positions[three]
            u, v = weights @ uv
            (u1, v1), (u2, v2) = uv[1] - uv[0], uv[2] - uv[0]
            tangent = (v2 * (b - a) - v1 * (c - a)) * np.sign(u1 * v2 - u2 * v1)       # where u grows and v stays
        tangent = tangent - (tangent @ own) * own
        if not np.linalg.norm(tangent) > 1e-12:
            tangent = np.cross(UP, own)
        tangent = unit(self.linear @ (tangent if np.linalg.norm(tangent) > 1e-12 else np.array((1.0, 0.0, 0.0))))   # [CHOICE 36]
        return tuple(map(tuple, (outward, shading, tangent))) + (float(u), float(v))
