"""Checks mesh.py and images.py.  python3 selftest_mesh.py; needs numpy, trimesh, embreex, pillow and OpenEXR."""
import math
import numpy as np
import images, mesh

random = np.random.default_rng(1)
checks = 0


def ok(name, got, want, tol):
    global checks
    checks += 1
    assert np.allclose(got, want, rtol=0, atol=tol), (name, got, want)


# ---- Embree with the triangles around proposes what brute force finds, from outside and from the surface
for path in ('glass.glb', 'vase.obj', 'figure.ply'):
    m = mesh.Mesh('cases/models/' + path, [('scale', (1, 1.3, 0.8)), ('rotate', (1, 2, 3), 40), ('fit', (0.3, 0, 0.2), 2)], True)
    ok('fit', (np.add(m.low, m.high) / 2), (0.3, 0, 0.2), 1e-12)
    ok('fit', np.subtract(m.high, m.low).max(), 2, 1e-12)
    for _ in range(3000):
        o, d = random.normal(size=3) * 2, mesh.unit(random.normal(size=3))
        part = None
        for _ in range(4):
            fast, slow = m.hit(o, d, part, 1e-9), m.brute_force(o, d, part, 1e-9)
            assert (fast and fast[0]) == (slow and slow[0]), (path, o, d, fast, slow)
            checks += 1
            if not fast:
                break
            o, part = o + fast[0] * d, fast[1]
            outward, shading, tangent, u, v = map(np.array, m.at(o, part))
            ok('unit', [np.linalg.norm(x) for x in (outward, shading, tangent)], 1, 1e-12)
            ok('perpendicular', shading @ tangent, 0, 1e-12)
            assert shading @ outward > 0.3       # these meshes are smooth
            d = mesh.unit(random.normal(size=3))

# ---- normals of a ball of glass against its closed form; angle-weighted ones of the vase have no jump at the seam
positions, triangles, normals, _ = mesh.read('cases/models/glass.glb')
ok('both coordinates at the seam', [len(mesh.read('cases/models/vase.obj')[k]) for k in (0, 3)], 13 * 25, 0)
made = mesh.angle_weighted(positions, triangles)
ok('angle-weighted', (made * normals).sum(axis=1).min(), 1, 0.01)
ok('rotation', mesh.rotation((0, 2, 0), 90) @ (0, 0, 1), (1, 0, 0), 1e-15)

# ---- images: middles of texels, halfway between them, repeated, from the lower left corner
png, exr = images.Texture('cases/models/checks.png'), images.Texture('cases/models/glow.exr')
from PIL import Image
x, y = 5, 2
coded = Image.open('cases/models/checks.png').getpixel((x, y))
linear = [c / 255 / 12.92 if c / 255 <= 0.04045 else ((c / 255 + 0.055) / 1.055) ** 2.4 for c in coded]
for shift in (-3, 0, 2):
    ok('texel', png((x + 0.5) / 8 + shift, (7 - y + 0.5) / 8 - shift), linear, 1e-12)
ok('exr', exr(2.5 / 6, 2.5 / 4), (3, 2.5, 1), 1e-12)
ok('exr', exr(5.5 / 6, 0.5 / 4), (0.25, 1.5, 2), 1e-12)
ok('between', exr(3 / 6, 0.5 / 4), (np.array(exr(2.5 / 6, 0.5 / 4)) + exr(3.5 / 6, 0.5 / 4)) / 2, 1e-12)
ok('around the edge', exr(0, 0.5 / 4), (np.array(exr(0.5 / 6, 0.5 / 4)) + exr(5.5 / 6, 0.5 / 4)) / 2, 1e-12)
ok('no number', exr(math.nan, 0.5 / 4), exr(0, 0.5 / 4), 0)
print('%d checks passed' % checks)
