#!/usr/bin/env python3
"""Shares of light that lobes reflect, by brute force in double precision.

The numbers of `src/instrument/tests.rs` that have no closed form. The hemisphere of the viewer is cut at the mirror
direction of the horizon, with cells that shrink towards it by constant ratios in elevation and azimuth, and each cell
has a Gauss rule of six by six points. Nothing is adaptive, and nothing is shared with the program.

Run it without arguments. It needs no libraries and takes a few seconds.
"""

from math import cos, log10, pi, radians, sin, sqrt


def gauss(count):
    """Places and weights of the Gauss rule on -1..1, by Newton's method."""
    places, weights = [], []
    for index in range(count):
        x = cos(pi * (index + 0.75) / (count + 0.5))
        for _ in range(50):
            before, value = 1.0, x
            for degree in range(2, count + 1):
                before, value = value, ((2 * degree - 1) * x * value - (degree - 1) * before) / degree
            slope = count * (x * value - before) / (x * x - 1)
            x -= value / slope
        places.append(x)
        weights.append(2 / ((1 - x * x) * slope * slope))
    return list(zip(places, weights))


RULE = gauss(6)


def edges(least, greatest, count):
    """0, and numbers from the least to the greatest one, by constant ratios."""
    step = (log10(greatest) - log10(least)) / count
    return [0.0] + [10 ** (log10(least) + index * step) for index in range(count + 1)]


def points(cuts):
    """Places and weights of a rule in each cell."""
    for low, high in zip(cuts, cuts[1:]):
        for place, weight in RULE:
            yield 0.5 * (low + high) + 0.5 * (high - low) * place, 0.5 * (high - low) * weight


def beam(polar, value):
    """The share of a beam from a polar angle in degrees that is reflected. `value` is pi f cos(theta), given the
    directions to light and viewer."""
    light = (sin(radians(polar)), 0.0, cos(radians(polar)))
    azimuths = list(points(edges(1e-6, pi, 45)))
    total = 0.0
    for elevation, height in points(edges(1e-5, pi / 2, 40)):
        rise, reach = sin(elevation), cos(elevation)
        row = sum(
            width * value(light, (-reach * cos(azimuth), reach * sin(azimuth), rise)) for azimuth, width in azimuths
        )
        total += 2 * height * row * rise * reach
    return total / (pi * light[2])


def blinn(exponent):
    def value(light, view):
        x, y, z = (one + other for one, other in zip(light, view))
        return max(0.0, z / sqrt(x * x + y * y + z * z)) ** exponent

    return value


def phong(exponent):
    def value(light, view):
        return max(0.0, -light[0] * view[0] - light[1] * view[1] + light[2] * view[2]) ** exponent

    return value


if __name__ == "__main__":
    for name, model in [("blinn 200", blinn(200)), ("phong 30", phong(30))]:
        for polar in [0, 60, 80, 89, 89.9]:
            print(f"{name} at {polar}: {beam(polar, model):.7f}")
    print("blinn 200 at 0, closed form:", 8 * (2 * (1 - 2**-102) / 204 - (1 - 2**-101) / 202))
    print("phong 30 at 0, closed form:", 2 / 32)
