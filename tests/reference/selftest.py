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
    return t.color(o, normalize(d), (None, None), 1)


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

# ---- the grown language: functions, sums, conditions as numbers, components.  x is the first component of the result
SCALARS = 'global; a: scalar, default 2; v: vector, default <4,9,16>; on: scalar, switch, default 1; m: scalar, choices "p", "q, r", "s", default 2; formula; '


def grown(text, sets=(), decl=SCALARS):
    return shoot(make(decl + text, body, sets=['ka=0', *sets]), (0., 0., 5.), (0., 0., -1.))


for text, w in (('F(x) = x^2+1; = <F(3), F(F(1)), F(0)+F(a)>;', (10, 5, 6)), ('G(x) = H2(x,2); H2(a,b) = a*b; = G(<1,2,3>)*G(2);', (8, 16, 24)),
                ('A = B2(2); B2(x) = x*C; C = 5; = <A, B2(C), 0>;', (10, 25, 0)), ('x = 7; f(x) = x+1; = <x, f(1), x>;', (7, 2, 7)),
                ('i = 10; f(x) = x*i; = <sum(i,1,3,f(i)), 0, 0>;', (60, 0, 0)), ('f(N) = N*2; = <f(a)>;', (4, 4, 4)),
                ('= <sum(i,0,4,i^2), product(i,1,5,i), sum(i,1,2,sum(j,i,3,i*j))>;', (30, 120, 16)), ('= sum(i,1,3,<1,i,i^2>);', (3, 6, 14)),
                ('= <sum(i,2,1,i), product(i,2,1,i), sum(i,0.5,2.5,i)>;', (0, 1, 3)), ('= sum(i,2,1,<i>) + product(i,2,1,v);', (1, 1, 1)),
                ('n = 2*3; f(m) = sum(i,1,m,i); = <f(n), f(2), sum(i,-1,1,i)>;', (21, 3, 0)), ('= <sum(i,1,256,a), 0, 0>;', (512, 0, 0)),
                ('sum(p,q) = p-q; product = 3; = <sum(a,1), product, 0>;', (1, 3, 0)), ('is = 1<2; not = !(1<2) || 3==4; = <is, not, (2>1)+(a>=2)>;', (1, 0, 2)),
                ('n = 3; = <if(n,1,2), if(n-3,1,2), if(!n || n>2 && n,5,6)>;', (1, 2, 5)), ('n = 0/0; = <if(n,1,2), if(n==n,1,2), (n!=0)>;', (1, 2, 1)),
                ('= if(on, v, <0>)*<m>;', (8, 18, 32)), ('= sqrt(v) + <a>;', (4, 5, 6)), ('v2 = <1,2,3>; = v2^2 + v2^v2;', (2, 8, 36)),
                ('= clamp(<-1,0.5,2>,0,1) + max(<-1,1,2>,0);', (0, 1.5, 3)), ('= mix(<1>,<2>,<0,0.5,1>);', (1, 1.5, 2)), ('= atan2(<0,1,0>,1) + mod(v,5);', (4, math.pi / 4 + 4, 1)),
                ('= <tanh(0.5), erf(0.5), tanh(-40)>;', ((math.e - 1) / (math.e + 1), .5204998778130465, -1)), ('d = N.normalize(3*N) - 1; = <d, acos(V.L), (d > 0)>;', (0, 0, 0)),
                ('= <(1+2)*3>;', (9, 9, 9)), ('= <(1<2), ((1+a)*3 > 8), ((a))>;', (1, 1, 2)), ('predefined = 2; = <predefined>;', (2, 2, 2))):
    ok(text, grown(text), tuple(map(float, w)), 1e-9)
ok('switch', grown('= <on, m, 0>;', ['on=0', 'm=1']), (0., 1., 0.))
t = make('predefined; ki: constraint 0..50, default 3; kr: default 0.5; Cd: color; global; q: scalar; formula; = <1,2,3>;', body, sets=['ka=0', 'l.ki=20'])
ok('predefined', shoot(t, (0., 0., 5.), (0., 0., -1.)), (20., 40., 60.))
ok('predefined kr', t.scene.bodies[0].values['kr'], .5)
ok('lone CR', grown('// a comment\r = <1,2,3>;'), (1., 2., 3.))

for bad in ('formula; f(x) = f(x-1); = <f(1)>;', 'formula; f(x) = M*x; M = f(1); = <M>;', 'formula; f() = 1; = N;', 'formula; f(x,x) = x; = N;', 'formula; f(x) = x; = <f>;',
            'formula; f(x) = x; = <f(1,2)>;', 'formula; f(x) = y; = <f(1)>;', 'formula; f(x) = 1; f = 2; = N;', 'formula; N(x) = 1; = N;', 'formula; = <sum(i,1,257,i)>;',
            'formula; = <sum(i,1,kr,i)>;', 'formula; = <sum(1,1,2,3)>;', 'formula; = <max(0, 1<2)>;', 'formula; = Cd*(Cd > 1);', 'formula; = (1<2);', 'formula; = if(Cd,N,N);',
            'formula; = Cd + 1;', 'formula; = perlin(N,Cd,1,2);', 'predefined; q: default 1; formula; = N;', 'predefined; ki: default <1,1,1>; formula; = N;', 'formula; = <eta>;',
            'global; s: vector, switch; formula; = N;', 'global; s: scalar, choices "a; formula; = N;', 'formula; reflected = N.L; = N;', 'formula; refracted = ki; = N;',
            'formula; M = H; reflected = M; = N;', 'formula; ambient = 1; = N;', 'formula; emission = <eta>; = N;', 'formula; reflected = nothing; = N;'):
    try:
        make(bad, body)
    except Wrong:
        count += 1
    else:
        raise AssertionError('accepted: ' + bad)

for bad in ('formula; = 1;', 'formula; = <1,2,3>', 'formula; = <1.N,0,0>;', 'formula; = Cd*N.L*1;', 'formula; = 1/N;', 'formula; M = M; = N;',
            'formula; A = B2; B2 = A; = N;', 'formula; Cd = 1; = N;', 'formula; = background;', 'formula; = <1<2,0,0>;', 'formula; = if(1<2<3,N,N);',
            'formula; = if(N<L,N,N);', 'formula; = if(1<2,1,N);', 'global; global; formula; = N;', 'global; a: scalar; a: vector; formula; = N;',
            'global; a: scalar, default <1,2,3>; formula; = N;', 'global; a: scalar, constraint 2..1; formula; = N;', 'formula; = foo;', 'formula; = N; = L;',
            'invariants; kr+ka=1; formula; = N;', 'invariants; kr=1; kr+kt=1; kt=1; formula; = N;', 'invariants; Cd=1; formula; = N;',
            'global; a: scalar, slider, slider; formula; = N;', 'global; sin: scalar; formula; = N;', 'formula; = N /* ;'):
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
rows, *_ = r.render(t, W, Hh)
best = max((rows[y][x][0], x, y) for y in range(Hh) for x in range(W))
px = (1 + P[0] / (D - P[2]) / (math.tan(math.radians(20)) * W / Hh)) * W / 2
assert abs(best[1] + .5 - px) <= 1.5 and abs(best[2] + .5 - Hh / 2) <= 1.5, (best, px)
print('highlight: pixel', best[1:], 'expected x', round(px - .5, 2), 'y', Hh / 2 - .5)

# ---- image the right way up and round: a body at +x +y appears right and top
t = make('formula; = Cd;', 'bodies; s: sphere, center <1,1,0>, radius 0.3; lights; ' + CAM, sets=['ka=1', 's.Cd=<1,1,1>'])
rows, *_ = r.render(t, 40, 30)
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
# ---- weights of rays, ambient light and emission as formulas
for depth in range(1, 8):
    t = make('formula; reflected = <0.5,0.25,1>*kr; ambient = <1,2,3>; = N;', M, sets=['*.kr=0.8'], depth=depth)
    ok('coloured mirrors', shoot(t, (0., 0., 0.), (.1, 0., -1.)), tuple(a * sum((w * .8) ** k for k in range(depth)) for a, w in zip((1, 2, 3), (.5, .25, 1))))
t = make('formula; reflected = 0.5; emission = <1,1,1>; = N;', M, sets=['*.Cd=<1,0.5,0.25>', 'ka=0.2'], depth=2)
ok('emission is added', shoot(t, (0., 0., 0.), (.1, 0., -1.)), (1.8, 1.65, 1.575))
t = make('formula; emission = <0.5,0,0>; reflected = <0,0.5,0>; = N*emission;', M, sets=['*.Cd=<1,1,1>', 'ka=1'], depth=2)
ok('a name that is read is a macro', shoot(t, (0., 0., 0.), (.1, 0., -1.)), (1., 1.5, 1.))
FRESNEL = 'formula; F0 = ((1-eta)/(1+eta))^2; F = if(total, 1, F0+(1-F0)*(1-max(0,N.V))^5); reflected = kr*F; refracted = kt*(1-F); ambient = <0>; = N;'
for index in (0.5, 1.0, 1.5, 2.4):
    # straight through a ball, without inner reflections: (1 - F0)^2 of the background; straight back: F0
    f0 = ((1 - index) / (1 + index)) ** 2
    ball = 'bodies; b: sphere, center <0,0,0>, radius 1, refractive_index %g; lights; %s' % (index, CAM)
    t = make(FRESNEL, ball, sets=['*.kt=1', 'background=<1,0.5,0>'], depth=3)
    ok('Fresnel through', shoot(t, (0., 0., 5.), (0., 0., -1.)), ((1 - f0) ** 2, .5 * (1 - f0) ** 2, 0.))
    t = make(FRESNEL, ball, sets=['*.kr=1', 'background=<1,0.5,0>'], depth=3)
    ok('Fresnel back', shoot(t, (0., 0., 5.), (0., 0., -1.)), (f0, .5 * f0, 0.))
# beyond the critical angle of a pane seen from behind all is mirrored, and nothing goes through
pane = 'bodies; pane: rectangle, <9,9,0>,<-9,9,0>,<-9,-9,0>, refractive_index 1.5; lights; ' + CAM
t = make(FRESNEL, pane, sets=['*.kr=0.75', '*.kt=0.5', 'background=<1,1,1>'])
for deg in (41.8, 41.82, 60):
    th = math.radians(deg)
    f0, c = .04, math.cos(th)
    f = f0 + (1 - f0) * (1 - c) ** 5
    ok('total reflection', shoot(t, (0., 0., 3.), (math.sin(th), 0., -c)), (.75 if deg > 41.811 else .75 * f + .5 * (1 - f),) * 3)
t = make('formula; reflected = <0,0,0>; = N;', 'bodies; s: sphere, center <0,0,0>, radius 1; n: rectangle, <-9,-9,8>,<9,-9,8>,<9,9,8>; lights; ' + CAM,
         sets=['*.kr=1', 'background=<1,1,1>', 'ka=0'])
ok('a weight of 0 sends no ray', shoot(t, (0., 0., 5.), (0., 0., -1.)), (0., 0., 0.))
# ---- lights.  The floor y = 0 is seen from above at (x, z)
FLOOR = 'bodies; floor: rectangle, <-50,0,-50>, <50,0,-50>, <50,0,50>, opaque, matte; %s lights; %s; ' + CAM


def lit(formula, light, at=(0., 0.), others='', points=1, sets=(), turns=1, **k):
    """-> mean and variance of one pass, at a point of the floor"""
    t = make(formula, FLOOR % (others, light), sets=['ka=0', '*.Cd=<1,1,1>', *sets], **k)
    t.points, total = points, (0., 0., 0.)
    for turn in range(turns):
        t.turn = (turn, turns, 0)
        total = vadd(total, shoot(t, (at[0], .01, at[1]), (0., -1., 0.)))
    return vover(total, turns), vover(t.variance, turns)


ok('directional', lit('formula; = <N.L, dist, (getx(L) > 0)>;', 'l: directional, <-3,-4,0>')[0], (.8, 1e30, 1.))
ok('against the direction of travel', lit('formula; = L;', 'l: directional, <0,-2,1.5>')[0], (0., .8, -.6))
ok('from below', lit('formula; = <1>;', 'l: directional, <0,1,0>')[0], (0., 0., 0.))
ok('from below, without shadow rays', lit('formula; = <N.L>;', 'l: directional, <0,1,0>', shadows=False)[0], (-1., -1., -1.))
ok('a body far away hides the sun', lit('formula; = <1>;', 'l: directional, <0,-1,0>', others='b: sphere, center <0,9e5,0>, radius 1;')[0], (0., 0., 0.))

SPOT = 'l: spot, <0,2,0>, target <0,-1,0>, angle 30, soft 10'
for degrees, factor in ((0, 1), (19.9, 1), (22.5, .84375), (25, .5), (27.5, .15625), (30.1, 0), (60, 0)):
    at, inside = (2 * math.tan(math.radians(degrees)), 0.), float(factor > 0)
    ok('spot %g' % degrees, lit('formula; = IL;', SPOT, at)[0], (factor,) * 3, 1e-9)
    ok('spot, what does not read IL', lit('formula; = <1>;', SPOT, at)[0], (inside,) * 3)
    ok('spot, visible', lit('formula; = IL + <visible>;', SPOT, at)[0], (factor + 1.,) * 3, 1e-9)
    ok('spot, no shadow rays', lit('formula; = <1>;', SPOT, at, shadows=False)[0], (inside,) * 3)
for angle, x, factor in ((45, 1.99, 1), (45, 2.01, 0), (90, 1000, 1), (180, 3, 1), (1e-3, 3e-5, 1), (1e-3, 4e-5, 0)):
    ok('sharp spot', lit('formula; = IL;', 'l: spot, <0,2,0>, target <0,1,0>, angle %f' % angle, (x / 25., 0.) if x == 1000 else (x, 0.))[0], (float(factor),) * 3)
ok('upwards', lit('formula; = IL;', 'l: spot, <0,2,0>, target <0,3,0>, angle 179.9')[0], (0., 0., 0.))

for x, z in ((0., 0.), (2., 1.), (-7., 3.)):     # a sphere of radius 1 at a height of 3
    D = math.sqrt(x * x + z * z + 9)
    ok('sphere, 1/dist^2', lit('formula; = <1/dist^2>;', 'l: sphere, center <0,3,0>, radius 1', (x, z), points=40)[0][0],
       math.log((D + 1) / (D - 1)) / (2 * D), 2e-5)                    # integral over its zones
    ok('sphere, form factor', lit('formula; P = point + dist*L; = <max(0,N.L)*max(0,-(L.(P - <0,3,0>)))/dist^2>;', 'l: sphere, center <0,3,0>, radius 1',
                                  (x, z), points=100)[0][0], 3 / D / (4 * D * D), 2e-5)
# a rectangle: Lambert's formula for polygons
for x, z in ((0., 0.), (1.5, -.5), (-4., 3.)):
    corners = [(a - x, 2., b - z) for a, b in ((-1., -.5), (1., -.5), (1., .5), (-1., .5))]
    angles = [(normalize(p), normalize(q)) for p, q in zip(corners, corners[1:] + corners[:1])]
    polygon = abs(sum(acos(dot(p, q)) * normalize(cross(p, q))[1] for p, q in angles)) / (2 * math.pi)
    ok('rectangle', lit('formula; = <max(0,N.L)*max(0,L.<0,1,0>)/dist^2>;', 'l: rectangle, <-1,2,-0.5>, <1,2,-0.5>, <1,2,0.5>', (x, z), points=40)[0][0],
       math.pi * polygon / 2, 2e-5)
for corners in ('<-1,2,-0.5>, <1,2,-0.5>, <1,2,0.5>', '<1,2,0.5>, <1,2,-0.5>, <-1,2,-0.5>'):
    ok('both sides', lit('formula; = <1>;', 'l: rectangle, ' + corners, points=3)[0], (1., 1., 1.))
# the edge of a roof halves a square light, and one pass is 0 or 1
mean, variance = lit('formula; = <1>;', 'l: rectangle, <-1,2,-1>, <1,2,-1>, <1,2,1>', others='roof: rectangle, <-9,1,-9>, <0,1,-9>, <0,1,9>;', points=10, sets=['l.ki=0.5'])
ok('half hidden', mean, (.5 * .5,) * 3)
ok('variance of a pass', variance, (.25 * .25,) * 3)

# environments: under white light a matte surface has its own colour; a ball hides (r/D)^2 cos
WHITE_SKY = 'l: environment, rotate 20'
for points, tolerance in ((8, 1e-2), (32, 6e-4)):
    ok('white', lit('formula; = IL*Cd*max(0,N.L);', WHITE_SKY, points=points, sets=['floor.Cd=<0.2,0.5,1>', 'l.IL=<1,0.5,1>'])[0], (.2, .25, 1.), tolerance)
ok('white, many turns', lit('formula; = <max(0,N.L)>;', WHITE_SKY, points=4, turns=64)[0], (1., 1., 1.), 1e-3)
ok('a ball above', lit('formula; = <max(0,N.L)>;', WHITE_SKY, points=32, turns=16, others='b: sphere, center <1,2,0.5>, radius 1;')[0],
   (1 - 2 / 5.25 ** 1.5,) * 3, 1e-3)
ok('all directions', lit('formula; = <1>;', WHITE_SKY, points=8, shadows=False)[0], (4., 4., 4.), 1e-9)
ok('dist', lit('formula; = <dist>;', WHITE_SKY, points=8, shadows=False)[0][0] / 4e30, 1., 1e-9)
# one pass draws a direction evenly: E = 4 cos above, so the variance is (1/2) 16/3 - 1
ok('variance', lit('formula; = <max(0,N.L)>;', WHITE_SKY, points=64)[1], (8 / 3 - 1,) * 3, 1e-2)
rows = [[(float(i), float(j), 1.) for i in range(8)] for j in range(4)]
d = lambda longitude, latitude: tuple(map(float, (math.cos(latitude) * math.sin(longitude), math.sin(latitude), math.cos(latitude) * math.cos(longitude))))
for turned in (0, 90, -30, 400):
    sky, back = r.lights.Environment(rows, turned), math.radians(turned)
    ok('the middle is +z', sky.radiance(d(back, 0.)), (3.5, 1.5, 1.), 1e-9)
    ok('+x is left of the middle', sky.radiance(d(back + math.pi / 2, 0.)), (1.5, 1.5, 1.), 1e-9)
    ok('up is +y', sky.radiance(d(back + math.pi / 2, 1.5)), (1.5, 0., 1.), 1e-9)
    ok('the edges are -z', sky.radiance(d(back + math.pi, -1.5)), (3.5, 3., 1.), 1e-9)
    ok('a texel', sky.radiance(d(back + math.pi * 5 / 8, math.pi / 8)), (1., 1., 1.), 1e-9)
ok('no numbers', r.lights.Environment([[(NAN, -1., 2.)]], 0).radiance((0., 1., 0.)), (0., 0., 2.))
t = make('formula; = <0>;', 'bodies; m: sphere, center <0,0,0>, radius 1; lights; l: environment; ' + CAM, sets=['m.kr=0.5', 'ka=0', 'l.IL=<1,0.5,0>', 'l.ki=0.5', 'background=<0.1,0,0>'])
ok('a ray that leaves the scene', shoot(t, (0., 0., 5.), (0., 1., 0.)), (.6, .25, 0.))
ok('a mirror', shoot(t, (0., 0., 5.), (0., 0., -1.)), (.3, .125, 0.))

for bad in ('directional, <0,0,0>', 'directional, <0,0,0>, <1,1,1>', 'spot, <0,0,0>, target <0,0,0>, angle 3', 'spot, <0,0,0>, target <0,1,0>, angle 0',
            'spot, <0,0,0>, target <0,1,0>, angle 181', 'spot, <0,0,0>, target <0,1,0>, angle 20, soft 21', 'spot, <0,0,0>, target <0,1,0>, angle 20, soft -1',
            'sphere, center <0,0,0>, radius 0', 'rectangle, <0,0,0>, <1,0,0>, <2,0,0>', 'environment, 3', 'environment; m: environment', 'lamp, <0,0,0>'):
    try:
        make('formula; = N;', FLOOR % ('', 'l: ' + bad))
    except Wrong:
        count += 1
    else:
        raise AssertionError('accepted: ' + bad)
print(count, 'checks passed')
