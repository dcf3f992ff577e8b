#!/usr/bin/env python3
"""Makes random scenes with all kinds of lights, renders each by the program and by reference.py, and reports where they disagree.
No part of the test run.  Needs numpy and OpenEXR.   random_scenes.py --program PATH --seconds 900 --seed 1 --keep FOLDER

Half of the scenes have only lights without an area: one pass is compared at the pixels that are stable.  For the others the mean of many passes
is compared with the grid of the reference: the mean difference of the picture, and the root of the mean square by the variance of a pass.
What disagrees is rendered once more with more points and passes, and kept in FOLDER if it still does.
"""
import argparse, contextlib, io, math, os, random, subprocess, sys, tempfile, time
import numpy as np
import OpenEXR
import images
import reference

WIDTH, HEIGHT = 14, 10
PASSES = 512


def number(x):
    """A number as the languages write it."""
    return '%.9g' % x


def vector(v):
    return '<%s>' % ','.join(map(number, v))


class Maker:
    def __init__(self, seed, folder):
        self.r, self.folder = random.Random(seed), folder
        self.sampled = self.r.random() < 0.5
        self.size = self.r.choice((1, 1, 1, 1, 1e-3, 1e4))             # of the whole scene
        self.notes = []

    def place(self, low=(-3, -1.5, -3), high=(3, 3, 3)):
        return tuple(self.size * self.r.uniform(a, b) for a, b in zip(low, high))

    def direction(self):
        while True:
            v = tuple(self.r.uniform(-1, 1) for _ in range(3))
            if 0.1 < math.hypot(*v) < 1:
                return v

    def corners(self, middle, side):
        u = reference.normalize(self.direction())
        v = reference.normalize(reference.cross(u, self.direction()))
        a, b = side * self.r.uniform(0.3, 1), side * self.r.uniform(0.3, 1)
        return [tuple(m + s * a * x + t * b * y for m, x, y in zip(middle, u, v)) for s, t in ((-1, -1), (1, -1), (1, 1))]

    def bodies(self):
        r, lines = self.r, []
        self.balls = []
        if r.random() < 0.8:
            s = 6 * self.size
            lines.append('floor: rectangle, %s, %s, %s' % tuple(vector(c) for c in ((-s, -self.size, s), (-s, -self.size, -s), (s, -self.size, -s))))
        for i in range(r.randint(1, 4)):
            if r.random() < 0.6:
                center, radius = self.place((-2, -0.8, -2), (2, 1.5, 1.5)), self.size * r.uniform(0.3, 1.1)
                self.balls.append((center, radius))
                lines.append('b%d: sphere, center %s, radius %s' % (i, vector(center), number(radius)))
            else:
                lines.append('b%d: rectangle, %s, %s, %s' % (i, *map(vector, self.corners(self.place((-2, -0.8, -2), (2, 1.5, 1.5)), self.size))))
        names = [line.split(':')[0] for line in lines]
        for k in range(len(lines)):
            lines[k] += r.choice(('', '', ', opaque', ', matte', ', opaque, matte', ', refractive_index 1.3', ', refractive_index 0.7')) + ';'
        return lines, names

    def map(self):
        """Writes the map of an environment: small and unusual, often."""
        r = self.r
        w, h = r.choice(((1, 1), (2, 1), (4, 2), (8, 4), (3, 5), (24, 12), (64, 32)))
        kind = r.choice(('even', 'random', 'random', 'spot', 'black', 'huge', 'odd', 'gray'))
        n = np.random.default_rng(r.randrange(1 << 30))
        m = n.random((h, w, 3)) + 0.02
        if kind == 'even':
            m[:] = (0.5, 0.25, 1)
        elif kind == 'gray':
            m[:] = m[..., :1]
        elif kind == 'spot':
            m *= 0.2
            m[r.randrange(h), r.randrange(w)] = (30, 20, 10)
        elif kind == 'black':
            m[:] = 0
        elif kind == 'huge':
            m[r.randrange(h), r.randrange(w)] = r.choice((1e3, 6e4, 1e6))
        elif kind == 'odd':
            m[r.randrange(h), r.randrange(w)] = (-1, math.nan, 1)
        self.notes.append('map %dx%d %s' % (w, h, kind))
        path = os.path.join(self.folder, 'map.exr')
        OpenEXR.File({'compression': OpenEXR.ZIP_COMPRESSION, 'type': OpenEXR.scanlineimage},
                     {c: m[..., k].astype(np.float32) for k, c in enumerate('RGB')}).write(path)
        return ', "map.exr"'

    def light(self, name):
        r = self.r
        kinds = ['point', 'directional', 'spot'] + (['sphere', 'rectangle', 'environment'] * 2 if self.sampled else ['environment'])
        kind = r.choice(kinds)
        if kind == 'environment' and self.environment:
            kind = 'spot'
        inside = r.random() < 0.1 and self.balls
        place = r.choice(self.balls)[0] if inside else self.place((-4, -0.5, -3), (4, 4, 5))
        if r.random() < 0.1:                     # under the floor
            place = (place[0], -1.5 * self.size, place[2])
        if kind == 'point':
            return 'point, %s' % vector(place)
        if kind == 'directional':
            d = self.direction()
            d = (d[0], -abs(d[1]), d[2]) if r.random() < 0.8 else r.choice(((0, -1, 0), (1e-6, -1e-6, 0), (0, 1, 0), (1e6, -3e6, 2e6), d))
            return 'directional, %s' % vector(d)
        if kind == 'spot':
            target = self.place() if r.random() < 0.7 else tuple(p + self.size * 1e-3 * x for p, x in zip(place, self.direction()))
            angle = r.choice((0.01, 0.5, 5, 20, 20, 45, 90, 120, 179, 180))
            soft = r.choice(('', ', soft 0', ', soft %s' % number(angle), ', soft %s' % number(angle * r.random()), ', soft %s' % number(angle / 2)))
            return 'spot, %s, target %s, angle %s%s' % (vector(place), vector(target), number(angle), soft)
        if kind == 'sphere':
            radius = self.size * r.choice((1e-3, 0.1, 0.4, 0.4, 1, 3))
            if r.random() < 0.1:                 # it touches the floor
                place = (place[0], -self.size + radius, place[2])
            return 'sphere, center %s, radius %s' % (vector(place), number(radius))
        if kind == 'rectangle':
            return 'rectangle, %s, %s, %s' % tuple(map(vector, self.corners(place, self.size * r.choice((1e-3, 0.3, 0.8, 0.8, 2)))))
        self.environment = True
        return 'environment%s%s' % (self.map() if r.random() < 0.8 else '', r.choice(('', ', rotate 30', ', rotate -100.5', ', rotate 720', ', rotate 1e5')))

    def formula(self):
        r = self.r
        parts = ['IL*Cd*max(0,N.L)', 'IL*Cd*(N.L)', 'IL*(0.3*max(0,R.V)^h)', 'IL*(0.3*max(0,H.N)^h)', 'IL*Cd*(max(0,N.L)/(0.2+(dist/size)^2))',
                 'IL*Cd*max(0,(N.L+0.4)/1.4)', '<0.1*alpha,0.1*beta,0.1*gamma>*IL', 'sqrt(IL)*Cd*max(0,N.L)', 'IL*Cd*(1-abs(N.L))', 'IL*IL*(0.2*max(0,N.L))']
        if not (self.environment and self.black):
            parts += ['<0.1*alpha,0.1*beta,0.1*gamma>', 'Cd*max(0,N.L)', '<0.2+0.2*gety(L)>*Cd']
        if r.random() < 0.25:
            parts = ['visible*(%s)' % p for p in parts] + ['<0.1*visible,0.1*(1-visible),0>*IL', 'IL*Cd*(0.2*max(0,-(N.L)))']
        text = ' + '.join(r.sample(parts, r.randint(1, 2)))
        if self.environment and not self.sampled:                      # no light term, so that one pass has no noise
            text = '<0>'
        macros = r.choice(('', '', 'reflected = kr*<1,0.7,0.4>;', 'F = if(total, 1, 0.04 + 0.96*(1-max(0,N.V))^5); reflected = kr*F; refracted = kt*(1-F);',
                           'emission = <0.05,0,0.1>;', 'ambient = ka*Cd*max(0,gety(N));'))
        return ('predefined; ki: constraint 0..50; IL: constraint 0..50; global; size: scalar, default %s; body_specific; h: scalar, constraint 1..500, default %d;\n'
                'formula; %s\n= %s;\n' % (number(self.size), r.choice((1, 5, 20, 60)), macros, text))

    def make(self):
        r = self.r
        self.environment, self.black = False, False
        bodies, names = self.bodies()
        lights = ['l%d: %s;' % (k, self.light('l%d' % k)) for k in range(r.randint(1, 4))]
        self.black = any('black' in n for n in self.notes)
        eye, gaze = (0.2, 1.0, 6.0), (0, -0.17, -1)
        if r.random() < 0.1 and self.balls:      # inside a body
            eye = tuple(x / self.size for x in r.choice(self.balls)[0])
        camera = 'camera; position %s; gaze %s; up <0,1,0>; fov %s;' % (vector(x * self.size for x in eye), vector(gaze), r.choice(('38', '60', '100')))
        scene = 'bodies;\n%s\nlights;\n%s\n%s\n' % ('\n'.join(bodies), '\n'.join(lights), camera)
        sets = ['ka=%g' % r.choice((0, 0.1))]
        for b in names:
            sets += ['%s.Cd=%s' % (b, vector(round(r.random(), 3) for _ in range(3)))]
            sets += ['%s.%s=%g' % (b, k, round(r.random(), 2)) for k in ('kr', 'kt') if r.random() < 0.4]
        for k in range(len(lights)):
            sets += ['l%d.ki=%g' % (k, r.choice((0, 0.3, 0.6, 1, 20)))] if r.random() < 0.8 else []
            sets += ['l%d.IL=%s' % (k, vector(round(r.random(), 2) for _ in range(3)))] if r.random() < 0.6 else []
        background = tuple(round(r.random(), 2) for _ in range(3)) if r.random() < 0.5 else (0, 0, 0)
        return self.formula(), scene, sets, background, r.randint(1, 3), r.random() < 0.8


def program(path, folder, sets, background, depth, shadows, passes, backend):
    out = os.path.join(folder, 'ours.exr')
    command = [path, 'render', '--formula', folder + '/f.formula', '--scene', folder + '/s.scene', '--size', '%dx%d' % (WIDTH, HEIGHT), '--depth', str(depth),
               '--samples', str(passes), '--background', vector(background), '--backend', backend, '-o', out, '--shadows' if shadows else '--no-shadows']
    for s in sets:
        command += ['--set', s]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        return None, command, done.stderr
    return np.array(images.texels(out)), command, done.stderr


def expected(folder, sets, background, depth, shadows, samples, points, shifts):
    with contextlib.redirect_stderr(io.StringIO()):
        tracer, _ = reference.build(folder + '/f.formula', folder + '/s.scene', sets, 1.5, background, depth, shadows)
    tracer.points = points
    rows = [reference.render_row((tracer, y, WIDTH, HEIGHT, samples, (0.0, 0.0), shifts)) for y in range(HEIGHT)]
    picture, stable, deviations = (np.array(part) for part in zip(*rows))
    return picture, stable > 0, deviations


E = 0.01
SHIFTS = ((E, E), (E, -E), (-E, E), (-E, -E))


def disagreement(path, folder, made, effort, backend, before=None):
    """-> what disagrees, or None; what the program wrote about it; the picture of the reference.  before: the latter, with less effort"""
    sets, background, depth, shadows, sampled = made
    passes = PASSES * effort if sampled else 1
    ours, command, messages = program(path, folder, sets, background, depth, shadows, passes, backend)
    with open(folder + '/command', 'w') as f:
        f.write(' '.join("'%s'" % c for c in command) + '\n' + messages)
    if ours is None:
        return 'the program failed: ' + messages, messages, None
    if not np.isfinite(ours).all():
        return 'not finite: %d components' % (~np.isfinite(ours)).sum(), messages, None
    if not sampled:
        theirs, stable, _ = expected(folder, sets, background, depth, shadows, 1, 1, SHIFTS)
        off = (np.abs(ours - theirs) / np.maximum(1, np.abs(theirs))).max(axis=-1) * stable
        if (off > 2e-3).sum() > 0:
            y, x = np.unravel_index(off.argmax(), off.shape)
            return '%d of %d pixels; worst at %d,%d: ours %s, theirs %s' % ((off > 2e-3).sum(), stable.sum(), x, y, ours[y, x], theirs[y, x]), messages, None
        return None, messages, None
    theirs, _, deviations = expected(folder, sets, background, depth, shadows, 4 * effort, 2 + effort, ())
    d = ours - theirs
    mean, error, whole = d.mean(axis=(0, 1)), d.std(axis=(0, 1)) / math.sqrt(WIDTH * HEIGHT), theirs.mean(axis=(0, 1))
    error = np.maximum(error, 1e-30)
    noise = np.sqrt((deviations ** 2).mean() / passes)
    root = np.sqrt((d ** 2).mean())
    grid = 0.0 if before is None else np.sqrt(((theirs - before) ** 2).mean())           # what the grid misses
    text = 'mean off by %s of %s, %s standard errors; root mean square %.3g, noise of passes %.3g, of the grid %.3g' % (mean, whole, (mean / error).round(1), root, noise, grid)
    if (np.abs(mean) > 5 * error + 5e-3 * np.abs(whole) + 1e-6).any() or root > 1.5 * noise + grid + 0.02 * np.abs(whole).max() + 1e-6:
        return text, messages, theirs
    return None, messages, None


def main():
    a = argparse.ArgumentParser()
    a.add_argument('--program', required=True)
    a.add_argument('--seconds', type=float, default=900)
    a.add_argument('--seed', type=int, default=1)
    a.add_argument('--keep', required=True)
    o = a.parse_args()
    sys.setrecursionlimit(20000)
    end, seed, count, bad = time.time() + o.seconds, o.seed * 1000000, 0, 0
    while time.time() < end:
        seed += 1
        folder = os.path.join(o.keep, str(seed))
        os.makedirs(folder, exist_ok=True)
        maker = Maker(seed, folder)
        formula, scene, *rest = maker.make()
        made = (*rest, maker.sampled)
        open(folder + '/f.formula', 'w').write(formula)
        open(folder + '/s.scene', 'w').write(scene)
        backend = 'jit' if seed % 4 else 'interpreter'
        try:
            wrong, messages, before = disagreement(o.program, folder, made, 1, backend)
            if before is not None:
                wrong, messages, _ = disagreement(o.program, folder, made, 2, backend, before)
        except Exception as e:
            wrong, messages = 'the reference fails: %r' % e, ''
        count += 1
        if wrong:
            bad += 1
            print(seed, 'passes' if maker.sampled else 'one pass', backend, maker.notes, wrong, flush=True)
        elif any(word in messages for word in ('NaN', 'number', 'panick')):
            print(seed, 'says:', messages, flush=True)
        else:
            subprocess.run(['rm', '-r', folder])
    print('%d scenes, %d disagree' % (count, bad))


if __name__ == '__main__':
    main()
