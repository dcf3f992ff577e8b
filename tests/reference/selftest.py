"""Checks reference.py against closed forms.  python3 selftest.py"""
import math, os, sys, tempfile
import reference as r
from reference import *
sys.stderr = open(os.devnull, 'w')
tmp = tempfile.mkdtemp()
count = 0


def ok(name, got, want, tol=1e-12):
    global count
    count += 1
    got, want = (x if isinstance(x, tuple) else (x,) for x in (got, want))
    for g, w in zip(got, want, strict=True):
        assert g == w or abs(g - w) <= tol or (g != g and w != w), (name, got, want)


def make(formula, scene, **k):
    for n, t in (('f', formula), ('s', scene)):
        open(tmp + '/' + n, 'w').write(t)
    return r.build(tmp + '/f', tmp + '/s', **k)[0]


def shoot(t, o, d):
    return t.color(o, normalize(d), None, 1)


CAM = 'camera; position <0,0,9>; gaze <0,0,-1>; up <0,1,0>; fov 40;'

# ---- the language: one value a line
body = 'bodies; s: sphere, center <0,0,0>, radius 1; lights; l: point, <0,0,9>; ' + CAM


def value(e, decl=''):
    return shoot(make('%s formula; = <%s,0,0>;' % (decl, e), body, sets=['ka=0']), (0., 0., 5.), (0., 0., -1.))[0]


for e, w in (('-2^2', 4), ('2^3^2', 512), ('8-3-2', 3), ('8/4/2', 1), ('2*3+4', 10), ('2+3*4', 14), ('2^-1', .5), ('--3', 3), ('(1-1.5)^-2', 4),
             ('0^0', 1), ('(0-8)^(1/3)', NAN), ('1/0', INF), ('-1/0', -INF), ('sqrt(-1)', NAN), ('log(0)', -INF), ('1.5e2', 150), ('.5', .5), ('2.', 2),
             ('1/(-0)', -INF), ('exp(1000)', INF), ('min(0/0,3)', 3), ('min(3,0/0)', NAN), ('max(0/0,3)', 3), ('max(3,0/0)', NAN), ('min(3,2,1)', 1),
             ('max(1,3,2)', 3), ('clamp(0/0,0,1)', 0), ('floor(-1.5)', -2), ('ceil(1.2)', 2), ('fract(-0.25)', .75), ('mod(-1,3)', 2), ('mod(1,-3)', -2),
             ('step(1,1)', 1), ('step(2,1)', 0), ('mix(1,3,0.25)', 1.5), ('smoothstep(0,2,1)', .5), ('smoothstep(1,1,2)', 1), ('sign(-3)', -1),
             ('sign(0)', 0), ('atan2(1,-1)', .75 * math.pi), ('radians(180)', math.pi), ('exp2(3)', 8), ('log2(8)', 3), ('abs(-2)', 2),
             ('acos(-1)', math.pi), ('acos(2)', NAN), ('<1,2,3>.<4,5,6>', 32), ('getx(cross(<0,1,0>,<0,0,1>))', 1), ('gety(reflect(<1,-1,0>,<0,1,0>))', 1),
             ('length(<2,3,6>)', 7), ('distance(<1,1,1>,<3,4,7>)', 7), ('getz(normalize(<0,0,5>))', 1), ('getx(<6,6,6>/<2,3,4>)', 3), ('gety(<6,6,6>/2)', 3),
             ('getx(2*<1,2,3>*<3,1,1>)', 6), ('getz(min(<1,2,3>,<3,2,1>))', 1), ('getx(mix(<0,0,0>,<4,4,4>,0.25))', 1), ('getx(-<1,2,3>)', -1),
             ('if(1<2,3,0/0)', 3), ('if(0/0 != 0/0,1,2)', 1), ('if(0/0 == 0/0,1,2)', 2), ('if(!(0/0<1),1,2)', 1), ('if(1<2&&2<1||3>=3,1,2)', 1),
             ('if((1+2)*3>8,1,2)', 1), ('if(((1<2)),1,2)', 1), ('if(<1,2,3>.<1,1,1> > 5,1,2)', 1), ('if(1>2||(2>1&&!(1==2)),5,6)', 5),
             ('perlin(<3.14,42,7>,2,2,1)', 0.13691995878400012), ('perlin(<3.14,42,7>,2,1,2.9)', 1.5 * 0.13691995878400012),
             ('perlin(N,2,2,0/0)', 0), ('perlin(N,2,2,-5)', 0), ('alpha', 0), ('beta', 0), ('gamma', 0), ('dist', 8), ('getz(point)', 1), ('L.V', 1), ('H.N', 1),
             ('2.*3', 6), ('getx(<1,2,3>-<4,4,4>)', -3), ('pow(-1.5,3)', -3.375), ('atan(1)', math.pi / 4), ('asin(1)', math.pi / 2)):
    ok(e, value(e), float(w))
ok('macro by value', shoot(make('global; a: scalar, default 2; b: scalar, default 3; formula; Q = M*2; M = a+b; = <Q, M^2, -M>;', body, sets=['ka=0']),
                           (0., 0., 5.), (0., 0., -1.)), (10., 25., -5.))
ok('CRLF, BOM', shoot(make('\ufeff/* c */ #uses a b;\r\nformula; // x\r\n= <1,2,3>;', body, sets=['ka=0']), (0., 0., 5.), (0., 0., -1.)), (1., 2., 3.))

for bad in ('formula; = 1;', 'formula; = <1,2,3>', 'formula; = <1.N,0,0>;', 'formula; = Cd*N.L*1;', 'formula; = 1/N;', 'formula; M = M; = N;',
            'formula; A = B2; B2 = A; = N;', 'formula; Cd = 1; = N;', 'formula; = background;', 'formula; = <1<2,0,0>;', 'formula; = if(1<2<3,N,N);',
            'formula; = if(N<L,N,N);', 'formula; = if(1<2,1,N);', 'global; global; formula; = N;', 'global; a: scalar; a: vector; formula; = N;',
            'global; a: scalar, default <1,2,3>; formula; = N;', 'global; a: scalar, constraint 2..1; formula; = N;', 'formula; = foo;', 'formula; = N; = L;',
            'invariants; kr+ka=1; formula; = N;', 'invariants; kr=1; kr+kt=1; kt=1; formula; = N;', 'invariants; Cd=1; formula; = N;',
            'global; a: scalar, slider, slider; formula; = N;', 'formula; = min(N,L,V);', 'global; sin: scalar; formula; = N;', 'formula; = N /* ;'):
    try:
        make(bad, body)
    except Wrong:
        count += 1
    else:
        raise AssertionError('accepted: ' + bad)

# ---- invariants
t = make('body_specific; a: scalar, constraint 0..1, default 0.2; b: scalar, constraint 0..1, default 0.9; c: scalar, constraint 0..1; invariants; a+b+c=1; '
         'formula; = <a,b,c>;', body)
ok('a+b+c=1', tuple(t.scene.bodies[0].values[n] for n in 'abc'), (.2, .8, 0.))
t = make('body_specific; a: scalar, constraint 0..1, default 0.2; b: scalar, constraint 0..1; c: scalar, constraint 0..1; invariants; a+b=1; b+c=1; a+c=1;'
         'formula; = <a,b,c>;', body, sets=['*.a=0.9'])
ok('all locked', tuple(t.scene.bodies[0].values[n] for n in 'abc'), (.5, .5, .5))

# ---- highlight on a sphere: eye (0,0,D), light (D,0,0): by symmetry at N = (1,0,1)/sqrt 2
D = 7.0
t = make('formula; = <R.V, alpha, gamma>;', 'bodies; s: sphere, center <0,0,0>, radius 1.5; lights; l: point, <7,0,0>; '
         'camera; position <0,0,7>; gaze <0,0,-1>; up <0,1,0>; fov 40;', sets=['ka=0'])
P = vscale(normalize((1., 0., 1.)), 1.5)
c = shoot(t, (0., 0., D), vsub(P, (0., 0., D)))
ok('R.V at the highlight', c[0], 1.0)
ok('alpha = gamma', c[1], c[2], 1e-9)
W, Hh = 200, 150
rows, _ = r.render(t, W, Hh)
best = max((rows[y][x][0], x, y) for y in range(Hh) for x in range(W))
px = (1 + P[0] / (D - P[2]) / (math.tan(math.radians(20)) * W / Hh)) * W / 2
assert abs(best[1] + .5 - px) <= 1.5 and abs(best[2] + .5 - Hh / 2) <= 1.5, (best, px)
print('highlight: pixel', best[1:], 'expected x', round(px - .5, 2), 'y', Hh / 2 - .5)

# ---- image the right way up and round: a body at +x +y appears right and top
t = make('formula; = Cd;', 'bodies; s: sphere, center <1,1,0>, radius 0.3; lights; ' + CAM, sets=['ka=1', 's.Cd=<1,1,1>'])
rows, _ = r.render(t, 40, 30)
lit = [(x, y) for y in range(30) for x in range(40) if rows[y][x][0] > 0]
assert lit and all(x >= 20 and y < 15 for x, y in lit)
# fov is vertical: at z distance 9 the half height is 9 tan 20 = 3.2757
ok('fov', primary(t.scene, 20, 0, 40, 30)[1] / -primary(t.scene, 20, 0, 40, 30)[2], math.tan(math.radians(20)))
ok('square pixels', primary(t.scene, 40, 15, 40, 30)[0] / -primary(t.scene, 40, 15, 40, 30)[2], math.tan(math.radians(20)) * 4 / 3)

# ---- Snell at a rectangle, seen from the front and from the back
SEL = 'body_specific; sel: scalar; formula; = if(sel > 0.5, point, <0,0,0>);'
for front in (True, False):
    corners = '<-9,-9,0>,<-9,9,0>,<9,9,0>' if front else '<9,9,0>,<-9,9,0>,<-9,-9,0>'
    t = make(SEL, 'bodies; pane: rectangle, %s, refractive_index 1.5; screen: rectangle, <-99,-99,-2>,<-99,99,-2>,<99,99,-2>; lights; l: point, <0,0,-1>; %s'
             % (corners, CAM), sets=['pane.kt=1', 'screen.sel=1', 'ka=0', 'background=<0.5,0.5,0.5>'])
    for deg in (0, 10, 30, 41, 41.8, 41.82, 42, 60, 85):
        th = math.radians(deg)
        hit = shoot(t, (0.3 - 3 * math.tan(th), 0.2, 3.), (math.sin(th), 0., -math.cos(th)))
        s = math.sin(th) / 1.5 if front else math.sin(th) * 1.5
        if s > 1:
            ok('total reflection at %g' % deg, hit, (0., 0., 0.))
        else:
            x = 0.3 + 2 * math.tan(math.asin(s))
            ok('Snell %g %s' % (deg, front), hit, (x, .2, -2.) if abs(x) < 99 else (.5, .5, .5), 1e-7 * max(1, x * x))
print('critical angle of 1.5:', math.degrees(math.asin(1 / 1.5)), 'between 41.8 and 41.82 as asked')

# ---- a glass ball: a ray at angle i leaves turned by 2(i - r)
t = make(SEL, 'bodies; ball: sphere, center <0,0,0>, radius 1, refractive_index 1.5; screen: rectangle, <-99,-99,-5>,<-99,99,-5>,<99,99,-5>; '
         'lights; l: point, <0,0,-3>; ' + CAM, sets=['ball.kt=1', 'screen.sel=1', 'ka=0'])
for h in (0.0, 0.1, 0.5, 0.8):
    i, rr = math.asin(h), math.asin(h / 1.5)
    turn = 2 * (i - rr)
    a = math.pi / 2 - i - (math.pi - 2 * rr)     # polar angle of the exit point: entry is at pi/2 - i from +x towards +z
    ex, ez = math.cos(a), math.sin(a)
    s = (5 + ez) / math.cos(turn)
    ok('ball %g' % h, shoot(t, (h, 0., 4.), (0., 0., -1.)), (ex - s * math.sin(turn), 0., -5.), 1e-9)

# ---- mirror facing mirror: geometric series; depth
M = 'bodies; a: rectangle, <-9,-9,-1>,<-9,9,-1>,<9,9,-1>; b: rectangle, <9,9,1>,<-9,9,1>,<-9,-9,1>; lights; ' + CAM
for depth in range(1, 10):
    t = make('formula; = N;', M, sets=['*.kr=0.5', '*.Cd=<1,0.5,0.25>', 'ka=0.2'], depth=depth)
    s = 0.2 * sum(.5 ** k for k in range(depth))
    ok('mirrors %d' % depth, shoot(t, (0., 0., 0.), (.1, 0., -1.)), (s, s / 2, s / 4))

# ---- light seen from inside; shadow of one's own body; factor 0 hides NaN
t = make('formula; = <1,0,0>*getz(N) + <0,1,0>;', 'bodies; s: sphere, center <0,0,0>, radius 1; lights; i: point, <0,0,0.2>; o: point, <0,0,5>; ' + CAM, sets=['ka=0'])
ok('inside', shoot(t, (0., 0., 0.), (0., 0., -1.)), (1., 1., 0.))
ok('outside', shoot(t, (0., 0., 3.), (0., 0., -1.)), (1., 1., 0.))
t = make('formula; = <1,1,1>/0;', body, sets=['ka=0', 'l.ki=0'])
ok('0 * inf', shoot(t, (0., 0., 5.), (0., 0., -1.)), (0., 0., 0.))
# tangents
t = make('formula; = T;', body, sets=['ka=0'])
ok('T', shoot(t, (0., 0., 5.), (0., 0., -1.)), (1., 0., 0.))
t = make('formula; = B;', body, sets=['ka=0'])
ok('B', shoot(t, (0., 0., 5.), (0., 0., -1.)), (0., 1., 0.))
ok('pole', t.scene.bodies[0].tangent((0., 1., 0.)), (1., 0., 0.))
print(count, 'checks passed')
