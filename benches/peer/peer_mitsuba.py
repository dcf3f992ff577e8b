"""The peer of pictures of many passes in Mitsuba 3: the same scenes in both programs, whether their pictures agree, and
how long a new picture takes after a colour has changed.

Seven scenes are written for both programs. All matte bodies follow Lambert's law with the same colours, mirrors
reflect everything, and glass follows Fresnel's law with the index 1.5.

    white        three matte balls on a matte floor, under a constant environment of radiance 1
    image        the same under the environment that --hdr names: .exr, .hdr, or .exr in base64 in .js
    specular     a mirror ball, a glass ball and a mirror rectangle under that image, without a floor
    mixed        a matte, a mirror and a glass ball on a matte floor, under that image
    bulb         matte balls and floor, lit by a sphere
    panel        the same, lit by a rectangle
    mesh         the four meshes of the shader ball, matte, on a floor, under the image

Illuminator's equation has direct light and chains of mirrors and glass, but no light from one matte surface to
another. So Mitsuba draws matte scenes with its integrator `direct` (one sample of the lights, none of the surface)
and the scene of mirrors and glass with `path`. No integrator of Mitsuba stops at the first matte surface behind
mirrors. For `mixed` this file has one, `ChainIntegrator`, that calls Mitsuba's rays, surfaces and emitters.

Pictures are 320 x 180 and have 1024 samples. Both are averaged over blocks of 10 x 10 pixels, because single pixels
have noise. A block's difference is relative to Mitsuba's block, or to a twentieth of the mean of the picture where
that is more. The script fails with status 1 if the mean over the blocks is more than 1 %. The same difference between
two pictures of Mitsuba with different seeds is printed beside it: it is the noise of such a picture.

Times are of 1280 x 720 with 64 samples. Mitsuba: a colour is set by `mi.traverse`, the scene is updated, and the
picture is rendered into a numpy array. Illuminator: `bench` drags a weight (kd) in images, and the exponent of a
highlight (h) in all passes, of a ball and of the floor, which is most of the picture. Its formula has a highlight
there, which Mitsuba's surfaces have not. Medians of several, after one to warm up. Ratios are times of Mitsuba's
variant llvm_ad_rgb by times of Illuminator.

    pip install mitsuba numpy OpenEXR
    peer_mitsuba.py --hdr FILE.exr [--illuminator PROGRAM] [--threads N] [--json FILE] [--cases image,mesh]
                    [--no-pictures] [--no-times] [--runs N] [--scalar-runs N] [--work FOLDER]

DRJIT_LIBLLVM_PATH names the libLLVM.so to be used. Dr.Jit 1.5 fails with LLVM 14 to 16; that of a Rust toolchain
(22.1) works. Both programs use as many threads as --threads says.
"""
import argparse
import base64
import json
import math
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PICTURE, PICTURE_SAMPLES, BLOCK = (320, 180), 1024, 10
FRAME, FRAME_SAMPLES = (1280, 720), 64
LIMIT = 0.01
SLIDERS = ["ball.kd", "floor.kd", "ball.h", "floor.h"]
CAMERA = {"position": (0.0, 2.2, 7.0), "gaze": (0.0, -0.22, -1.0), "up": (0.0, 1.0, 0.0), "fov": 36.0}
FLOOR = ("floor", ("rectangle", (-9, 0, -9), (9, 0, -9), (9, 0, 9)), ("matte", (0.6, 0.55, 0.5)))
BALLS = [
    ("ball", ("sphere", (-1.7, 0.8, 0.0), 0.8), ("matte", (0.7, 0.3, 0.2))),
    ("second", ("sphere", (0.0, 0.8, -0.7), 0.8), ("matte", (0.3, 0.6, 0.3))),
    ("third", ("sphere", (1.7, 0.8, 0.3), 0.8), ("matte", (0.25, 0.35, 0.7))),
]
BULB = ("sphere", (1.5, 4.5, 2.5), 0.6)
PANEL = ("rectangle", (-3.0, 5.0, 1.0), (-3.0, 5.0, 4.0), (-1.0, 5.0, 4.0))
RADIANCE = {"sphere": 60.0, "rectangle": 10.0}


def with_materials(*materials):
    return [(name, shape, material or own) for (name, shape, own), material in zip(BALLS, materials)]


MIRROR, GLASS = ("mirror",), ("glass", 1.5)
PANE = ("pane", ("rectangle", (-3.5, 0, -2.5), (-3.5, 3.2, -2.5), (3.5, 3.2, -2.5)), MIRROR)
SPECULAR = [*with_materials(MIRROR, MIRROR, GLASS), PANE]
PARTS = [("base", (0.3, 0.3, 0.32)), ("ring", (0.7, 0.5, 0.2)), ("ball", (0.6, 0.2, 0.2)), ("core", (0.3, 0.5, 0.6))]
MESHES = [(name, ("mesh", f"shaderball-{name}"), ("matte", colour)) for name, colour in PARTS]

# name: bodies, light, the integrator of pictures, depth, the integrators whose times are taken
CASES = {
    "white": ([FLOOR, *BALLS], ("white",), "direct", 1, ["direct"]),
    "image": ([FLOOR, *BALLS], ("image",), "direct", 1, ["direct"]),
    "specular": (SPECULAR, ("image",), "path", 9, []),
    "mixed": ([FLOOR, *with_materials(None, MIRROR, GLASS)], ("image",), "chain", 5, ["chain", "path"]),
    "bulb": ([FLOOR, *BALLS], BULB, "direct", 1, ["direct"]),
    "panel": ([FLOOR, *BALLS], PANEL, "direct", 1, ["direct"]),
    "mesh": ([FLOOR, *MESHES], ("image",), "direct", 1, ["direct"]),
}


def fail(message):
    print(f"peer_mitsuba: {message}", file=sys.stderr)
    sys.exit(2)


# ---- Shapes ----------------------------------------------------------------------------------------------------------


def normal_of(a, b, c):
    """The front of Illuminator's rectangle with these corners."""
    front = np.cross(np.subtract(c, a), np.subtract(b, a))
    return front / np.linalg.norm(front)


def area_of(shape):
    if shape[0] == "sphere":
        return 4.0 * math.pi * shape[2] ** 2
    return np.linalg.norm(np.subtract(shape[2], shape[1])) * np.linalg.norm(np.subtract(shape[3], shape[2]))


def write_mesh(name, path):
    """Rewrites a mesh of the presets for both programs: triangles in place of strips, equal positions only once."""
    data = (ROOT / "presets/mesh" / f"{name}.ply").read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    vertices = int(header.split("element vertex ")[1].split()[0])
    points = np.frombuffer(data, "<f4", 5 * vertices, end).reshape(-1, 5)[:, :3]
    start = end + 20 * vertices
    strip = np.frombuffer(data, "<i2", int(np.frombuffer(data, "<i4", 1, start)[0]), start + 4)
    places, index = np.unique(points, axis=0, return_inverse=True)
    triangles, begin = [], 0
    for stop in [*np.flatnonzero(strip < 0), len(strip)]:
        part = index[strip[begin:stop].astype(int)]
        for at in range(len(part) - 2):
            a, b, c = part[at], part[at + 1 + at % 2], part[at + 2 - at % 2]
            if len({a, b, c}) == 3:
                triangles.append((a, b, c))
        begin = stop + 1
    with open(path, "wb") as file:
        file.write(f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\n".encode())
        file.write(b"property float x\nproperty float y\nproperty float z\n")
        file.write(f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n".encode())
        file.write(places.astype("<f4").tobytes())
        faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
        faces["count"], faces["corners"] = 3, triangles
        file.write(faces.tobytes())


# ---- Illuminator -----------------------------------------------------------------------------------------------------


def vector(numbers):
    return "<" + ", ".join(f"{number:g}" for number in numbers) + ">"


def formula_of(light, highlight):
    """Lambert's law, and for area lights the cosine and the square of the distance that Mitsuba's emitters have."""
    sent = "1"
    if light[0] == "sphere":
        centre, radius = vector(light[1]), f"{light[2]:g}"
        sent = f"max(0, -(L.(point + dist*L - {centre}))/{radius})/dist^2"
    if light[0] == "rectangle":
        sent = f"max(0, -(L.{vector(normal_of(*light[1:]))}))/dist^2"
    shine = " + <ks*max(0, R.V)^h>" if highlight else ""
    return f"""body_specific;
kd: scalar, constraint 0..1, default 1, slider;
ks: scalar, constraint 0..1, default 0.2, slider;
h: scalar, constraint 1..500, default 60, slider;
predefined;
ki: constraint 0..1000, default 1;
formula;
C = clamp(N.V, 0, 1);
CT = sqrt(max(0, 1 - eta*eta*(1 - C*C)));
PART(a, b) = ((a - b)/max(a + b, 1e-6))^2;
FRESNEL = if(total, 1, (PART(eta*C, CT) + PART(C, eta*CT))/2);
reflected = kr*if(kt > 0, FRESNEL, 1);
refracted = kt*(1 - FRESNEL);
ambient = <0>;
SENT = {sent};
= IL*SENT*(kd*Cd*max(0, N.L){shine});
"""


def scene_of(bodies, light):
    lines = ["bodies;"]
    for name, shape, material in bodies:
        if shape[0] == "sphere":
            form = f"sphere, center {vector(shape[1])}, radius {shape[2]:g}"
        elif shape[0] == "rectangle":
            form = "rectangle, " + ", ".join(vector(corner) for corner in shape[1:])
        else:
            form = f'mesh, "{shape[1]}.ply", smooth'
        kind = {"matte": "opaque, matte", "mirror": "opaque", "glass": "refractive_index 1.5"}[material[0]]
        lines.append(f" {name}: {form}, {kind};")
    lines.append("lights;")
    if light[0] == "white":
        lines.append(" light: environment;")
    elif light[0] == "image":
        lines.append(' light: environment, "environment.exr";')
    elif light[0] == "sphere":
        lines.append(f" light: sphere, center {vector(light[1])}, radius {light[2]:g};")
    else:
        lines.append(" light: rectangle, " + ", ".join(vector(corner) for corner in light[1:]) + ";")
    lines.append(f"camera;\n position {vector(CAMERA['position'])}; gaze {vector(CAMERA['gaze'])};")
    lines.append(f" up {vector(CAMERA['up'])}; fov {CAMERA['fov']:g};\n")
    return "\n".join(lines)


def write_images(source, folder):
    """Copies an environment for both programs. Components below 0 become 0: Illuminator does so, and Mitsuba does not.

    Illuminator puts row j of n at the polar angle (j + 1/2) pi / n, and Mitsuba at j pi / (n - 1). So Mitsuba's copy
    has 2 n + 1 rows, with means between those of the file. Its interpolation is the same function of the direction then.
    """
    if source.endswith(".js"):
        encoded = re.search(r"base64,([A-Za-z0-9+/=]+)", Path(source).read_text())
        if not encoded:
            fail(f"{source} has no image in base64")
        source = str(folder / "given.exr")
        Path(source).write_bytes(base64.b64decode(encoded[1]))
    image = mi.Bitmap(source).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32)
    rows = np.maximum(np.array(image), 0.0)
    twice = np.empty((2 * len(rows) + 1, *rows.shape[1:]), np.float32)
    twice[1::2], twice[2:-1:2], twice[0], twice[-1] = rows, (rows[:-1] + rows[1:]) / 2, rows[0], rows[-1]
    mi.Bitmap(rows).write(str(folder / "environment.exr"))
    mi.Bitmap(twice).write(str(folder / "environment-mitsuba.exr"))


def write_session(folder, name, highlight):
    bodies, light, _, depth, _ = CASES[name]
    for _, shape, _ in bodies:
        if shape[0] == "mesh" and not (folder / f"{shape[1]}.ply").exists():
            write_mesh(shape[1], folder / f"{shape[1]}.ply")
    (folder / f"{name}.scene").write_text(scene_of(bodies, light))
    (folder / f"{name}.formula").write_text(formula_of(light, highlight))
    lines = ["version = 1", f'formula = "{name}.formula"', f'scene = "{name}.scene"', f"depth = {depth}"]
    for body, _, material in bodies:
        lines += [f"[bodies.{body}]"]
        if material[0] == "matte":
            lines += [f"Cd = {list(material[1])}", "kr = 0.0"]
        else:
            lines += ["kd = 0.0", "ks = 0.0", "kr = 1.0"] + (["kt = 1.0"] if material[0] == "glass" else [])
    # The mean over the area of the light is Illuminator's, the integral Mitsuba's; and Lambert's law here has no 1/pi.
    intensity = RADIANCE[light[0]] * area_of(light) / math.pi if light[0] in RADIANCE else 1.0
    lines += ["[lights.light]", f"ki = {float(intensity)!r}", "IL = [1.0, 1.0, 1.0]"]
    session = folder / f"{name}.toml"
    session.write_text("\n".join(lines) + "\n")
    return session


def run_illuminator(options, *arguments):
    command = [options.illuminator, *map(str, arguments), "--threads", str(options.threads)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        fail(f"{' '.join(command)}\n{done.stderr}")
    if done.stderr.strip():
        print(done.stderr.strip(), file=sys.stderr)
    return done.stdout


def read_exr(path):
    import OpenEXR
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        if "RGB" in channels:
            return channels["RGB"].pixels.astype(np.float64)
        return np.stack([channels[c].pixels for c in "RGB"], axis=2).astype(np.float64)


def our_picture(options, folder, name):
    session, out = write_session(folder, name, False), folder / f"{name}.exr"
    size = "x".join(map(str, PICTURE))
    run_illuminator(options, "render", session, "--size", size, "--samples", options.picture_samples, "-o", out)
    return read_exr(out)


def our_times(options, folder, name):
    """What `bench` says of all passes, with the drags by their sliders."""
    session = write_session(folder, name, True)
    size = "x".join(map(str, FRAME))
    sliders = [word for slider in SLIDERS for word in ("--slider", slider)]
    text = run_illuminator(options, "bench", session, "--size", size, "--samples", options.samples,
                           "--runs", options.runs, "--memory", options.memory, "--json", *sliders)
    report = json.loads(text)["passes"]
    return {**report, "drag": {drag["parameter"]: drag for drag in report["drag"]}}


# ---- Mitsuba ---------------------------------------------------------------------------------------------------------


def mitsuba_rectangle(corners):
    a, b, c = (np.array(corner, float) for corner in corners)
    matrix = np.eye(4)
    matrix[:3] = np.stack([(c - b) / 2, (b - a) / 2, normal_of(a, b, c), (a + c) / 2], axis=1)
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix)}


def mitsuba_shape(folder, shape):
    if shape[0] == "sphere":
        return {"type": "sphere", "center": list(shape[1]), "radius": shape[2]}
    if shape[0] == "rectangle":
        return mitsuba_rectangle(shape[1:])
    return {"type": "ply", "filename": str(folder / f"{shape[1]}.ply")}


def mitsuba_surface(material):
    if material[0] == "matte":
        colour = {"type": "rgb", "value": list(material[1])}
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": colour}}
    if material[0] == "mirror":
        return {"type": "twosided", "bsdf": {"type": "conductor", "material": "none"}}
    return {"type": "dielectric", "int_ior": material[1], "ext_ior": 1.0}


def integrator_of(kind, depth):
    if kind == "direct":
        return mi.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
    if kind == "path":
        return mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 1000})
    return chain_integrator(depth)


def chain_integrator(depth):
    """Follows mirrors and glass, and takes one sample of the lights at the first matte surface, where it stops."""
    class ChainIntegrator(mi.SamplingIntegrator):
        def __init__(self):
            super().__init__(mi.Properties())
            self.depth = depth

        @dr.syntax
        def sample(self, scene, sampler, ray_, medium=None, active=True):
            context, ray = mi.BSDFContext(), mi.Ray3f(ray_)
            weight, result = mi.Spectrum(1.0), mi.Spectrum(0.0)
            active, bounce = mi.Bool(active), mi.UInt32(1)
            sky = scene.environment()
            while active:
                hit = scene.ray_intersect(ray, active)
                if dr.hint(sky is not None, mode="scalar"):
                    result += dr.select(active & ~hit.is_valid(), weight * sky.eval(hit, active & ~hit.is_valid()), 0.0)
                active &= hit.is_valid()
                surface = hit.bsdf(ray)
                matte = active & mi.has_flag(surface.flags(), mi.BSDFFlags.Smooth)
                light, radiance = scene.sample_emitter_direction(hit, sampler.next_2d(matte), True, matte)
                value = surface.eval(context, hit, hit.to_local(light.d), matte)
                result += dr.select(matte & (light.pdf > 0.0), weight * value * radiance, 0.0)
                active &= ~matte & (bounce < self.depth)
                next_, share = surface.sample(context, hit, sampler.next_1d(active), sampler.next_2d(active), active)
                weight = dr.select(active, weight * share, weight)
                ray = dr.select(active, hit.spawn_ray(hit.to_world(next_.wo)), ray)
                bounce += 1
            return result, mi.Bool(True), []

    return ChainIntegrator()


def mitsuba_scene(options, folder, name, size, samples):
    bodies, light, _, _, _ = CASES[name]
    position, gaze = np.array(CAMERA["position"]), np.array(CAMERA["gaze"])
    look = mi.ScalarTransform4f().look_at(
        origin=position.tolist(), target=(position + gaze).tolist(), up=list(CAMERA["up"]))
    film = {"type": "hdrfilm", "width": size[0], "height": size[1], "rfilter": {"type": "box"}, "pixel_format": "rgb",
            "component_format": "float32"}
    content = {
        "type": "scene",
        "sensor": {"type": "perspective", "fov": CAMERA["fov"], "fov_axis": "y", "to_world": look, "film": film,
                   "near_clip": 0.001, "far_clip": 1e4, "sampler": {"type": "independent", "sample_count": samples}},
    }
    for body, shape, material in bodies:
        content[f"body_{body}"] = {**mitsuba_shape(folder, shape), "bsdf": mitsuba_surface(material)}
    if light[0] == "white":
        content["light"] = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
    elif light[0] == "image":
        content["light"] = {"type": "envmap", "filename": str(folder / "environment-mitsuba.exr")}
    else:
        emitter = {"type": "area", "radiance": {"type": "rgb", "value": RADIANCE[light[0]]}}
        content["light"] = {**mitsuba_shape(folder, light), "emitter": emitter}
    return mi.load_dict(content)


def mitsuba_picture(options, folder, name, seed):
    scene = mitsuba_scene(options, folder, name, PICTURE, options.picture_samples)
    _, _, kind, depth, _ = CASES[name]
    picture = mi.render(scene, integrator=integrator_of(kind, depth), spp=options.picture_samples, seed=seed)
    return np.array(picture, dtype=np.float64)


def mitsuba_times(options, folder, name, kind, runs):
    """The milliseconds of new pictures, each after another colour of a ball."""
    scene = mitsuba_scene(options, folder, name, FRAME, options.samples)
    integrator = integrator_of(kind, CASES[name][3])
    parameters = mi.traverse(scene)
    keys = [key for key in parameters.keys() if key.startswith("body_ball.") and key.endswith("reflectance.value")]
    if len(keys) != 1:
        fail(f"the colour of the ball is not one parameter of Mitsuba's scene: {keys}")
    times = []
    scalar = mi.variant().startswith("scalar")
    for turn in range(runs + (0 if scalar else 1)):
        start = time.perf_counter()
        parameters[keys[0]] = mi.Color3f(0.7, 0.3, 0.2 + 0.01 * turn)
        parameters.update()
        picture = np.array(mi.render(scene, integrator=integrator, spp=options.samples, seed=turn))
        times.append(1000.0 * (time.perf_counter() - start))
        if not np.isfinite(picture).all():
            fail(f"{name}: Mitsuba's picture has pixels that are no numbers")
    return times if scalar else times[1:]


# ---- Reports ---------------------------------------------------------------------------------------------------------


def blocks(picture):
    height, width, _ = picture.shape
    return picture.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3).mean(axis=(1, 3))


def compare(ours, theirs):
    """The root mean square of pixels, the difference of the means, and the mean relative difference of blocks."""
    least = 0.05 * theirs.mean()
    relative = np.abs(blocks(ours) - blocks(theirs)) / np.maximum(blocks(theirs), least)
    return {
        "rmse": float(np.sqrt(np.mean((ours - theirs) ** 2))),
        "mean": float(theirs.mean()),
        "mean_difference": float(ours.mean() / theirs.mean() - 1.0),
        "relative": float(relative.mean()),
        "relative_99": float(np.quantile(relative, 0.99)),
    }


def compare_pictures(options, folder, names):
    print(f"pictures, {PICTURE[0]} x {PICTURE[1]}, {options.picture_samples} samples; relative differences of blocks")
    print(f"{'scene':10}{'mean':>8}{'RMSE':>9}{'difference of means':>21}{'mean rel.':>11}{'99 %':>8}{'noise':>8}")
    results = {}
    for name in names:
        ours = our_picture(options, folder, name)
        theirs, again = (mitsuba_picture(options, folder, name, seed) for seed in (1, 2))
        result = compare(ours, theirs)
        result["noise"] = compare(again, theirs)["relative"]
        result["agrees"] = result["relative"] <= LIMIT
        results[name] = result
        np.savez_compressed(folder / f"{name}.npz", ours=ours, theirs=theirs)
        print(f"{name:10}{result['mean']:8.3f}{result['rmse']:9.4f}{100 * result['mean_difference']:20.3f}%"
              f"{100 * result['relative']:10.3f}%{100 * result['relative_99']:7.2f}%{100 * result['noise']:7.3f}%"
              f"{'' if result['agrees'] else '  DIFFERS'}", flush=True)
    return results


def compare_times(options, folder, names):
    print(f"\ntimes, {FRAME[0]} x {FRAME[1]}, {options.samples} samples, {options.threads} threads, medians in ms")
    print(f"{'scene':10}{'integrator':>11}{'LLVM':>9}{'scalar':>9}" + "".join(f"{slider:>10}" for slider in SLIDERS)
          + "   LLVM / each slider")
    results = {}
    for name in names:
        kinds = CASES[name][4]
        if not kinds:
            continue
        ours = our_times(options, folder, name)
        results[name] = {"illuminator": ours, "mitsuba": {}}
        for kind in kinds:
            taken = {}
            for variant, runs in (("llvm_ad_rgb", options.runs), ("scalar_rgb", options.scalar_runs)):
                # An integrator in Python is too slow without compilation to say anything.
                if runs and not (variant == "scalar_rgb" and kind == "chain"):
                    mi.set_variant(variant)
                    taken[variant] = mitsuba_times(options, folder, name, kind, runs)
            mi.set_variant("llvm_ad_rgb")
            results[name]["mitsuba"][kind] = taken
            medians = {variant: statistics.median(times) for variant, times in taken.items()}
            drags = [ours["drag"][slider]["frame_ms"] for slider in SLIDERS]
            cells = [medians.get("llvm_ad_rgb"), medians.get("scalar_rgb")]
            text = "".join("-".rjust(9) if cell is None else f"{cell:9.0f}" for cell in cells)
            text += "".join(f"{drag:10.3f}" for drag in drags) + "   "
            text += "  ".join(f"{cells[0] / drag:.0f}" for drag in drags if cells[0] is not None)
            print(f"{name:10}{kind:>11}{text}", flush=True)
    return results


def processor():
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor()


def options_of():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--hdr", required=True, help="environment in latitude-longitude form: .exr, .hdr or .exr.js")
    parser.add_argument("--illuminator", default=str(ROOT / "target/release/illuminator"))
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--cases", default=",".join(CASES), help="the scenes, with commas between them")
    parser.add_argument("--picture-samples", type=int, default=PICTURE_SAMPLES)
    parser.add_argument("--samples", type=int, default=FRAME_SAMPLES)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--scalar-runs", type=int, default=3, help="0: leave the variant out")
    parser.add_argument("--memory", default="12GiB", help="limit of Illuminator's store of hits")
    parser.add_argument("--no-pictures", action="store_true")
    parser.add_argument("--no-times", action="store_true")
    parser.add_argument("--work", help="folder for scenes and pictures, which are kept")
    parser.add_argument("--json", help="file for all figures")
    options = parser.parse_args()
    unknown = [name for name in options.cases.split(",") if name not in CASES]
    if unknown:
        parser.error(f"there is no scene {', '.join(unknown)}; there are {', '.join(CASES)}")
    return options


def main():
    options = options_of()
    mi.set_variant("llvm_ad_rgb")
    dr.set_thread_count(options.threads)
    version = subprocess.run([options.illuminator, "--version"], capture_output=True, text=True).stdout.strip()
    about = {"date": time.strftime("%Y-%m-%d"), "processor": processor(), "threads": options.threads,
             "mitsuba": mi.__version__, "drjit": dr.__version__, "illuminator": version, "load": os.getloadavg()[0]}
    print(", ".join(f"{key} {value}" for key, value in about.items()))
    names, report = options.cases.split(","), {"about": about}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(options.work or temporary)
        folder.mkdir(parents=True, exist_ok=True)
        write_images(options.hdr, folder)
        if not options.no_pictures:
            report["pictures"] = compare_pictures(options, folder, names)
        if not options.no_times:
            report["times"] = compare_times(options, folder, names)
    if options.json:
        Path(options.json).write_text(json.dumps(report, indent=1) + "\n")
    differing = [name for name, result in report.get("pictures", {}).items() if not result["agrees"]]
    if differing:
        print(f"peer_mitsuba: the pictures differ: {', '.join(differing)}", file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
