"""Lights for reference.py: what a hit receives from each kind (language 2, Lights and Environments), and where.

A light is asked by `arriving(a, points, turn)` for what arrives at a, as a list of Arrival.  The mean over a light with an area, and the
integral over an environment, are sums over a grid of points (points x points on a surface, 2 points x points directions).  The points are
at other places of the cells of the grid for each `turn`, the number of the ray in its pixel, so that together the rays of a pixel see many more.
"""
import functools
import math
from collections import namedtuple

# direction    unit vector from a to the light
# distance     of the light, up to which bodies hide it
# dist         what the formula reads as `dist`
# inside       whether the light sends anything that way (the cone of a spot)
# factor       of IL: red, green, blue
# weight       of local() in the sum
# chance       that one pass draws this cell of the grid, for the variance of a pass
Arrival = namedtuple('Arrival', 'direction distance dist inside factor weight chance')

WHITE = (1.0, 1.0, 1.0)
FAR = 1e30                                       # dist of what is infinitely far away


def sub(a, b): return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
def add(a, b): return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
def times(a, s): return (a[0] * s, a[1] * s, a[2] * s)
def dot(a, b): return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
def length(a): return math.sqrt(dot(a, a))
def cross(a, b): return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def over(a, s):                                  # NaN where s is 0: the light is at the hit  [CHOICE 10]
    return (a[0] / s, a[1] / s, a[2] / s) if s != 0 else (math.nan,) * 3


def cells(columns, rows, turn):
    """A point in each cell of a grid over the unit square.  turn: (number, count, pixel); all turns together have points evenly spread over each
    cell, a lattice whose two generators are near to count / golden ratio and its square.  Each pixel moves it by another part of a cell, by the
    R2 sequence (Roberts 2018), so that what the grid misses is not the same for all pixels."""
    number, count, pixel = turn
    x0 = ((number * generator(count, 0.6180339887498949) % count + 0.5) / count + pixel * 0.7548776662466927) % 1.0
    y0 = ((number * generator(count, 0.3819660112501051) % count + 0.5) / count + pixel * 0.5698402909980532) % 1.0
    for j in range(rows):
        for i in range(columns):
            yield (i + x0 + j * 0.6180339887498949) / columns % 1.0, (j + y0) / rows


@functools.cache
def generator(count, share):
    """The whole number nearest to share x count that has no divisor in common with count."""
    return min((k for k in range(1, count + 1) if math.gcd(k, count) == 1), key=lambda k: abs(k - share * count))


def toward(a, place, weight=1.0, inside=True, factor=WHITE):
    way = sub(place, a)
    distance = length(way)
    return Arrival(over(way, distance), distance, distance, inside, factor, weight, weight)


class Point:
    corners = ()

    def __init__(self, position):
        self.position, self.corners = position, [position]

    def arriving(self, a, points, turn):
        return [toward(a, self.position)]


class Directional:
    corners = ()

    def __init__(self, travel):
        self.towards = times(travel, -1 / length(travel))

    def arriving(self, a, points, turn):
        return [Arrival(self.towards, math.inf, FAR, True, WHITE, 1.0, 1.0)]


class Spot(Point):
    def __init__(self, position, target, angle, soft):
        super().__init__(position)
        axis = sub(target, position)
        self.axis, self.angle, self.soft = times(axis, 1 / length(axis)), math.radians(angle), math.radians(soft)

    def arriving(self, a, points, turn):
        way = sub(a, self.position)
        off = math.atan2(length(cross(self.axis, way)), dot(self.axis, way))       # 0..pi, also accurate near the axis
        if self.soft > 0:
            t = min(max((off - (self.angle - self.soft)) / self.soft, 0.0), 1.0)
            factor = 1 - t * t * (3 - 2 * t)
        else:
            factor = 1.0 if off <= self.angle else 0.0
        return [toward(a, self.position, inside=factor > 0, factor=(factor,) * 3)]  # [CHOICE 40]


class Sphere:
    def __init__(self, center, radius):
        self.center, self.radius = center, radius
        self.corners = [add(center, (s * radius,) * 3) for s in (-1, 1)]

    def arriving(self, a, points, turn):
        """All of the surface, the far side too.  Equal heights have equal areas (Archimedes)."""
        out = []
        for x, y in cells(points, points, turn):
            z, angle = 1 - 2 * y, 2 * math.pi * x
            s = math.sqrt(max(1 - z * z, 0.0))
            out.append(toward(a, add(self.center, times((s * math.cos(angle), s * math.sin(angle), z), self.radius)), 1 / points ** 2))
        return out


class Rectangle:
    def __init__(self, a, b, c):
        self.corner, self.e1, self.e2 = b, sub(a, b), sub(c, b)
        self.corners = [a, b, c, sub(add(a, c), b)]

    def arriving(self, a, points, turn):
        """To both sides alike."""
        return [toward(a, add(self.corner, add(times(self.e1, x), times(self.e2, y))), 1 / points ** 2)
                for x, y in cells(points, points, turn)]


class Environment:
    corners = ()

    def __init__(self, rows, rotate):
        """rows: texels from the top (+y); None is white everywhere."""
        self.rows, self.turned = rows, math.radians(rotate)
        if rows is not None:
            self.rows = [[tuple(x if x > 0 else 0.0 for x in texel) for texel in row] for row in rows]     # no number, and below 0: 0
        fine = [sum(self.radiance(d)) for d in directions(64, (0, 1, 0))]
        self.mean = sum(fine) / len(fine)        # over all directions, red, green and blue together

    def radiance(self, d):
        """From the direction d, interpolated between the middles of texels, round about to the sides."""
        if self.rows is None:
            return WHITE
        longitude = math.atan2(d[0], d[2]) - self.turned               # 0 is +z, a quarter turn is +x, which is left of the middle
        x = (0.5 - longitude / (2 * math.pi)) * len(self.rows[0]) - 0.5
        y = math.atan2(math.hypot(d[0], d[2]), d[1]) / math.pi * len(self.rows) - 0.5
        i, j = math.floor(x), math.floor(y)
        s, t = x - i, y - j
        total = (0.0, 0.0, 0.0)
        for row, a in ((j, 1 - t), (j + 1, t)):
            texels = self.rows[min(max(row, 0), len(self.rows) - 1)]   # [CHOICE 42] at the poles the outermost row goes on
            for column, b in ((i, 1 - s), (i + 1, s)):
                total = add(total, times(texels[column % len(texels)], a * b))
        return total

    def arriving(self, a, points, turn):
        """1/pi times the integral over all directions, on a grid of equal solid angles: 4 pi / count each."""
        return self.grid(points, turn)

    @functools.lru_cache(1)                      # all hits of one ray share it
    def grid(self, points, turn):
        count = 2 * points * points
        return [Arrival(d, math.inf, FAR, True, r, 4 / count, sum(r) / self.mean / count if self.mean > 0 else 0.0)
                for d, r in ((d, self.radiance(d)) for d in directions(points, turn))]


def directions(points, turn):
    for x, y in cells(2 * points, points, turn):
        up, angle = 1 - 2 * y, 2 * math.pi * x
        s = math.sqrt(max(1 - up * up, 0.0))
        yield s * math.cos(angle), up, s * math.sin(angle)
