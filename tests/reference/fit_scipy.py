#!/usr/bin/env python3
"""Fits the same model to the same samples with `illuminator fit` and with scipy.optimize.least_squares, and compares.

    tests/reference/fit_scipy.py [--samples 10000] [--starts 8] [--runs 3] [--noise 0.02] [ILLUMINATOR]

The model is the microfacet model of Walter and others (2007) with the distribution GGX over a matte surface. scipy gets
it in NumPy, for all samples at once, the same bounds, and starts spread over them; it takes differences for the
derivatives, as it does by default. Both use all processors that they can. Prints the parameters that were found and the
medians of the times. Needs numpy and scipy.
"""

import argparse
import json
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

FORMULA = """body_specific;
a: scalar, constraint 0.02..1, default 0.5; n: scalar, constraint 1.05..3, default 1.4;
formula;
c = max(0, L.H); g = sqrt(n^2 - 1 + c^2);
F = 0.5*((g - c)/(g + c))^2*(1 + ((c*(g + c) - 1)/(c*(g - c) + 1))^2);
D = a^2/(pi*((N.H)^2*(a^2 - 1) + 1)^2);
G(x) = 2/(1 + sqrt(1 + a^2*(1 - x^2)/x^2));
= IL*max(0, N.L)*(Cd + <pi*D*F*G(N.L)*G(N.V)/(4*(N.L)*(N.V))>);
"""
SCENE = """bodies; ball: sphere, center <0,0,0>, radius 1; lights; key: point, <3,4,5>;
camera; position <0,0,5>; gaze <0,0,-1>; up <0,1,0>; fov 40;
"""
TRUTH = np.array([0.13, 1.7, 0.4, 0.25, 0.1])
LOW, HIGH = np.array([0.02, 1.05, 0, 0, 0]), np.array([1, 3, 1, 1, 1])
START = np.array([0.5, 1.4, 0.8, 0.8, 0.8])


def reflectance(parameters, light, view):
    """f in 1/sr of red, green and blue: an array of samples × 3."""
    width, index, *matte = parameters
    half = light + view
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    square = width * width
    distribution = square / (np.pi * (half[:, 2] ** 2 * (square - 1) + 1) ** 2)

    def masked(cosine):
        return 2 / (1 + np.sqrt(1 + square * (1 - cosine**2) / cosine**2))

    c = np.abs((light * half).sum(axis=1))
    g = np.sqrt(index**2 - 1 + c**2)
    fresnel = 0.5 * ((g - c) / (g + c)) ** 2 * (1 + ((c * (g + c) - 1) / (c * (g - c) + 1)) ** 2)
    gloss = distribution * masked(light[:, 2]) * masked(view[:, 2]) * fresnel / (4 * light[:, 2] * view[:, 2])
    return gloss[:, None] + np.array(matte) / np.pi


def directions(count, seed):
    """Directions within 80 degrees of the normal, as polar angle and azimuth in degrees."""
    random = np.random.default_rng(seed)
    cosine = random.uniform(np.cos(np.radians(80)), 1, count)
    return np.degrees(np.arccos(cosine)), random.uniform(-180, 180, count)


def vectors(polar, azimuth):
    polar, azimuth = np.radians(polar), np.radians(azimuth)
    return np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1)


def by_scipy(light, view, wanted, starts):
    """The best parameters of several starts."""
    random = np.random.default_rng(7)
    cosine = light[:, 2:3]

    def residuals(parameters):
        return ((reflectance(parameters, light, view) - wanted) * cosine).ravel()

    points = [START] + [LOW + (HIGH - LOW) * random.uniform(0.01, 0.99, 5) for _ in range(starts - 1)]
    found = [least_squares(residuals, point, bounds=(LOW, HIGH), xtol=1e-12, ftol=1e-12, gtol=1e-12) for point in points]
    return min(found, key=lambda result: result.cost).x


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("illuminator", nargs="?", default=str(Path(__file__).parents[2] / "target/release/illuminator"))
    arguments.add_argument("--samples", type=int, default=10_000)
    arguments.add_argument("--starts", type=int, default=8)
    arguments.add_argument("--runs", type=int, default=3)
    arguments.add_argument("--noise", type=float, default=0.02, help="relative; without any, one start is enough for us")
    given = arguments.parse_args()
    angles = [*directions(given.samples, 1), *directions(given.samples, 2)]
    light, view = vectors(*angles[:2]), vectors(*angles[2:])
    wanted = reflectance(TRUTH, light, view)
    wanted *= 1 + given.noise * np.random.default_rng(3).standard_normal(wanted.shape)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "model.formula").write_text(FORMULA)
        (folder / "plain.scene").write_text(SCENE)
        rows = np.column_stack([*angles, wanted])
        np.savetxt(folder / "samples.csv", rows, delimiter=",", header="theta_i,phi_i,theta_o,phi_o,r,g,b", comments="", fmt="%.12g")
        command = [given.illuminator, "fit", "--formula", "model.formula", "--scene", "plain.scene", "--to", "samples.csv"]
        command += ["--free", "a,n,Cd", "--starts", str(given.starts), "--json"]
        ours, whole, theirs = [], [], []
        for _ in range(given.runs):
            begin = time.perf_counter()
            output = json.loads(subprocess.run(command, cwd=folder, check=True, capture_output=True).stdout)
            whole.append(time.perf_counter() - begin)
            ours.append(output["seconds"])
            begin = time.perf_counter()
            found = by_scipy(light, view, wanted, given.starts)
            theirs.append(time.perf_counter() - begin)
    values = [parameter["after"] for parameter in output["parameters"]]
    for name, values_found in [("truth", TRUTH), ("illuminator", values), ("scipy", found)]:
        print(f"{name:12}", " ".join(f"{value:10.6f}" for value in values_found))
    ours, whole, theirs = map(statistics.median, (ours, whole, theirs))
    print(f"{len(output['starts'])} starts")
    print(f"illuminator {ours:.3f} s ({whole:.3f} s with start and reading), scipy {theirs:.3f} s: {theirs / ours:.1f} times")


if __name__ == "__main__":
    main()
