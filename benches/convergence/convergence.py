"""How fast pictures of several passes become smooth: the error of 1, 2, 4 ... 1024 passes against 4096, for each kind of
light that needs passes, by running `illuminator render`.

    point        point lights: edges of bodies and of shadows alone, which need rays through other points of a pixel
    rectangle    an area light above the bodies, soft shadows
    sphere       the same with a sphere
    softboxes    the built-in environment `preset:softboxes`: bright panels in a dark room
    sky          `preset:sky`: most of the light comes from a small sun
    specular     a mirror ball and a glass ball beside a matte one, under `preset:softboxes`
    image        an environment in latitude-longitude form, if --hdr names one

Each scene is three balls on a floor with Lambert's model. The error is the root mean square over pixels and
components, divided by the mean of the picture. An exponent is the slope of a straight line through the logarithms of
errors and passes, for 4 to 256 passes: with fewer, the first pass counts too much, whose rays go through the centres
of pixels; with more, the error of the reference is seen.

The numbers of a pixel depend on its index. So a picture with one more row at the top and at the bottom, with a field
of view that leaves the others where they are, has other numbers in each pixel: another scramble. Each scene is
measured with both scrambles, each against the reference of the other one, so that no pass is part of its own
reference.

    pip install numpy OpenEXR
    convergence.py [--illuminator PROGRAM] [--hdr FILE.exr] [--svg FILE] [--json FILE] [--cases sphere,sky]

--svg draws the figure docs/convergence.svg. The figures do not depend on the machine. The times do.
"""
import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parents[2]
WIDTH, HEIGHT, FOV = 160, 90, 36.0
COUNTS = [2**power for power in range(11)]
REFERENCE = 4096
FIT = (4, 256)

BODIES = """bodies;
 floor: rectangle, <-9, 0, -9>, <9, 0, -9>, <9, 0, 9>, opaque, matte;
 left:   sphere, center <-1.7, 0.8, 0>, radius 0.8, opaque, matte;
 middle: sphere, center <0, 0.8, -0.7>, radius 0.8, opaque%s;
 right:  sphere, center <1.7, 0.8, 0.3>, radius 0.8%s;
"""
MATTE = BODIES % (", matte", ", opaque, matte")
CAMERA = "camera;\n position <0, 2.2, 7>; gaze <0, -0.22, -1>; up <0, 1, 0>; fov %r;\n"
FORMULA = "formula;\n= IL*Cd*max(0, N.L);\n"
VALUES = {"floor": "Cd = [0.6, 0.55, 0.5]", "left": "Cd = [0.7, 0.3, 0.2]", "middle": "Cd = [0.3, 0.6, 0.3]",
          "right": "Cd = [0.25, 0.35, 0.7]"}
SPECULAR_MIDDLE = "Cd = [0.0, 0.0, 0.0]\nkr = 0.9"
SPECULAR_RIGHT = "Cd = [0.0, 0.0, 0.0]\nkr = 0.1\nkt = 0.9"
# name: the title of the panel, bodies, lights
CASES = {
    "point": ("point lights: edges", MATTE, " a: point, <-4, 5, 3>;\n b: point, <3, 4, 5>;\n"),
    "rectangle": ("rectangle light", MATTE, " a: rectangle, <-3, 5, 1>, <-3, 5, 4>, <-1, 5, 4>;\n"),
    "sphere": ("sphere light", MATTE, " a: sphere, center <1.5, 4.5, 2.5>, radius 0.6;\n"),
    "softboxes": ("environment: soft boxes", MATTE, ' a: environment, "preset:softboxes";\n'),
    "sky": ("environment: sky and sun", MATTE, ' a: environment, "preset:sky", rotate 100;\n'),
    "specular": ("mirror and glass, soft boxes", BODIES % ("", ", refractive_index 1.5"),
                 ' a: environment, "preset:softboxes";\n'),
}


def fail(message):
    print(f"convergence: {message}", file=sys.stderr)
    sys.exit(1)


def write_session(folder, name, scramble):
    """A session of a scene. Scramble 1 has one more row of pixels above and one below."""
    _, bodies, lights = CASES[name]
    height = HEIGHT + 2 * scramble
    fov = math.degrees(2.0 * math.atan(math.tan(math.radians(FOV) / 2.0) * height / HEIGHT))
    (folder / "lambert.formula").write_text(FORMULA)
    (folder / f"{name}{scramble}.scene").write_text(f"{bodies}lights;\n{lights}{CAMERA % fov}")
    lines = [
        "version = 1", 'formula = "lambert.formula"', f'scene = "{name}{scramble}.scene"',
        f"size = [{WIDTH}, {height}]", "depth = 5", "shadows = true", "[global]", "ka = 0.0",
    ]
    specular = {"middle": SPECULAR_MIDDLE, "right": SPECULAR_RIGHT} if name == "specular" else {}
    for body, values in {**VALUES, **specular}.items():
        lines += [f"[bodies.{body}]", values]
    session = folder / f"{name}{scramble}.toml"
    session.write_text("\n".join(lines) + "\n")
    return session


def picture(program, session, passes):
    """The picture, the seconds it took, and the most memory that the program had, in MiB."""
    out = session.with_suffix(".exr")
    start = time.perf_counter()
    child = subprocess.Popen([program, "render", str(session), "--samples", str(passes), "-o", str(out)],
                             stderr=subprocess.PIPE, text=True)
    said = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        fail(said)
    if said.strip():
        print(said.strip(), file=sys.stderr)
    with OpenEXR.File(str(out)) as file:
        channels = file.channels()
        numbers = channels["RGB"].pixels if "RGB" in channels else np.stack([channels[c].pixels for c in "RGB"], axis=2)
    rows = (len(numbers) - HEIGHT) // 2
    return numbers[rows:rows + HEIGHT].astype(np.float64), time.perf_counter() - start, usage.ru_maxrss / 1024.0


def measure(program, folder, name):
    sessions = [write_session(folder, name, scramble) for scramble in (0, 1)]
    references = [picture(program, session, REFERENCE) for session in sessions]
    mean = np.mean([numbers.mean() for numbers, _, _ in references])
    errors = []
    for session, (reference, _, _) in zip(sessions, references[::-1]):
        pictures = (picture(program, session, count)[0] for count in COUNTS)
        errors.append([float(np.sqrt(np.mean((numbers - reference) ** 2)) / mean) for numbers in pictures])
    return {
        "errors": errors,
        "exponents": [exponent(each) for each in errors],
        "reference_error": float(np.sqrt(np.mean((references[0][0] - references[1][0]) ** 2) / 2) / mean),
        "reference_seconds": references[0][1],
        "reference_mib": references[0][2],
        "mib_of_4": picture(program, sessions[0], 4)[2],
    }


def exponent(errors):
    points = [(math.log(count), math.log(error)) for count, error in zip(COUNTS, errors) if FIT[0] <= count <= FIT[1]]
    return float(np.polyfit(*zip(*points), 1)[0])


# ---- The figure ------------------------------------------------------------------------------------------------------

COLUMNS, AXES, FIRST, STEP, LEGEND = 3, (234.0, 212.0), (52.0, 36.0), (294.0, 292.0), 54.0
COLOURS = ["#0b5fa5", "#c2410c"]
SLOPES = [(-0.5, "4 4"), (-1.0, "2 3")]


def svg(results):
    lowest = min(error for result in results.values() for errors in result["errors"] for error in errors)
    highest = max(error for result in results.values() for errors in result["errors"] for error in errors)
    bottom, top = math.floor(math.log10(lowest)), math.log10(highest) + 0.15
    right, air = math.log10(COUNTS[-1]), 0.06 * math.log10(COUNTS[-1])

    def x(count):
        return (math.log10(count) + air) / (right + 2 * air) * AXES[0]

    def y(error):
        return AXES[1] * (1.0 - (math.log10(error) - bottom) / (top - bottom))

    rows = -(-len(results) // COLUMNS)
    size = (900, FIRST[1] + STEP[1] * rows + LEGEND)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size[0]}" height="{size[1]:g}" '
        f'viewBox="0 0 {size[0]} {size[1]:g}" '
        'font-family="Helvetica, Arial, sans-serif" font-size="12" fill="#222">',
        "<title>How the error falls with the number of passes</title>",
        f'<rect width="{size[0]}" height="{size[1]:g}" fill="white"/>',
    ]
    for index, (name, result) in enumerate(results.items()):
        corner = FIRST[0] + STEP[0] * (index % COLUMNS), FIRST[1] + STEP[1] * (index // COLUMNS)
        lines += [f'<g transform="translate({corner[0]:g} {corner[1]:g})">',
                  f'<clipPath id="axes{index}"><rect width="{AXES[0]:g}" height="{AXES[1]:g}"/></clipPath>',
                  f'<text x="0" y="-12" font-size="14" font-weight="bold">{CASES[name][0]}</text>']
        for decade in range(bottom, math.floor(top) + 1):
            down = y(10.0**decade)
            lines += [f'<path d="M0 {down:.1f}H{AXES[0]:g}" stroke="#e4e4e4"/>',
                      f'<text x="-7" y="{down + 4:.1f}" text-anchor="end">{100 * 10.0**decade:g} %</text>']
        for count in COUNTS[::2]:
            lines += [f'<path d="M{x(count):.1f} {AXES[1]:g}v5" stroke="#666"/>',
                      f'<text x="{x(count):.1f}" y="{AXES[1] + 19:g}" text-anchor="middle">{count}</text>']
        start = math.exp(np.mean([math.log(errors[2]) for errors in result["errors"]]))
        lines.append(f'<g clip-path="url(#axes{index})" stroke="#888" fill="none">')
        for slope, dashes in SLOPES:
            first, last = (start * (count / 4.0) ** slope for count in (COUNTS[0], COUNTS[-1]))
            lines.append(f'<path d="M{x(COUNTS[0]):.1f} {y(first):.1f}L{x(COUNTS[-1]):.1f} {y(last):.1f}" '
                         f'stroke-dasharray="{dashes}"/>')
        lines += ["</g>", f'<rect width="{AXES[0]:g}" height="{AXES[1]:g}" fill="none" stroke="#666"/>']
        for errors, colour in zip(result["errors"], COLOURS):
            points = [(x(count), y(error)) for count, error in zip(COUNTS, errors)]
            path = " ".join(f"{a:.1f},{b:.1f}" for a, b in points)
            lines.append(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="2"/>')
            lines += [f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3" fill="{colour}"/>' for a, b in points]
        power = f"{np.mean(result['exponents']):.2f}".replace("-", "−")
        lines += [f'<text x="{AXES[0] - 8:g}" y="20" text-anchor="end">exponent {power}</text>', "</g>"]
    lines.append(f'<g transform="translate({FIRST[0]:g} {FIRST[1] + STEP[1] * rows:g})">')
    entries = [(f'stroke="{colour}" stroke-width="2"', f"scramble {number}", 120)
               for number, colour in enumerate(COLOURS, 1)]
    entries += [(f'stroke="#888" stroke-dasharray="{dashes}"', f"n to the power {slope:g}".replace("-", "−"), 170)
                for slope, dashes in SLOPES]
    left = 0
    for style, label, width in entries:
        lines += [f'<path d="M{left} 0h34" {style}/>', f'<text x="{left + 42}" y="4">{label}</text>']
        left += width
    lines += [f'<text x="0" y="28">across: passes; upwards: error, of the mean of the picture; '
              f"{WIDTH}×{HEIGHT} pixels, against {REFERENCE} passes of the other scramble</text>", "</g>", "</svg>"]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--illuminator", default=str(ROOT / "target/release/illuminator"))
    parser.add_argument("--hdr", help="measure this environment too, .exr or .hdr")
    parser.add_argument("--cases", help="the scenes, with commas between them [default: all]")
    parser.add_argument("--svg", help="file for the figure")
    parser.add_argument("--json", help="file for all figures")
    parser.add_argument("--from-json", help="draw these figures; measure nothing")
    options = parser.parse_args()
    if options.hdr:
        CASES["image"] = (f"environment: {Path(options.hdr).stem}", MATTE,
                          f' a: environment, "{Path(options.hdr).resolve()}";\n')
    names = options.cases.split(",") if options.cases else list(CASES)
    if unknown := [name for name in names if name not in CASES]:
        parser.error(f"there is no scene {', '.join(unknown)}; there are {', '.join(CASES)}")
    results = {}
    if options.from_json:
        results = json.loads(Path(options.from_json).read_text())
    else:
        shown = [1, 4, 16, 64, 256, 1024]
        print(f"{'scene':11}{'exponents':>15}  errors in % of the mean, with passes {shown}; "
              "reference: error, s, MiB (4 passes)")
        with tempfile.TemporaryDirectory() as folder:
            for name in names:
                result = results[name] = measure(options.illuminator, Path(folder), name)
                powers = " ".join(f"{power:.3f}" for power in result["exponents"])
                errors = " ".join(f"{100 * result['errors'][0][COUNTS.index(count)]:.4f}" for count in shown)
                print(f"{name:11}{powers:>15}  {errors}; {100 * result['reference_error']:.4f}, "
                      f"{result['reference_seconds']:.0f}, {result['reference_mib']:.0f} ({result['mib_of_4']:.0f})",
                      flush=True)
    if options.json:
        Path(options.json).write_text(json.dumps(results, indent=1) + "\n")
    if options.svg:
        Path(options.svg).write_text(svg(results))


if __name__ == "__main__":
    main()
