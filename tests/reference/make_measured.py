#!/usr/bin/env python3
"""Makes small files of measured materials from known models, and what other programs say about them.

    python3 -m venv venv && venv/bin/pip install mitsuba==3.9.1 colour-science numpy
    venv/bin/python tests/reference/make_measured.py

Writes tests/reference/measured:
- *.bsdf, tensor files of a GGX model as the paper of Dupuy and Jakob (2018) describes them, on coarse grids;
- *.csv beside them: directions to the light and to the view, and the reflectance that Mitsuba's plugin `measured` gives.
  Spectra become linear sRGB under D65 by the package colour-science;
- merl_indices.csv: angles, and the indices and coordinates of MERL samples by the formulas of `BRDFRead`.
"""

import struct
import warnings
from pathlib import Path

import numpy as np

warnings.filterwarnings("ignore")
import colour  # noqa: E402
import mitsuba as mi  # noqa: E402

FOLDER = Path(__file__).parent / "measured"
F32 = np.float32
TYPES = {np.dtype("uint8"): 1, np.dtype("float32"): 10}


def write_tensor(path, fields):
    """Fields as a tensor file, their numbers at multiples of 8 bytes."""
    header = 12 + 2 + 4 + sum(2 + len(name) + 2 + 1 + 8 + 8 * array.ndim for name, array in fields.items())
    head = b"tensor_file\0" + bytes([1, 0]) + struct.pack("<I", len(fields))
    body = b""
    for name, array in fields.items():
        body += b"\0" * (-(header + len(body)) % 8)
        head += struct.pack("<H", len(name)) + name.encode()
        head += struct.pack("<HBQ", array.ndim, TYPES[array.dtype], header + len(body))
        head += struct.pack(f"<{array.ndim}Q", *array.shape)
        body += np.ascontiguousarray(array).tobytes()
    path.write_bytes(head + body)


def direction(theta, phi):
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


class Ggx:
    """GGX with Schlick's Fresnel term and separable shadowing (Walter et al. 2007; Heitz 2014)."""

    def __init__(self, alpha_x, alpha_y, f0):
        self.alpha_x, self.alpha_y, self.f0 = alpha_x, alpha_y, np.asarray(f0)

    def ndf(self, m):
        stretched = (m[0] / self.alpha_x) ** 2 + (m[1] / self.alpha_y) ** 2 + m[2] ** 2
        return 1 / (np.pi * self.alpha_x * self.alpha_y * stretched**2)

    def sigma(self, d):
        return 0.5 * (d[2] + np.sqrt(d[2] ** 2 + (self.alpha_x * d[0]) ** 2 + (self.alpha_y * d[1]) ** 2))

    def fresnel(self, cosine):
        return self.f0 + (1 - self.f0) * (1 - cosine) ** 5

    def brdf(self, i, o):
        m = (i + o) / np.linalg.norm(i + o)
        shadowing = (i[2] / self.sigma(i)) * (o[2] / self.sigma(o))
        return self.fresnel(i @ m) * self.ndf(m) * shadowing / (4 * i[2] * o[2])


def tensor_fields(model, phi_i, theta_i, sizes, wavelengths=None):
    """The fields of a file; `sizes` are those of the normals (azimuth, polar), of vndf (the same), and of the colours."""
    isotropic = len(phi_i) <= 2
    ndf_size, vndf_size, side = sizes

    def half(u_theta, u_phi):
        return direction(u_theta**2 * np.pi / 2, (2 * u_phi - 1) * np.pi)

    def grid(size, value):
        return np.array([[value(x, y) for x in np.linspace(0, 1, size[1])] for y in np.linspace(0, 1, size[0])], F32)

    ndf = grid(ndf_size, lambda x, y: model.ndf(half(x, y)))
    sigma = grid(ndf_size, lambda x, y: model.sigma(half(x, y)))
    channels = len(model.f0)
    vndf = np.zeros((len(phi_i), len(theta_i), *vndf_size), F32)
    colours = np.zeros((len(phi_i), len(theta_i), channels, side, side), F32)
    for a, phi in enumerate(phi_i):
        for b, theta in enumerate(theta_i):
            i = direction(theta, 0 if isotropic else phi)
            # The end of the axis keeps a little, so that no row is empty.
            visible = lambda x, y: max(model.ndf(half(x, y)) * (half(x, y) @ i), 0) * x * np.sin(x**2 * np.pi / 2) + 1e-3  # noqa: E731
            vndf[a, b] = grid(vndf_size, visible)
            warp = mi.MarginalContinuous2D0(mi.TensorXf(vndf[a, b]) if hasattr(mi, "TensorXf") else vndf[a, b])
            for row, y in enumerate(np.linspace(0, 1, side)):
                for column, x in enumerate(np.linspace(0, 1, side)):
                    point, _ = warp.sample(mi.ScalarPoint2f(float(x), float(y)))
                    m = half(point[0], point[1])
                    o = 2 * (i @ m) * m - i
                    # Reflectance times cosine over ndf/(4 sigma).
                    o[2] = max(o[2], 0)
                    colours[a, b, :, row, column] = model.fresnel(abs(i @ m)) * o[2] / max(model.sigma(o), 1e-6)
    fields = {
        "description": np.frombuffer(b"GGX, made by make_measured.py", np.uint8),
        "phi_i": np.array(phi_i, F32),
        "theta_i": np.array(theta_i, F32),
        "sigma": sigma,
        "ndf": ndf,
        "vndf": vndf,
        "luminance": np.ascontiguousarray(colours.mean(axis=2)),
        "jacobian": np.array([1], np.uint8),
    }
    if wavelengths is None:
        fields["rgb"] = colours
    else:
        fields["wavelengths"], fields["spectra"] = np.array(wavelengths, F32), colours
    return fields


def srgb_weights(wavelengths):
    """What samples of a spectrum add to linear sRGB under D65, by the tables of colour-science in steps of 1 nm."""
    grid = np.arange(380, 781)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(colour.SpectralShape(380, 780, 1)).values
    light = colour.SDS_ILLUMINANTS["D65"]
    light = np.interp(grid, light.wavelengths, light.values)
    to_srgb = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB
    basis = np.array([np.interp(grid, wavelengths, row) for row in np.eye(len(wavelengths))])
    rgb = (basis * light) @ observer @ to_srgb.T
    return rgb / rgb.sum(axis=0)


def mitsuba_values(path, pairs, wavelengths):
    """The reflectance of Mitsuba for pairs of directions to the light and to the view."""
    material = mi.load_dict({"type": "measured", "filename": str(path)})
    lines = []
    for light, view in pairs:
        interaction = mi.SurfaceInteraction3f()
        interaction.wi = mi.Vector3f(*view)
        towards = mi.Vector3f(*light)
        if wavelengths is None:
            value = np.array(material.eval(mi.BSDFContext(), interaction, towards)).ravel()
        else:
            value = []
            for wavelength in wavelengths:
                interaction.wavelengths = [float(wavelength)] * 4
                value.append(np.array(material.eval(mi.BSDFContext(), interaction, towards)).ravel()[0])
            value = np.array(value) @ srgb_weights(wavelengths)
        # Mitsuba multiplies by the cosine.
        lines.append([*light, *view, *(value / light[2])])
    return lines


def random_pairs(rng, count):
    """Pairs of directions: near mirror directions in one half of them."""
    pairs = []
    while len(pairs) < count:
        view = direction(np.arccos(rng.uniform(0.05, 1)), rng.uniform(-np.pi, np.pi))
        light = direction(np.arccos(rng.uniform(0.05, 1)), rng.uniform(-np.pi, np.pi))
        if len(pairs) % 2:
            m = direction(rng.uniform(0, 0.4), rng.uniform(-np.pi, np.pi))
            light = 2 * (view @ m) * m - view
        if light[2] > 0.05:
            pairs.append((light, view))
    return pairs


def tensor_files():
    gold = [0.95, 0.7, 0.35]
    wavelengths = np.array([380, 420, 465, 500, 530, 560, 610, 660, 730, 800])
    rise = 0.3 + 0.6 / (1 + np.exp(-(wavelengths - 530) / 25.0))
    theta = [0.0, 0.4, 0.8, 1.2, 1.5]
    whole, half, quarter = np.linspace(-np.pi, np.pi, 9), np.linspace(-np.pi, 0, 5), np.linspace(-np.pi, -np.pi / 2, 3)
    files = {
        "isotropic_rgb": (Ggx(0.35, 0.35, gold), [0.0], theta, ((2, 128), (12, 32), 12), None),
        "isotropic_spectral": (Ggx(0.3, 0.3, rise), [0.0], theta, ((2, 64), (12, 16), 6), wavelengths),
        "anisotropic_rgb": (Ggx(0.25, 0.5, gold), whole, theta[::2], ((16, 16), (10, 9), 5), None),
        "half_circle_rgb": (Ggx(0.25, 0.5, gold), half, theta[::2], ((16, 16), (10, 9), 5), None),
        "quarter_circle_spectral": (Ggx(0.5, 0.2, rise), quarter, theta[::2], ((16, 16), (10, 9), 5), wavelengths),
    }
    for number, (name, (model, phi_i, theta_i, sizes, channels)) in enumerate(files.items()):
        mi.set_variant("scalar_rgb" if channels is None else "scalar_spectral")
        path = FOLDER / f"{name}.bsdf"
        write_tensor(path, tensor_fields(model, phi_i, theta_i, sizes, channels))
        pairs = random_pairs(np.random.default_rng(number), 60)
        lines = mitsuba_values(path, pairs, channels)
        text = "# light x, y, z, view x, y, z, reflectance r, g, b in 1/sr by Mitsuba\n"
        text += "".join(",".join(f"{number:.9g}" for number in line) + "\n" for line in lines)
        path.with_suffix(".csv").write_text(text)
        expected = np.array([model.brdf(light, view) for light, view in pairs])
        if channels is None:
            got = np.array(lines)[:, 6:]
            print(name, path.stat().st_size, "median error of the model", np.median(np.abs(got / expected - 1)))
        else:
            print(name, path.stat().st_size)


def rotated(vector, axis, angle):
    """Rodrigues' formula."""
    return vector * np.cos(angle) + np.cross(axis, vector) * np.sin(angle) + axis * (axis @ vector) * (1 - np.cos(angle))


def merl_indices():
    """The indices by `BRDFRead` for random directions, and the coordinates before they are rounded down."""
    rng = np.random.default_rng(7)
    lines = ["# light x, y, z, view x, y, z, coordinates of half angle, difference angle, azimuth, their indices\n"]
    for light, view in random_pairs(rng, 200):
        half = (light + view) / np.linalg.norm(light + view)
        theta_half, phi_half = np.arccos(half[2]), np.arctan2(half[1], half[0])
        difference = rotated(light, np.array([0.0, 0.0, 1.0]), -phi_half)
        difference = rotated(difference, np.array([0.0, 1.0, 0.0]), -theta_half)
        theta, phi = np.arccos(min(difference[2], 1)), np.arctan2(difference[1], difference[0])
        phi = phi + np.pi if phi < 0 else phi
        places = [np.sqrt(theta_half / (np.pi / 2) * 90 * 90), theta / (np.pi / 2) * 90, phi / np.pi * 360 / 2]
        indices = [min(max(int(place), 0), most) for place, most in zip(places, [89, 89, 179])]
        lines.append(",".join(f"{number:.12g}" for number in [*light, *view, *places, *indices]) + "\n")
    (FOLDER / "merl_indices.csv").write_text("".join(lines))


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    merl_indices()
    tensor_files()
