"""The peer of the compiled evaluator in Dr.Jit: Phong's and Strauss's models over stored hits, recorded once, compiled by
LLVM and replayed for every frame. It uses the protocol of peer.c: see README.md.

Hits are sorted into groups of one body and one set of lights in which no pixel appears twice. So parameters are uniform
in a kernel, kernels differ only by the number of lights, and adding to the picture needs no atomic instructions. The
picture has four channels, since vector instructions move packets of four numbers. Hits that no light reaches and rays
that leave the scene add a colour that depends on their path only. Pixels with the same set of such paths share one sum,
which is looked up when the framebuffer is filled. The whole frame is one frozen function: its kernels are recorded at
first use and launched again with other buffers of parameters afterwards.

Usage: peer_drjit.py DIR THREADS [LIBLLVM]
"""
import json
import os
import sys
import time

import numpy as np


def fail(message):
    print(f"peer_drjit: {message}", file=sys.stderr)
    sys.exit(1)


if len(sys.argv) not in (3, 4):
    fail("usage: peer_drjit.py DIR THREADS [LIBLLVM]")
FOLDER, THREADS = sys.argv[1], int(sys.argv[2])
if len(sys.argv) == 4:
    os.environ["DRJIT_LIBLLVM_PATH"] = sys.argv[3]

import drjit as dr  # noqa: E402  (reads the environment)
from drjit.llvm import Array3f, Array4f, Float, UInt32, Int32  # noqa: E402

dr.set_thread_count(THREADS)
dr.set_flag(dr.JitFlag.FastMath, True)
NONE = 0xFFFFFFFF


# ---- Input -----------------------------------------------------------------------------------------------------------


def column(name, kind, components=1):
    data = np.fromfile(f"{FOLDER}/{name}", dtype=kind)
    return data.reshape(-1, components) if components > 1 else data


try:
    index = json.load(open(f"{FOLDER}/index.json"))
    WIDTH, HEIGHT, BODIES, LIGHTS = index["width"], index["height"], index["bodies"], index["lights"]
    pixel, path = column("hits.pixel.u32", np.uint32), column("hits.path.u32", np.uint32)
    normal, view = column("hits.N.f32", np.float32, 3), column("hits.V.f32", np.float32, 3)
    record_hit, record_light = column("records.hit.u32", np.uint32), column("records.light.u32", np.uint32)
    to_light = column("records.L.f32", np.float32, 3)
    miss_pixel, miss_path = column("misses.pixel.u32", np.uint32), column("misses.path.u32", np.uint32)
    parent, edge, path_body = (column(f"paths.{c}.u32", np.uint32) for c in ("parent", "edge", "body"))
    lines = [line.split() for line in open(f"{FOLDER}/values.txt") if line.strip() and not line.startswith("#")]
except (OSError, KeyError, ValueError) as problem:
    fail(problem)

GIVEN = {"global": {"ka": 0.1, "Ia": [1, 1, 1], "background": [0, 0, 0]}}
for b in BODIES:
    GIVEN[b] = dict(Cd=[0.8] * 3, kr=0, kt=0, kd=0.6, ks=0.35, h=60, s=0.6, m=0.2, t=0)
for l in LIGHTS:
    GIVEN[l] = dict(ki=1, IL=[1, 1, 1])
for owner, name, *numbers in lines:
    if owner not in GIVEN or name not in GIVEN[owner]:
        fail(f"values.txt: no such value: {owner} {name}")
    GIVEN[owner][name] = float(numbers[0]) if len(numbers) == 1 else [float(x) for x in numbers]

# ---- Layout ----------------------------------------------------------------------------------------------------------

PIXELS, HITS = WIDTH * HEIGHT, len(pixel)
light_set = np.zeros(HITS, np.uint32)
record_of = np.zeros((HITS, max(1, len(LIGHTS))), np.uint32)
np.bitwise_or.at(light_set, record_hit, np.uint32(1) << record_light)
record_of[record_hit, record_light] = np.arange(len(record_hit), dtype=np.uint32)


def columns(table):
    """A table of three columns as three arrays of their own."""
    return [Float(np.ascontiguousarray(table[:, c])) for c in range(3)]


groups = {"nlv": [], "dots": []}
shapes = []  # body and lights of each group


def add_group(b, lights, hits):
    place = {"pixel": UInt32(pixel[hits]), "path": UInt32(path[hits])}
    N, V, L = normal[hits], view[hits], [to_light[record_of[hits, l]] for l in lights]
    NV = (N * V).sum(1)
    NL = [(N * x).sum(1) for x in L]
    RV = [2 * nl * NV - (x * V).sum(1) for nl, x in zip(NL, L)]
    shapes.append((b, lights))
    groups["nlv"].append(place | {"N": columns(N), "V": columns(V), "L": [columns(x) for x in L]})
    groups["dots"].append(place | {"NV": Float(NV), "NL": [Float(x) for x in NL], "RV": [Float(x) for x in RV]})


for b in range(len(BODIES)):
    for bits in range(1, 1 << len(LIGHTS)):
        hits = np.nonzero((path_body[path] == b) & (light_set == bits))[0]
        if not len(hits):
            continue
        lights = [l for l in range(len(LIGHTS)) if bits >> l & 1]
        hits = hits[np.lexsort((path[hits], pixel[hits]))]
        first = np.r_[0, np.nonzero(np.diff(pixel[hits]))[0] + 1]
        rank = np.arange(len(hits)) - np.repeat(first, np.diff(np.r_[first, len(hits)]))
        for r in range(rank.max() + 1):
            add_group(b, lights, hits[rank == r])

# Sets of paths whose colours do not depend on light: with the misses, and without them for a black background.
random = np.random.default_rng(1).integers(1, 1 << 62, size=len(parent), dtype=np.uint64)


def layer(pixels, paths):
    key = np.zeros(PIXELS, np.uint64)
    np.add.at(key, pixels, random[paths])
    _, one, number = np.unique(key, return_index=True, return_inverse=True)
    chosen = np.isin(pixels, one)
    return {"set": UInt32(number.astype(np.uint32)), "term_set": number[pixels[chosen]].ravel(), "term_path": paths[chosen], "count": len(one)}


dark = light_set == 0
layers = [layer(pixel[dark], path[dark]),
          layer(np.concatenate([pixel[dark], miss_pixel]), np.concatenate([path[dark], miss_path]))]
RECORDS = len(record_hit)
depth = np.zeros(len(parent), int)  # of paths, for weights level by level
for p in range(len(parent)):
    depth[p] = 0 if parent[p] == NONE else depth[parent[p]] + 1
levels = [np.nonzero(depth == d)[0] for d in range(1, depth.max() + 1)]
child_body = np.where(parent == NONE, 0, path_body[np.minimum(parent, len(parent) - 1)]).astype(np.int64)
owner_or_miss = np.where(path_body == NONE, len(BODIES), path_body).astype(np.int64)
del normal, view, to_light, record_of, pixel, path

# ---- Values that depend on parameters only ---------------------------------------------------------------------------

BODY = 14  # floats of a body in the table: ambient 3, N.L factor 3, highlight 3, Fresnel 3, exponent, rn


def prepare(model, values):
    g = values["global"]
    kr, kt = (np.array([values[b][k] for b in BODIES]) for k in ("kr", "kt"))
    factor = np.where(edge == 1, kr[child_body], kt[child_body])
    weight = np.ones(len(parent))
    for level in levels:
        weight[level] = weight[parent[level]] * factor[level]
    Cd = np.array([values[b]["Cd"] for b in BODIES], float)
    ambient = g["ka"] * Cd * np.array(g["Ia"])
    colour = np.vstack([ambient, g["background"]])[owner_or_miss] * weight[:, None]
    background = any(g["background"])
    chosen = layers[background]
    sums = np.zeros((chosen["count"], 4))
    for c in range(3):
        sums[:, c] = np.bincount(chosen["term_set"], colour[chosen["term_path"], c], chosen["count"])
    table = []
    for i, b in enumerate(BODIES):
        v = values[b]
        if model == "phong":
            rows = [v["kd"] * Cd[i], np.full(3, v["ks"]), np.zeros(3)]
            exponent, rn = v["h"], 0
        else:
            rd = (1 - v["s"] ** 3) * (1 - v["t"])
            exponent, rn = (min(3 / (1 - v["s"]), 1e9) if v["s"] < 1 else 1e9), 1 - v["t"] - rd
            metal = v["m"] * (Cd[i] - 1)
            rows = [(1 - v["m"] * v["s"]) * rd * Cd[i], 1 + metal, -metal]
        table.append(np.concatenate([ambient[i], *rows, [exponent, rn]]))
    for l in LIGHTS:
        table.append(values[l]["ki"] * np.array(values[l]["IL"]))
    return (Float(np.concatenate(table).astype(np.float32)), Float(weight.astype(np.float32)),
            Float(sums.ravel().astype(np.float32)), chosen["set"])


# ---- Models ----------------------------------------------------------------------------------------------------------


def fresnel(x):
    k = 1 / 1.12**2
    return (dr.square(dr.rcp(x - 1.12)) - k) * (1 / (1 / 0.12**2 - k))


def shadow(x):
    k = 1 / 0.01**2
    return (k - dr.square(dr.rcp(x - 1.01))) * (1 / (k - 1 / 1.01**2))


def angle(x):
    return dr.acos(dr.minimum(dr.maximum(x, 0), 1)) * (2 / dr.pi)


def shade(model, variant, group, body, lights, table):
    """The three channels of a group's hits, without their weights."""
    scalar = lambda i: dr.gather(Float, table, i)  # noqa: E731
    at = BODY * body
    colour = [scalar(at + c) for c in range(3)]
    exponent, rn = scalar(at + 12), scalar(at + 13)
    if variant == "nlv":
        N, V = Array3f(*group["N"]), Array3f(*group["V"])
        NV = dr.dot(N, V)
    else:
        NV = group["NV"]
    if model == "strauss":
        GG = shadow(angle(NV))
    for k, l in enumerate(lights):
        if variant == "nlv":
            L = Array3f(*group["L"][k])
            NL = dr.dot(N, L)
            RV = 2 * NV * NL - dr.dot(V, L)
        else:
            NL, RV = group["NL"][k], group["RV"][k]
        shine = dr.exp2(dr.log2(dr.maximum(RV, 1e-30)) * exponent)
        if model == "strauss":
            a = angle(NL)
            F = fresnel(a)
            shine = dr.select(NL >= 0, shine * dr.minimum(1, rn + (rn + 0.1) * (F * shadow(a) * GG)), 0)
        NL = dr.maximum(NL, 0)
        for c in range(3):
            light = scalar(BODY * len(BODIES) + 3 * l + c)
            term = scalar(at + 6 + c)
            if model == "strauss":
                term = dr.fma(F, scalar(at + 9 + c), term)
            colour[c] = dr.fma(light, dr.fma(shine, term, NL * scalar(at + 3 + c)), colour[c])
    return colour


def make_frame(model, variant, linear):
    @dr.freeze
    def frame(data, table, weights, sums, sets):
        picture = dr.zeros(Float, 4 * PIXELS)
        for group, (body, lights) in zip(data, shapes):
            colour = shade(model, variant, group, body, lights, table)
            w = dr.gather(Float, weights, group["path"])
            dr.scatter_add(picture, Array4f(*(c * w for c in colour), 0), group["pixel"], mode=dr.ReduceMode.NoConflicts)
            dr.eval(picture)  # group by group: kernels of one evaluation may run at once
        total = list(dr.gather(Array4f, picture, dr.arange(UInt32, PIXELS)) + dr.gather(Array4f, sums, sets))[:3]
        if linear:
            return total
        r, g, b = (UInt32(Int32(dr.round(dr.clip(x, 0, 1) * 255))) for x in total)
        return (r << 16) | (g << 8) | b

    return frame


frames = {}


def run(model, variant, values, linear=False):
    key = model, variant, linear, any(values["global"]["background"])
    if key not in frames:
        frames[key] = make_frame(*key[:3])
    result = frames[key](groups[variant], *prepare(model, values))
    dr.eval(result)
    dr.sync_thread()
    return result


# ---- Commands --------------------------------------------------------------------------------------------------------


def moved_values():
    values = {owner: dict(items) for owner, items in GIVEN.items()}
    for b in BODIES:
        v = values[b]
        v["kd"] += 1e-3
        v["h"] += 1e-3
        v["m"] += 1e-3
        v["s"] += 1e-3 if v["s"] < 0.5 else -1e-3
    return values


MOVED, moved = moved_values(), False
print(f"ready {HITS} {RECORDS}", flush=True)
for line in sys.stdin:
    words = line.split(maxsplit=3)
    if words[:1] == ["quit"]:
        break
    if words[:1] == ["triad"] and len(words) == 2:
        n, best = int(words[1]) // 4, 1e9
        b, c, s = dr.full(Float, 1, n), dr.full(Float, 2, n), dr.opaque(Float, 3)
        dr.make_opaque(b, c)
        for _ in range(4):  # the first one compiles
            dr.sync_thread()
            start = time.perf_counter()
            a = dr.fma(s, c, b)
            dr.eval(a)
            dr.sync_thread()
            best = min(best, time.perf_counter() - start)
            del a
        print(f"{best * 1e3:.6f}", flush=True)
        continue
    if len(words) < 3 or words[1] not in ("phong", "strauss") or words[2] not in groups:
        fail(f"unknown command: {line.strip()}")
    if words[0] == "frame":
        if (words[1], words[2], False, any(GIVEN["global"]["background"])) not in frames:
            for values in (GIVEN, MOVED, GIVEN):
                run(words[1], words[2], values)
        moved = not moved
        start = time.perf_counter()
        run(words[1], words[2], MOVED if moved else GIVEN)
        print(f"{(time.perf_counter() - start) * 1e3:.6f}", flush=True)
    elif words[0] == "write" and len(words) == 4:
        total = run(words[1], words[2], GIVEN, linear=True)
        np.stack([np.array(x) for x in total], -1).astype(np.float32).tofile(words[3].strip())
        print("ok", flush=True)
    else:
        fail(f"unknown command: {line.strip()}")
