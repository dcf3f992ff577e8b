#!/usr/bin/env python3
"""Reference renderer for the languages of the manual (the oracle).  Plain Python 3.11, IEEE double throughout.
Standard library only, but for scenes with meshes (mesh.py) and formulas with textures (images.py).

Written from the description of the languages alone; simple rather than fast.  "language x.y" in the comments cites what is followed
in docs/manual/src: 1 language.md (1.1 text and grammar, 1.2 operators and functions, 1.3 variables and parameters), 2 scenes.md, 3 pictures.md.
"[CHOICE n]" marks a place where the description leaves a choice; they are listed in CHOICES.md.

Parts:  1 arithmetic (total: nothing raises)   2 lexer   3 formula parser   4 types and code
        5 parameters and invariants            6 scene   7 rays             8 picture    9 command line
"""
import argparse, bisect, math, multiprocessing, os, re, struct, sys
from fractions import Fraction
import images
import lights

NAN, INF = math.nan, math.inf


class Wrong(Exception):
    """The input is wrong (exit status 1).  Only the first error is reported."""


def warn(text):
    print('warning: ' + text, file=sys.stderr)


# =====================================================================================================================
# 1  Arithmetic (language 1.2).  Python raises where IEEE gives inf or NaN; these do not.
# =====================================================================================================================
def div(x, y):
    if y != 0:                                   # also true for NaN
        return x / y
    if x != x or x == 0:
        return NAN
    return math.copysign(INF, x) * math.copysign(1.0, y)


def power(x, y):                                 # C's pow
    try:
        return math.pow(x, y)                    # handles x^0 = 1, 1^NaN = 1, infinities as C does
    except OverflowError:                        # too large
        odd = y == math.floor(y) and math.fmod(y, 2) != 0
        return -INF if x < 0 and odd else INF
    except ValueError:
        if x == 0:                               # 0 ^ negative
            odd = y == math.floor(y) and math.fmod(y, 2) != 0
            return math.copysign(INF, x) if odd else INF
        return NAN                               # negative ^ fraction


def sqrt(x):
    return math.sqrt(x) if x >= 0 else NAN       # sqrt(-0.0) is -0.0; NaN >= 0 is false


def floor(x):
    if x != x or math.isinf(x):
        return x
    return math.copysign(float(math.floor(x)), x) if 0 <= x < 1 else float(math.floor(x))   # keeps -0.0


def ceil(x):
    return -floor(-x)


def exp(x):
    try:
        return math.exp(x)
    except OverflowError:
        return INF


def exp2(x):
    try:
        return math.exp2(x)
    except OverflowError:
        return INF


def log(x):
    return math.log(x) if x > 0 else (-INF if x == 0 else NAN)


def log2(x):
    return math.log2(x) if x > 0 else (-INF if x == 0 else NAN)


def sin(x):
    return math.sin(x) if math.isfinite(x) else NAN


def cos(x):
    return math.cos(x) if math.isfinite(x) else NAN


def tan(x):
    return math.tan(x) if math.isfinite(x) else NAN


def acos(x):
    return math.acos(x) if -1 <= x <= 1 else NAN


def asin(x):
    return math.asin(x) if -1 <= x <= 1 else NAN


def sign(x):                                     # [CHOICE 1] sign(NaN) = NaN
    return 1.0 if x > 0 else (-1.0 if x < 0 else (0.0 if x == 0 else NAN))


def fract(x):
    return x - floor(x)


def mod(x, y):
    return x - y * floor(div(x, y))


def step(e, x):
    return 0.0 if x < e else 1.0


def minimum(x, y):                               # language 1.2: x if x < y, else y (also with NaN)
    return x if x < y else y


def maximum(x, y):
    return x if x > y else y


def min3(x, y, z):
    return minimum(minimum(x, y), z)


def max3(x, y, z):
    return maximum(maximum(x, y), z)


def clamp(x, lo, hi):
    return minimum(maximum(x, lo), hi)


def mix(a, b, t):
    return a * (1 - t) + b * t


def smoothstep(e0, e1, x):
    t = clamp(div(x - e0, e1 - e0), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def radians(x):
    return x * math.pi / 180


def unit_dot(a, b):                              # directions of unit length: rounding never leaves -1..1; NaN stays NaN
    x = dot(a, b)
    return 1.0 if x > 1 else (-1.0 if x < -1 else x)


# ---- vectors are tuples of three floats
def vneg(a): return (-a[0], -a[1], -a[2])
def vadd(a, b): return (a[0] + b[0], a[1] + b[1], a[2] + b[2])
def vsub(a, b): return (a[0] - b[0], a[1] - b[1], a[2] - b[2])
def vmul(a, b): return (a[0] * b[0], a[1] * b[1], a[2] * b[2])
def vdiv(a, b): return (div(a[0], b[0]), div(a[1], b[1]), div(a[2], b[2]))
def vscale(a, s): return (a[0] * s, a[1] * s, a[2] * s)
def scalev(s, a): return (a[0] * s, a[1] * s, a[2] * s)
def vover(a, s): return (div(a[0], s), div(a[1], s), div(a[2], s))
def dot(a, b): return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
def vec(x, y, z): return (x, y, z)
def getx(a): return a[0]
def gety(a): return a[1]
def getz(a): return a[2]
def vmin(a, b): return (minimum(a[0], b[0]), minimum(a[1], b[1]), minimum(a[2], b[2]))
def vmax(a, b): return (maximum(a[0], b[0]), maximum(a[1], b[1]), maximum(a[2], b[2]))
def vmix(a, b, t): return (mix(a[0], b[0], t), mix(a[1], b[1], t), mix(a[2], b[2], t))
def length(a): return math.sqrt(dot(a, a)) if dot(a, a) == dot(a, a) else NAN
def distance(a, b): return length(vsub(a, b))
def normalize(a): return vover(a, length(a))


def by_components(function, vectors, *args):
    """A function of scalars on vectors: vectors[i] says whether args[i] is one; a scalar counts for each component."""
    return tuple(function(*(a[k] if v else a for a, v in zip(args, vectors))) for k in range(3))


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def reflect(i, n):                               # i - 2(n.i)n
    return vsub(i, vscale(n, 2 * dot(n, i)))


# ---- Perlin's improved noise (Ken Perlin, "Improving Noise", SIGGRAPH 2002; his Java reference, ImprovedNoise.java)
PERM = [151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69, 142, 8, 99, 37, 240,
        21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219, 203, 117, 35, 11, 32, 57, 177, 33, 88,
        237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175, 74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83,
        111, 229, 122, 60, 211, 133, 230, 220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216,
        80, 73, 209, 76, 132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173, 186,
        3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206, 59, 227, 47, 16, 58,
        17, 182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163, 70, 221, 153, 101, 155, 167, 43, 172, 9,
        129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232, 178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193,
        238, 210, 144, 12, 191, 179, 162, 241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157,
        184, 84, 204, 176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141, 128,
        195, 78, 66, 215, 61, 156, 180]
assert sorted(PERM) == list(range(256))
PERM = PERM + PERM


def _fade(t): return t * t * t * (t * (t * 6 - 15) + 10)
def _lerp(t, a, b): return a + t * (b - a)


def _grad(h, x, y, z):
    h &= 15
    u = x if h < 8 else y
    v = y if h < 4 else (x if h == 12 or h == 14 else z)
    return (u if h & 1 == 0 else -u) + (v if h & 2 == 0 else -v)


def noise(x, y, z):
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        return NAN                               # [CHOICE 2]
    X, Y, Z = math.floor(x), math.floor(y), math.floor(z)
    x, y, z = x - X, y - Y, z - Z
    X, Y, Z = X & 255, Y & 255, Z & 255
    u, v, w = _fade(x), _fade(y), _fade(z)
    p = PERM
    A, B = p[X] + Y, p[X + 1] + Y
    AA, AB, BA, BB = p[A] + Z, p[A + 1] + Z, p[B] + Z, p[B + 1] + Z
    return _lerp(w, _lerp(v, _lerp(u, _grad(p[AA], x, y, z), _grad(p[BA], x - 1, y, z)),
                             _lerp(u, _grad(p[AB], x, y - 1, z), _grad(p[BB], x - 1, y - 1, z))),
                    _lerp(v, _lerp(u, _grad(p[AA + 1], x, y, z - 1), _grad(p[BA + 1], x - 1, y, z - 1)),
                             _lerp(u, _grad(p[AB + 1], x, y - 1, z - 1), _grad(p[BB + 1], x - 1, y - 1, z - 1))))


def perlin(pt, a, b, n):                         # sum over i < n of noise(b^i pt) / a^i
    count = 0 if n != n else int(min(max(n, 0.0), 32.0))
    total, fb, fa = 0.0, 1.0, 1.0
    for _ in range(count):
        total += div(noise(pt[0] * fb, pt[1] * fb, pt[2] * fb), fa)
        fb, fa = fb * b, fa * a
    return total


# =====================================================================================================================
# 2  Lexer (language 1.1), the same for formulas and scenes
# =====================================================================================================================
NUMBER = re.compile(r'(?:[0-9]+\.[0-9]+|\.[0-9]+|[0-9]+\.(?!\.)|[0-9]+)(?:[eE][+-]?[0-9]+)?')
IDENT = re.compile(r'[A-Za-z_][A-Za-z0-9_]*')
PUNCT = ('..', '<=', '>=', '==', '!=', '&&', '||') + tuple(';:,.+-*/^()<>=!')
KEYWORDS = {'global', 'body_specific', 'light_specific', 'invariants', 'formula', 'bodies', 'lights', 'camera'}


class Token:
    __slots__ = ('kind', 'text', 'value', 'where')


def lex(text, name):
    """-> tokens of kind 'number', 'ident', 'uses', a punctuation mark, or 'end'."""
    text = text.removeprefix('\ufeff')
    tokens, i = [], 0

    # A line ends with LF, CRLF or a lone CR; the positions where lines begin.
    begins = [0] + [m.end() for m in re.finditer('\r\n|\n|\r', text)]

    def line_end(start):
        return min((x for x in (text.find('\n', start), text.find('\r', start)) if x >= 0), default=len(text))

    def add(kind, start, end, value=None):
        t = Token()
        t.kind, t.text, t.value = kind, text[start:end], value
        line = bisect.bisect_right(begins, start)
        t.where = '%s:%d:%d' % (name, line, start - begins[line - 1] + 1)
        tokens.append(t)
        return t

    while i < len(text):
        c = text[i]
        if c in ' \t\r\n\f\v':
            i += 1
        elif text.startswith('//', i):
            i = line_end(i)
        elif text.startswith('/*', i):
            j = text.find('*/', i + 2)
            if j < 0:
                raise Wrong('%s: comment not closed' % name)
            i = j + 2
        elif text.startswith('#uses', i):        # PATH: raw text to ';' on one line, trimmed
            j = text.find(';', i, line_end(i))
            if j < 0:
                raise Wrong("%s: '#uses' needs a ';' on its line" % name)
            add('uses', i, j + 1, text[i + 5:j].strip())
            i = j + 1
        elif c == '"':                           # STRING: to the next quote on the line
            j = text.find('"', i + 1, line_end(i))
            if j < 0:
                raise Wrong('%s: a text without its closing quote' % name)
            add('string', i, j + 1, text[i + 1:j])
            i = j + 1
        elif m := NUMBER.match(text, i):
            t = add('number', i, m.end(), float(m.group()))
            i = m.end()
            if IDENT.match(text, i):
                raise Wrong('%s: a number before a name: %s...; use parentheses' % (t.where, t.text))
        elif m := IDENT.match(text, i):
            add('ident', i, m.end())
            i = m.end()
        else:
            for p in PUNCT:
                if text.startswith(p, i):
                    add(p, i, i + len(p))
                    i += len(p)
                    break
            else:
                raise Wrong('%s: unexpected character %r' % (name, c))
    add('end', len(text), len(text))
    return tokens


class Parser:
    def __init__(self, text, name):
        self.tokens, self.at, self.file = lex(text, name), 0, name

    def peek(self, *kinds):
        return self.tokens[self.at].kind in kinds

    def word(self, *words):
        t = self.tokens[self.at]
        return t.kind == 'ident' and t.text in words

    def next(self):
        self.at += 1
        return self.tokens[self.at - 1]

    def fail(self, expected):
        t = self.tokens[self.at]
        raise Wrong('%s: expected %s, found %r' % (t.where, expected, t.text or 'the end'))

    def need(self, kind):
        if not self.peek(kind):
            self.fail(repr(kind))
        return self.next()

    def need_word(self, *words):
        if not self.word(*words):
            self.fail(' or '.join(map(repr, words)))
        return self.next()

    def accept(self, kind):
        if self.peek(kind):
            self.next()
            return True
        return False

    def name(self):
        t = self.need('ident')
        if t.text in KEYWORDS:
            raise Wrong('%s: %r may not name anything' % (t.where, t.text))
        return t

    def snum(self):                              # SNUM = [ "-" ] NUMBER
        negative = self.accept('-')
        v = self.need('number').value
        return -v if negative else v

    def const_vector(self):
        self.need('<')
        x = self.snum(); self.need(',')
        y = self.snum(); self.need(',')
        z = self.snum(); self.need('>')
        return (x, y, z)


# =====================================================================================================================
# 3  Formula parser (language 1.1).  Expressions become tuples (kind, where, ...).
# =====================================================================================================================
class Param:
    def __init__(self, name, owner, type, lo, hi, default):
        self.name, self.owner, self.type, self.lo, self.hi, self.default = name, owner, type, lo, hi, default
        self.whole = False                       # switch, choices

    def clamp(self, v):
        if self.type == 'T':                     # a texture
            return v
        one = lambda x: min(max(float(math.floor(x + 0.5)) if self.whole else x, self.lo), self.hi)
        return one(v) if self.type == 'S' else tuple(map(one, v))


def predefined():                                # language 1.3
    return {p.name: p for p in (
        Param('Cd', 'body', 'V', 0.0, 1.0, (0.8, 0.8, 0.8)), Param('kr', 'body', 'S', 0.0, 1.0, 0.0),
        Param('kt', 'body', 'S', 0.0, 1.0, 0.0), Param('ki', 'light', 'S', 0.0, 1.0, 1.0),
        Param('IL', 'light', 'V', 0.0, 1.0, (1.0, 1.0, 1.0)), Param('ka', 'global', 'S', 0.0, 1.0, 0.1),
        Param('Ia', 'global', 'V', 0.0, 1.0, (1.0, 1.0, 1.0)), Param('background', 'global', 'V', 0.0, 1.0, (0.0, 0.0, 0.0)))}


THESIS_NAMES = set('sqrt floor exp log sin cos tan getx gety getz min max perlin pow '
                   'N L V R alpha beta gamma point if'.split()) | set(predefined())


class FormulaParser(Parser):
    SECTIONS = ('global', 'body_specific', 'light_specific', 'invariants', 'predefined')

    def section(self):
        """Whether a section begins here.  `predefined` is a keyword only before a semicolon."""
        return self.word(*self.SECTIONS) and self.tokens[self.at + 1].kind == ';'

    def formula_file(self):
        f = Formula()
        if self.peek('uses'):
            self.next()
        seen = set()
        while self.section():
            t = self.next()
            self.need(';')
            if t.text in seen:
                raise Wrong('%s: section %s twice' % (t.where, t.text))
            seen.add(t.text)
            while self.peek('ident') and not self.word('formula') and not self.section():
                if t.text == 'invariants':
                    self.invariant(f)
                elif t.text == 'predefined':
                    self.predefined(f)
                else:
                    self.decl(f, {'global': 'global', 'body_specific': 'body', 'light_specific': 'light'}[t.text])
        self.need_word('formula')
        self.need(';')
        while self.peek('ident'):
            t = self.name()
            self.new_name(f, t)
            if self.accept('('):                 # a function
                args = [self.need('ident').text]
                while self.accept(','):
                    args.append(self.need('ident').text)
                self.need(')')
                if len(set(args)) != len(args):
                    raise Wrong('%s: two arguments of %s have one name' % (t.where, t.text))
                self.need('=')
                f.functions[t.text] = (args, self.value())
            else:
                self.need('=')
                f.macros[t.text] = self.value()
            self.need(';')
        f.result_where = self.need('=').where
        f.result = self.expr()
        self.need(';')
        if not self.peek('end'):
            self.fail('nothing after the formula')
        return f

    def new_name(self, f, t):
        if t.text in THESIS_NAMES:
            raise Wrong('%s: %r is already taken by the language' % (t.where, t.text))
        if t.text in f.params or t.text in f.macros or t.text in f.functions:
            raise Wrong('%s: %r is defined twice' % (t.where, t.text))

    def decl(self, f, owner):
        t = self.name()
        self.new_name(f, t)
        self.need(':')
        type = {'scalar': 'S', 'vector': 'V', 'texture': 'T'}[self.need_word('scalar', 'vector', 'texture').text]
        f.params[t.text] = self.attributes(t, Param(t.text, owner, type, -INF, INF, None))

    def predefined(self, f):
        """Another range, default or widget of a predefined parameter; its type and meaning stay."""
        t = self.need('ident')
        old = predefined().get(t.text)
        if old is None or t.text in f.changed:
            raise Wrong('%s: %r is no predefined parameter, or is there twice' % (t.where, t.text))
        self.need(':')
        f.changed[t.text] = self.attributes(t, old, first=True)

    def attributes(self, t, p, first=False):
        """The attributes of a parameter, to the semicolon; p has the range and default where they give none."""
        default, seen = p.default, set()
        while first or self.accept(','):
            first = False
            a = self.need_word('constraint', 'default', 'slider', 'color', 'switch', 'choices')
            if a.text in seen:
                raise Wrong('%s: %s twice' % (a.where, a.text))
            seen.add(a.text)
            if a.text == 'constraint':
                p.lo = self.snum(); self.need('..'); p.hi = self.snum()
                if p.lo > p.hi:
                    raise Wrong('%s: empty range' % a.where)
            elif a.text == 'default' and p.type == 'T':                # the path is relative to the formula file
                default = images.Texture(os.path.join(os.path.dirname(self.file), self.need('string').value))
            elif a.text == 'default':
                is_vector = self.peek('<')
                default = self.const_vector() if is_vector else self.snum()
                if is_vector != (p.type == 'V'):
                    raise Wrong('%s: the default is of the other type' % a.where)
            elif a.text in ('switch', 'choices'):    # a whole number; [CHOICE 24]
                count = 2
                if a.text == 'choices':
                    self.need('string')
                    count = 1
                    while self.peek(',') and self.tokens[self.at + 1].kind == 'string':
                        self.next(); self.next()
                        count += 1
                if p.type != 'S':
                    raise Wrong('%s: %s is for scalars' % (a.where, a.text))
                p.lo, p.hi, p.whole = 0.0, count - 1.0, True
        if p.whole and ('constraint' in seen or {'switch', 'choices'} <= seen):
            raise Wrong('%s: %s has two ranges' % (t.where, t.text))
        self.need(';')
        if p.type == 'T':                        # a texture without default is white
            p.default = default or images.white
        elif default is None:                    # the value nearest 0 in the range
            p.default = p.clamp(0.0 if p.type == 'S' else (0.0, 0.0, 0.0))
        else:
            p.default = p.clamp(default)
            if p.default != default:
                warn('%s: default of %s clamped to its range' % (t.where, t.text))
        return p

    def invariant(self, f):
        names = [self.need('ident')]
        while self.accept('+'):
            names.append(self.need('ident'))
        if not self.peek('=', '<='):
            self.fail("'=' or '<='")
        op = self.next().kind
        one = self.need('number')
        if one.value != 1:
            raise Wrong('%s: expected 1' % one.where)
        self.need(';')
        f.invariants.append((op, names))

    # ---- expressions
    def binary(self, operand, ops):              # left-associative level
        left = operand()
        while self.peek(*ops):
            t = self.next()
            left = ('call', t.where, t.kind, (left, operand()))
        return left

    def expr(self): return self.binary(self.term, ('+', '-'))
    def term(self): return self.binary(self.power, ('*', '/', '.'))

    def power(self):                             # power = unary [ "^" power ]
        base = self.unary()
        if self.peek('^'):
            t = self.next()
            return ('call', t.where, '^', (base, self.power()))
        return base

    def unary(self):                             # binds tighter than ^
        if self.peek('-'):
            t = self.next()
            return ('call', t.where, 'neg', (self.unary(),))
        return self.atom()

    def atom(self):
        if self.peek('number'):
            t = self.next()
            return ('number', t.where, t.value)
        if self.accept('('):
            e = self.value()
            self.need(')')
            return e
        if self.peek('<'):
            t = self.next()
            x = self.expr()
            if self.accept('>'):                 # three equal components
                return ('call', t.where, '<>', (x,))
            self.need(',')
            y = self.expr(); self.need(',')
            z = self.expr(); self.need('>')
            return ('call', t.where, '<>', (x, y, z))
        if self.peek('ident'):
            t = self.name()
            if not self.accept('('):
                return ('name', t.where, t.text)
            if t.text == 'if':
                c = self.cond(); self.need(',')
                a = self.expr(); self.need(',')
                b = self.expr(); self.need(')')
                return ('if', t.where, c, a, b)
            args = [self.expr()]
            while self.accept(','):
                args.append(self.expr())
            self.need(')')
            return ('call', t.where, t.text, tuple(args))
        self.fail('an expression')

    # ---- conditions: ('or'|'and', where, a, b), ('not', where, a), ('cmp', where, op, x, y), ('scalar', where, x)
    def value(self):
        """expr | cond, as an expression: a condition is a scalar 0 or 1."""
        where, c = self.tokens[self.at].where, self.cond()
        return c[2] if c[0] == 'scalar' else ('truth', where, c)

    def cond(self):
        a = self.cond_and()
        while self.peek('||'):
            a = ('or', self.next().where, a, self.cond_and())
        return a

    def cond_and(self):
        a = self.cond_not()
        while self.peek('&&'):
            a = ('and', self.next().where, a, self.cond_not())
        return a

    def cond_not(self):
        # "(" cond ")" needs no case of its own: it is an atom, a scalar 0 or 1, and holds if it is not 0.
        if self.peek('!'):
            return ('not', self.next().where, self.cond_not())
        where, x = self.tokens[self.at].where, self.expr()
        if not self.peek('<', '<=', '>', '>=', '==', '!='):
            return ('scalar', where, x)
        t = self.next()
        return ('cmp', t.where, t.kind, x, self.expr())


# =====================================================================================================================
# 4  Types and code (language 1.2, 1.3).  The formula becomes one Python function, one operation a line.
# =====================================================================================================================
OVERLOADS = {}                                   # name -> [(argument types, result type, Python text with {0} {1} ...)]


def op(name, types, result, code):
    OVERLOADS.setdefault(name, []).append((types, result, code))


op('neg', 'S', 'S', '-{0}');             op('neg', 'V', 'V', 'vneg({0})')
op('+', 'SS', 'S', '{0} + {1}');         op('+', 'VV', 'V', 'vadd({0}, {1})')
op('-', 'SS', 'S', '{0} - {1}');         op('-', 'VV', 'V', 'vsub({0}, {1})')
op('*', 'SS', 'S', '{0} * {1}');         op('*', 'VV', 'V', 'vmul({0}, {1})')
op('*', 'VS', 'V', 'vscale({0}, {1})');  op('*', 'SV', 'V', 'scalev({0}, {1})')
op('/', 'SS', 'S', 'div({0}, {1})');     op('/', 'VV', 'V', 'vdiv({0}, {1})')
op('/', 'VS', 'V', 'vover({0}, {1})')
op('.', 'VV', 'S', 'dot({0}, {1})')
op('^', 'SS', 'S', 'power({0}, {1})');   op('pow', 'SS', 'S', 'power({0}, {1})')
op('<>', 'SSS', 'V', '({0}, {1}, {2})'); op('<>', 'S', 'V', '({0}, {0}, {0})')
for _f in 'sqrt floor exp log sin cos tan abs acos asin atan exp2 log2 ceil radians sign fract tanh erf'.split():
    op(_f, 'S', 'S', {'abs': 'math.fabs', 'atan': 'math.atan', 'tanh': 'math.tanh', 'erf': 'math.erf'}.get(_f, _f) + '({0})')
for _f in 'getx gety getz length'.split():
    op(_f, 'V', 'S', _f + '({0})')
op('min', 'SS', 'S', 'minimum({0}, {1})'); op('min', 'SSS', 'S', 'min3({0}, {1}, {2})'); op('min', 'VV', 'V', 'vmin({0}, {1})')
op('max', 'SS', 'S', 'maximum({0}, {1})'); op('max', 'SSS', 'S', 'max3({0}, {1}, {2})'); op('max', 'VV', 'V', 'vmax({0}, {1})')
op('perlin', 'VSSS', 'S', 'perlin({0}, {1}, {2}, {3})')
op('atan2', 'SS', 'S', 'math.atan2({0}, {1})')
op('mod', 'SS', 'S', 'mod({0}, {1})');   op('step', 'SS', 'S', 'step({0}, {1})')
op('clamp', 'SSS', 'S', 'clamp({0}, {1}, {2})')
op('smoothstep', 'SSS', 'S', 'smoothstep({0}, {1}, {2})')
op('mix', 'SSS', 'S', 'mix({0}, {1}, {2})'); op('mix', 'VVS', 'V', 'vmix({0}, {1}, {2})')
op('cross', 'VV', 'V', 'cross({0}, {1})'); op('reflect', 'VV', 'V', 'reflect({0}, {1})')
op('normalize', 'V', 'V', 'normalize({0})'); op('distance', 'VV', 'S', 'distance({0}, {1})')

# Every function of scalars, and ^, works by components of vectors, too; the operators have their own overloads.
BY_COMPONENTS = {name: [o for o in overloads if set(o[0]) == {'S'} and o[1] == 'S'] for name, overloads in OVERLOADS.items()
                 if name not in ('neg', '+', '-', '*', '/', '<>')}

VARIABLES = {'N': 'V', 'L': 'V', 'V': 'V', 'R': 'V', 'alpha': 'S', 'beta': 'S', 'gamma': 'S', 'point': 'V',
             'H': 'V', 'T': 'V', 'B': 'V', 'dist': 'S', 'visible': 'S', 'eta': 'S', 'total': 'S',
             'Ng': 'V', 'u': 'S', 'v': 'S'}
DIRECTIONS = set('NLVRHTB') | {'Ng'}             # of unit length
OF_LIGHTS = {'L', 'R', 'alpha', 'beta', 'H', 'dist', 'visible'}
OF_REFRACTION = {'eta', 'total'}
SURFACE = {'reflected': 'SV', 'refracted': 'SV', 'ambient': 'V', 'emission': 'V'}      # the terms that a formula may give for every hit, with their types


class Value:
    """A generated expression: its type, its Python text (an atom), its value where it is constant, whether its length is 1."""

    def __init__(self, type, atom, constant=None, unit=False):
        self.type, self.atom, self.constant, self.unit = type, atom, constant, unit


def literal(x):
    one = lambda x: 'NAN' if x != x else (repr(float(x)) if math.isfinite(x) else ('INF' if x > 0 else '(-INF)'))
    return Value('V', '(%s, %s, %s)' % tuple(map(one, x)), x) if isinstance(x, tuple) else Value('S', one(x), float(x))


class Code:
    """Python code of some expressions of a formula, one operation a line.  Functions are written out at each call, sums term by term."""

    def __init__(self, formula, variables):
        self.f, self.variables = formula, variables
        self.lines, self.macro_done, self.in_progress, self.names_read = [], {}, [], set()

    def emit(self, type, text, operands=(), unit=False):
        if all(o.constant is not None for o in operands):               # constant operands: a constant
            x = eval(text, globals())
            return literal(x if type == 'V' else float(x))
        self.lines.append('    t%d = %s' % (len(self.lines), text))
        return Value(type, 't%d' % (len(self.lines) - 1), None, unit)

    def gen(self, e, local):
        """-> Value.  Every operation is total, so both branches of an if may be computed.
        local: name -> Value of what hides all other names here: arguments of a function, the numbers of sums."""
        f, kind, where = self.f, e[0], e[1]
        if kind == 'number':
            return literal(e[2])
        if kind == 'name':
            return self.name(e[2], where, local)
        if kind == 'truth':
            c = self.cond(e[2], local)
            return self.emit('S', '1.0 if %s else 0.0' % c.atom, (c,))
        if kind == 'if':
            c = self.cond(e[2], local)
            a, b = self.gen(e[3], local), self.gen(e[4], local)
            if a.type != b.type:
                raise Wrong('%s: the branches of if are of different types' % where)
            return self.emit(a.type, '%s if %s else %s' % (a.atom, c.atom, b.atom), (a, c, b))
        name = e[2]
        if name in f.functions:
            return self.call(name, where, [self.gen(a, local) for a in e[3]])
        if name in f.params and f.params[name].type == 'T' and name not in local:
            texture, args = self.name(name, where, local), [self.gen(a, local) for a in e[3]]
            if [a.type for a in args] != ['S', 'S']:
                raise Wrong('%s: a texture takes two scalars' % where)
            return self.emit('V', '%s(%s, %s)' % (texture.atom, args[0].atom, args[1].atom), (texture, *args))
        if name in local or name in f.macros or name in f.params:
            raise Wrong('%s: %r is not a function' % (where, name))       # [CHOICE 3] a redefined [+] function name
        if name in ('sum', 'product'):
            return self.series(name, where, e[3], local)
        if name not in OVERLOADS:
            raise Wrong('%s: %r is not a function' % (where, name))
        args = [self.gen(a, local) for a in e[3]]
        types, atoms = ''.join(a.type for a in args), [a.atom for a in args]
        if name == '.' and types == 'VV' and args[0].unit and args[1].unit:
            return self.emit('S', 'unit_dot(%s, %s)' % tuple(atoms), args)
        for want, result, code in OVERLOADS[name]:
            if want == types:
                return self.emit(result, code.format(*atoms), args, name == 'normalize')
        for want, _, code in BY_COMPONENTS.get(name, ()):               # [CHOICE 25] any operand may be a vector
            if len(want) == len(types):
                function = 'lambda %s: %s' % (', '.join('xyz'[:len(want)]), code.format(*'xyz'))
                return self.emit('V', 'by_components(%s, %r, %s)' % (function, [t == 'V' for t in types], ', '.join(atoms)), args)
        raise Wrong('%s: %s does not take operands of types %s' % (where, name, ','.join(types)))

    def name(self, name, where, local):
        f = self.f
        if name in local:
            return local[name]
        self.names_read.add(name)
        if name in f.macros:                     # the user's meaning wins over [+] names
            return self.macro(name, where)
        if name in f.functions:
            raise Wrong('%s: the function %s needs arguments' % (where, name))
        if name in f.params:
            p = f.params[name]
            if name == 'background':
                raise Wrong('%s: background is not usable in formulas' % where)
            if p.owner == 'light' and not OF_LIGHTS <= self.variables:
                raise Wrong('%s: %s belongs to a light' % (where, name))
            return Value(p.type, '%s[%r]' % ({'body': 'body', 'light': 'light', 'global': 'globals_'}[p.owner], name))
        if name in VARIABLES:
            if name not in self.variables:
                raise Wrong('%s: %s is not known here' % (where, name))
            return Value(VARIABLES[name], 'var_' + name, None, name in DIRECTIONS)
        if name == 'pi':
            return literal(math.pi)
        raise Wrong('%s: unknown name %r' % (where, name))

    def call(self, name, where, args):
        names, body = self.f.functions[name]
        if len(names) != len(args):
            raise Wrong('%s: %s takes %d arguments' % (where, name, len(names)))
        return self.inside(name, where, lambda: self.gen(body, dict(zip(names, args))))

    def macro(self, name, where):
        if name not in self.macro_done:
            self.macro_done[name] = self.inside(name, where, lambda: self.gen(self.f.macros[name], {}))
        return self.macro_done[name]

    def inside(self, name, where, make):
        if name in self.in_progress:
            raise Wrong('%s: %s uses itself' % (where, name))
        self.in_progress.append(name)
        value = make()
        self.in_progress.pop()
        return value

    def series(self, name, where, args, local):
        if len(args) != 4 or args[0][0] != 'name':
            raise Wrong('%s: %s takes a name, two bounds and an expression' % (where, name))
        bounds = [self.gen(a, local) for a in args[1:3]]
        if any(b.type != 'S' or b.constant is None or not math.isfinite(b.constant) for b in bounds):
            raise Wrong('%s: the bounds of a %s are constants' % (where, name))
        whole = range(math.ceil(bounds[0].constant), math.floor(bounds[1].constant) + 1)
        if len(whole) > 256:
            raise Wrong('%s: more than 256 terms' % where)
        term = lambda i: self.gen(args[3], {**local, args[0][2]: literal(float(i))})
        if not whole:                            # the type is that of a term
            kept = self.lines, dict(self.macro_done)
            self.lines = list(self.lines)
            is_vector = term(0).type == 'V'
            self.lines, self.macro_done = kept
            x = 0.0 if name == 'sum' else 1.0
            return literal((x, x, x) if is_vector else x)
        total = term(whole[0])
        for i in whole[1:]:
            t = term(i)
            code = next(c for want, _, c in OVERLOADS['+' if name == 'sum' else '*'] if want == total.type + t.type)
            total = self.emit(total.type, code.format(total.atom, t.atom), (total, t))
        return total

    def cond(self, c, local):
        if c[0] == 'not':
            a = self.cond(c[2], local)
            return self.emit('S', '0.0 if %s else 1.0' % a.atom, (a,))
        if c[0] in ('and', 'or'):
            a, b = self.cond(c[2], local), self.cond(c[3], local)
            return self.emit('S', '1.0 if (%s %s %s) else 0.0' % (a.atom, c[0], b.atom), (a, b))
        operands = [self.gen(x, local) for x in (c[3:] if c[0] == 'cmp' else c[2:])]
        if any(o.type != 'S' for o in operands):
            raise Wrong('%s: conditions are of scalars' % c[1])
        if c[0] == 'scalar':                     # holds if it is not 0; so does NaN
            return self.emit('S', '1.0 if %s != 0 else 0.0' % operands[0].atom, operands)
        return self.emit('S', '1.0 if %s %s %s else 0.0' % (operands[0].atom, c[2], operands[1].atom), operands)   # NaN: false but in !=

    def function(self, name, result):
        """-> (the Python function of these lines, its text)"""
        source = 'def %s(%s, body, light, globals_):\n%s\n    return %s\n' % (
            name, ', '.join('var_' + v for v in VARIABLES), '\n'.join(self.lines), result)
        space = dict(globals())
        exec(source, space)
        return space[name], source


def names_in(e):
    """All names that an expression or condition reads (arguments and numbers of sums, too)."""
    if isinstance(e, tuple):
        if e and e[0] == 'name':
            yield e[2]
        elif e and e[0] == 'call':
            yield e[2]
        for x in e:
            yield from names_in(x)


class Formula:
    def __init__(self):
        self.params = {}                         # declared parameters only, until compile() adds the predefined ones
        self.changed = {}                        # predefined parameters with another range or default
        self.macros = {}                         # name -> expression
        self.functions = {}                      # name -> ([arguments], expression)
        self.invariants = []                     # (op, [name tokens])
        self.result = None

    def compile(self):
        """-> function (the variables, body, light, globals) -> RGB.  Sets .surface: name in SURFACE -> such a function, light unused."""
        self.params = {**predefined(), **self.changed, **self.params}
        texts = [self.result] + list(self.macros.values()) + [body for _, body in self.functions.values()]
        read = {name for e in texts for name in names_in(e)}
        surface = [name for name in SURFACE if name in self.macros and name not in read]   # one that is read is an ordinary macro
        for name in SURFACE:
            if name in self.macros and name in read:
                warn('%s is read, so it is an ordinary macro' % name)
        code = Code(self, set(VARIABLES) - OF_REFRACTION)
        value = code.gen(self.result, {})
        if value.type != 'V':
            raise Wrong('%s: the result must be a vector' % self.result_where)
        self.all_lights = 'visible' in code.names_read and 'visible' not in self.macros and 'visible' not in self.params   # what the result uses
        local, self.source = code.function('local', value.atom)
        self.surface = {}
        for name in surface:
            refraction = OF_REFRACTION if name in ('reflected', 'refracted') else set()
            own = Code(self, (set(VARIABLES) - OF_LIGHTS - OF_REFRACTION) | refraction)
            value = own.macro(name, name)
            if value.type not in SURFACE[name]:
                raise Wrong('%s must be a vector' % name)
            self.surface[name], source = own.function(name, value.atom if value.type == 'V' else '({0}, {0}, {0})'.format(value.atom))
            self.source += source
        for name in self.macros:                 # unused ones must be right, too
            Code(self, set(VARIABLES)).macro(name, '')
        return local


# =====================================================================================================================
# 5  Values of parameters and invariants (language 1.3)
# =====================================================================================================================
class System:
    """The invariants of one owner kind.  Affine forms are dicts {name or 1: Fraction}, over the free parameters."""

    def __init__(self, formula, owner):
        self.order = []                          # order of naming
        self.dependent = {}                      # locked name -> affine form in free parameters
        self.upper = []                          # affine forms that must be <= 0
        names_of = [(op, names) for op, names in formula.invariants if self.check(formula, names) == owner]
        for _, names in names_of:
            for t in names:
                if t.text not in self.order:
                    self.order.append(t.text)
        for op, names in names_of:
            if op == '=':
                self.equation([t.text for t in names], names[0].where)
        for op, names in names_of:
            if op == '<=':
                self.upper.append(self.sum_minus_one([t.text for t in names]))
        for n in self.order:                     # every one stays in 0..1
            form = self.form(n)
            self.upper.append({k: -v for k, v in form.items()})
            self.upper.append({**form, 1: form.get(1, Fraction(0)) - 1})
        self.free = [n for n in self.order if n not in self.dependent]
        if self.interval({}, list(self.free)) is None:
            raise Wrong('the invariants of the %s parameters cannot hold together' % owner)

    @staticmethod
    def check(formula, names):
        """All parameters scalar, range exactly 0..1, of one owner kind -> that kind."""
        owners = set()
        for t in names:
            p = formula.params.get(t.text)
            if p is None or p.name == 'background':
                raise Wrong('%s: %r is no parameter' % (t.where, t.text))
            if p.type != 'S' or (p.lo, p.hi) != (0, 1):
                raise Wrong('%s: %s is not a scalar of range 0..1' % (t.where, t.text))
            owners.add(p.owner)
        if len(owners) != 1:
            raise Wrong('%s: parameters of different owners' % names[0].where)
        return owners.pop()

    def form(self, name):
        return dict(self.dependent.get(name, {name: Fraction(1)}))

    def sum_minus_one(self, names):              # sum of the forms - 1
        total = {1: Fraction(-1)}
        for n in names:
            for k, v in self.form(n).items():
                total[k] = total.get(k, Fraction(0)) + v
        return {k: v for k, v in total.items() if v != 0 or k == 1}

    def equation(self, names, where):
        total = self.sum_minus_one(names)
        candidates = [n for n in names if n in total]                   # not already dependent, and really there
        if not candidates:                       # [CHOICE 4] only parameters named elsewhere are left
            candidates = [n for n in self.order if n in total]
        if not candidates:
            if total[1] != 0:
                raise Wrong('%s: the invariants are inconsistent' % where)
            warn('%s: redundant invariant' % where)
            return
        last = candidates[-1]
        c = total.pop(last)
        solved = {k: -v / c for k, v in total.items()}                  # last = solved
        for d, form in self.dependent.items():                          # keep the others over free ones only
            if last in form:
                f = form.pop(last)
                for k, v in solved.items():
                    form[k] = form.get(k, Fraction(0)) + f * v
        self.dependent[last] = solved

    def interval(self, fixed, unknown):
        """Bounds (lo, hi) of unknown[0], with `fixed` given and for *some* values of the rest; None if impossible.
        Fourier-Motzkin: eliminate all unknowns but the first.  With no unknown: (0, 0) if everything holds."""
        rows = []
        for form in self.upper:                  # sum c_k x_k + c <= 0
            row, const = {}, form.get(1, Fraction(0))
            for k, v in form.items():
                if k in fixed:
                    const += v * fixed[k]
                elif k != 1 and v != 0:
                    row[k] = v
            rows.append((row, const))
        for x in unknown[1:]:
            pos = [r for r in rows if r[0].get(x, 0) > 0]
            neg = [r for r in rows if r[0].get(x, 0) < 0]
            rows = [r for r in rows if r[0].get(x, 0) == 0]
            for rp, cp in pos:
                for rn, cn in neg:
                    a, b = -rn[x], rp[x]
                    row = {k: a * rp.get(k, 0) + b * rn.get(k, 0) for k in {*rp, *rn} if k != x}
                    rows.append(({k: v for k, v in row.items() if v != 0}, a * cp + b * cn))
            unique = {}                          # keeps Fourier-Motzkin small
            for row, c in rows:
                unique[(tuple(sorted(row.items())), c)] = (row, c)
            rows = list(unique.values())
        lo, hi = Fraction(-10 ** 9), Fraction(10 ** 9)
        for row, c in rows:
            if not row:
                if c > Fraction(1, 10 ** 15):
                    return None
            else:
                bound = -c / row[unknown[0]]
                if row[unknown[0]] > 0:
                    hi = min(hi, bound)
                else:
                    lo = max(lo, bound)
        if lo > hi:
            return None
        return lo, hi

    def take(self, values, given, owner_name):
        """Values arrive together: in the order of naming, later ones giving way (language 1.3).  [CHOICE 5]"""
        fixed = {}
        for i, n in enumerate(self.free):
            lo, hi = self.interval(fixed, self.free[i:])
            want = Fraction(values[n])
            fixed[n] = min(max(want, lo), hi)
            if fixed[n] != want:
                warn('%s.%s gives way: %g' % (owner_name, n, fixed[n]))
            values[n] = float(fixed[n])
        for n, form in self.dependent.items():
            v = float(sum(c * (1 if k == 1 else fixed[k]) for k, c in form.items()))
            if n in given and abs(values[n] - v) > 1e-12:
                warn('%s.%s is locked, the value given is ignored' % (owner_name, n))
            values[n] = v


def parse_value(text):
    m = re.fullmatch(r'\s*<([^<>,]*),([^<>,]*),([^<>,]*)>\s*', text)
    try:
        v = tuple(float(x) for x in m.groups()) if m else float(text)
    except ValueError:
        raise Wrong('not a value: %r' % text)
    if not all(map(math.isfinite, v if m else (v,))):
        raise Wrong('not a finite value: %r' % text)
    return v


def parse_color(text):                           # <r,g,b> or #rrggbb
    if m := re.fullmatch(r'#([0-9a-fA-F]{2})([0-9a-fA-F]{2})([0-9a-fA-F]{2})', text):
        return tuple(int(x, 16) / 255 for x in m.groups())
    v = parse_value(text)
    if not isinstance(v, tuple):
        raise Wrong('not a colour: %r' % text)
    return v


def assign_values(formula, scene, settings, background):
    """Sets scene.globals and .values of every body and light: defaults, then --set, then invariants."""
    owners = [('body', b.name, b) for b in scene.bodies] + [('light', l.name, l) for l in scene.lights] + [('global', '', scene)]
    for kind, _, o in owners:
        o.values = {n: p.default for n, p in formula.params.items() if p.owner == kind}
        o.given = set()
    if background is not None:
        settings = ['background=<%r,%r,%r>' % background] + settings
    for s in settings:                           # [CHOICE 6] the later of two for the same parameter wins
        left, eq, right = s.partition('=')
        owner, dot_, name = left.strip().rpartition('.')
        owner, name = owner.strip(), name.strip()
        value, found = images.white if right == 'none' else parse_value(right), False
        for kind, owner_name, o in owners:
            if (owner == '*' and kind != 'global') or (owner == owner_name and bool(dot_) == (kind != 'global')):
                p = formula.params.get(name)
                if p is None or p.owner != kind:
                    continue
                found = True
                if p.type != ('T' if callable(value) else 'V' if isinstance(value, tuple) else 'S'):
                    raise Wrong('--set %s: wrong type' % s)
                o.values[name] = p.clamp(value)
                if o.values[name] != value:
                    warn('--set %s: clamped to the range of %s' % (s, name))
                o.given.add(name)
        if not eq or not found:
            raise Wrong('--set %s: no such owner or parameter' % s)
    for kind in ('body', 'light', 'global'):
        system = System(formula, kind)
        for k, owner_name, o in owners:
            if k == kind:
                system.take(o.values, o.given, owner_name or 'global')
    for b in scene.bodies:                       # language 2: fixed at 0.  [CHOICE 7] after the invariants, which do not see it
        if b.opaque:
            b.values['kt'] = 0.0
        if b.matte:
            b.values['kr'] = 0.0


# =====================================================================================================================
# 6  Scene (language 2)
# =====================================================================================================================
class Body:
    """hit() and at() are what rays ask for; a mesh (mesh.py) has its own.  The part of a hit is the triangle of a mesh."""
    index = None
    opaque = matte = False

    def hit(self, o, d, part, eps):
        """-> (distance > eps, part) of the first intersection, or None.  part: where on this body the ray starts, or None."""
        t = self.meet(o, d, part is not None, eps)
        return None if t is None else (t, ())

    def at(self, a, part):
        """-> geometric and shading normal on the outside, T, u, v"""
        n = self.outward(a)
        return (n, n, self.tangent(a), *self.coordinates(a))


class Sphere(Body):
    def __init__(self, center, radius):
        self.center, self.radius = center, radius
        self.corners = [vadd(center, (s * radius,) * 3) for s in (-1, 1)]

    def meet(self, o, d, starts_here, eps):
        """Distance > eps along the unit direction d to the first intersection, or None.
        starts_here: o lies on this very surface, so that the root t = 0 is known and only the other one counts."""
        oc = vsub(o, self.center)
        b = dot(oc, d)
        if starts_here:
            t = -2 * b                           # t^2 + 2bt = 0
            return t if t > eps else None
        foot = vsub(oc, vscale(d, b))            # from the centre to the ray, perpendicularly
        disc = self.radius ** 2 - dot(foot, foot)
        if disc < 0:
            return None
        s = math.sqrt(disc)
        far = -b - s if b > 0 else -b + s        # the root without cancellation
        c = (length(oc) - self.radius) * (length(oc) + self.radius)
        other = c / far if far != 0 else far
        for t in sorted((far, other)):
            if t > eps:
                return t
        return None

    def outward(self, a):
        return normalize(vsub(a, self.center))

    def tangent(self, a):                        # language 1.3 T
        t = cross((0.0, 1.0, 0.0), self.outward(a))
        return normalize(t) if length(t) > 1e-12 else (1.0, 0.0, 0.0)

    def coordinates(self, a):                    # language 1.4 u v: longitude about +y, 0 towards +z, and angle from the south pole
        x, y, z = self.outward(a)
        return math.atan2(x, z) / (2 * math.pi) % 1.0, acos(-y) / math.pi


class Rectangle(Body):
    def __init__(self, a, b, c):
        self.a, self.b, self.c = a, b, c
        self.corners = [a, b, c, vsub(vadd(a, c), b)]
        self.e1, self.e2 = vsub(a, b), vsub(c, b)                      # from corner B; the fourth corner is B + e1 + e2
        if length(self.e1) == 0 or length(self.e2) == 0:
            raise Wrong('a side of a rectangle is zero')
        cosine = dot(normalize(self.e1), normalize(self.e2))
        if abs(cosine) > 1e-3:
            raise Wrong('the sides of a rectangle are not perpendicular: cos = %g' % cosine)
        self.normal = normalize(cross(vsub(c, a), vsub(b, a)))         # the front's

    def meet(self, o, d, starts_here, eps):
        if starts_here:
            return None                          # a plane is met once
        denominator = dot(d, self.normal)
        if denominator == 0:
            return None
        t = dot(vsub(self.b, o), self.normal) / denominator
        if not t > eps:
            return None
        q = vsub(vadd(o, vscale(d, t)), self.b)  # q = u e1 + v e2
        g11, g12, g22 = dot(self.e1, self.e1), dot(self.e1, self.e2), dot(self.e2, self.e2)
        q1, q2, det = dot(q, self.e1), dot(q, self.e2), g11 * g22 - g12 * g12
        u, v = (q1 * g22 - q2 * g12) / det, (q2 * g11 - q1 * g12) / det
        return t if 0 <= u <= 1 and 0 <= v <= 1 else None

    def outward(self, a):
        return self.normal

    def tangent(self, a):
        return normalize(vsub(self.b, self.a))

    def coordinates(self, a):                    # language 1.4 u v: from A to B, from B to C
        q = vsub(a, self.a)
        ab, bc = vsub(self.b, self.a), vsub(self.c, self.b)
        return dot(q, ab) / dot(ab, ab), dot(q, bc) / dot(bc, bc)


class Light:
    """A name, values, and .shines: one of the kinds of lights.py."""


def parse_light(p, folder):
    """-> the kind of a light, from its word to before the semicolon"""
    t = p.need_word('point', 'directional', 'spot', 'sphere', 'rectangle', 'environment')

    def part(word, read):
        p.need(',')
        if word:
            p.need_word(word)
        return read()

    def number(word, least, most, above=False):
        x = part(word, p.snum)
        if not least <= x <= most or above and x == least:
            raise Wrong('%s: %s is %g' % (t.where, word, x))
        return x

    def optional(word):
        return p.peek(',') and p.tokens[p.at + 1].text == word

    vector = lambda word=None: part(word, p.const_vector)
    if t.text == 'point':
        return lights.Point(vector())
    if t.text == 'directional':
        travel = vector()
        if length(travel) == 0:
            raise Wrong('%s: the light travels nowhere' % t.where)
        return lights.Directional(travel)
    if t.text == 'spot':
        position, target, angle = vector(), vector('target'), number('angle', 0, 180, above=True)
        if position == target:
            raise Wrong('%s: the target is where the light is' % t.where)
        return lights.Spot(position, target, angle, number('soft', 0, angle) if optional('soft') else 0.0)
    if t.text == 'sphere':
        return lights.Sphere(vector('center'), number('radius', 0, INF, above=True))
    if t.text == 'rectangle':
        a, b, c = vector(), vector(), vector()
        Rectangle(a, b, c)                       # the corners are as for bodies
        return lights.Rectangle(a, b, c)
    rows = images.texels(os.path.join(folder, part(None, lambda: p.need('string').value))) if p.peek(',') and not optional('rotate') else None
    return lights.Environment(rows, part('rotate', p.snum) if p.peek(',') else 0.0)


class Scene:
    pass


def parse_scene(text, name, default_index):
    p = Parser(text, name)
    scene = Scene()
    scene.bodies, scene.lights, scene.environment, names = [], [], None, set()

    def new_name():
        t = p.name()
        if t.text in names:
            raise Wrong('%s: %r is named twice' % (t.where, t.text))
        names.add(t.text)
        p.need(':')
        return t.text

    p.need_word('bodies'); p.need(';')
    while p.peek('ident') and not p.word('lights'):
        n = new_name()
        t = p.need_word('sphere', 'rectangle', 'mesh')
        p.need(',')
        if t.text == 'mesh':                     # the path is relative to the scene file
            path = os.path.join(os.path.dirname(name), p.need('string').value)
            transforms, smooth = [], None
        elif t.text == 'sphere':
            p.need_word('center'); center = p.const_vector(); p.need(',')
            p.need_word('radius'); radius = p.snum()
            if radius <= 0:
                raise Wrong('%s: the radius must be positive' % t.where)
            b = Sphere(center, radius)
        else:
            c1 = p.const_vector(); p.need(',')
            c2 = p.const_vector(); p.need(',')
            b = Rectangle(c1, c2, p.const_vector())
        attributes = {}
        while p.accept(','):
            of_meshes = ('flat', 'smooth', 'scale', 'rotate', 'translate', 'fit') if t.text == 'mesh' else ()
            a = p.need_word('refractive_index', 'opaque', 'matte', *of_meshes)
            if a.text == 'refractive_index':
                attributes['index'] = p.snum()
                if attributes['index'] <= 0:
                    raise Wrong('%s: the refractive index must be positive' % a.where)
            elif a.text in ('opaque', 'matte'):
                attributes[a.text] = True
            elif a.text in ('flat', 'smooth'):
                smooth = a.text == 'smooth'
            elif a.text == 'scale' and not p.peek('<'):
                transforms.append((a.text, p.snum()))
            else:
                transforms.append((a.text, p.const_vector()) + ((p.snum(),) if a.text in ('rotate', 'fit') else ()))
        p.need(';')
        if t.text == 'mesh':
            import mesh                          # needs trimesh, numpy and embreex
            b = mesh.Mesh(path, transforms, smooth)
        for key, value in attributes.items():
            setattr(b, key, value)
        b.name = n
        if b.index is None:
            b.index = default_index
        scene.bodies.append(b)
    p.need_word('lights'); p.need(';')
    while p.peek('ident') and not p.word('camera'):
        l = Light()
        l.name = new_name()
        l.shines = parse_light(p, os.path.dirname(name))
        if isinstance(l.shines, lights.Environment):
            if scene.environment is not None:
                raise Wrong('%s: the second environment' % p.tokens[p.at].where)
            scene.environment = l
        p.need(';')
        scene.lights.append(l)
    p.need_word('camera'); p.need(';')
    p.need_word('position'); scene.eye = p.const_vector(); p.need(';')
    p.need_word('gaze'); gaze = p.const_vector(); p.need(';')
    p.need_word('up'); up = p.const_vector(); p.need(';')
    p.need_word('fov'); fov = p.snum(); p.need(';')
    if not p.peek('end'):
        p.fail('the end')
    if not 0 < fov < 180:
        raise Wrong('fov must be between 0 and 180')
    if length(cross(gaze, up)) <= 1e-12 * length(gaze) * length(up):
        raise Wrong('gaze and up are parallel or zero')
    scene.forward = normalize(gaze)
    scene.right = normalize(cross(gaze, up))
    scene.up = cross(scene.right, scene.forward)
    scene.tan_half = math.tan(math.radians(fov) / 2)                   # fov is the vertical angle
    points = [c for b in scene.bodies for c in b.corners] or [scene.eye]                # language 3, Details: the box of the bodies
    scene.extent = distance(tuple(map(min, zip(*points))), tuple(map(max, zip(*points)))) or 1.0
    return scene


# =====================================================================================================================
# 7  Rays (language 3)
# =====================================================================================================================
class Tracer:
    points = 1                                   # n x n points of a light with an area; 2n x n directions of an environment
    turn = (0, 1, 0)                             # the number of the ray in its pixel, how many there are, and the number of the pixel
    variance = (0.0, 0.0, 0.0)                   # of the colour of one pass, over the points of lights: added up by color()

    def __init__(self, scene, local, depth, shadows, all_lights, surface):
        self.scene, self.local, self.depth, self.shadows, self.all_lights = scene, local, depth, shadows, all_lights
        self.surface = surface                   # the terms that the formula gives for every hit
        # A ray leaving a surface ignores that surface's own root at 0 (known exactly, see meet) and anything nearer
        # than this; far below the 1e-6 x extent that it allows.
        self.eps = 1e-9 * scene.extent

    def first_hit(self, o, d, start):
        best, best_t, best_part = None, INF, None
        for b in self.scene.bodies:
            hit = b.hit(o, d, start[1] if b is start[0] else None, self.eps)
            if hit is not None and hit[0] < best_t:                    # strict: at equal distance the first declared
                best, best_t, best_part = b, *hit
        return best, best_t, best_part

    def visible(self, a, start, L, dist):
        if not self.shadows:
            return True
        for b in self.scene.bodies:              # transparent ones and this one, too
            hit = b.hit(a, L, start[1] if b is start[0] else None, self.eps)
            if hit is not None and hit[0] < dist - self.eps:
                return False
        return True

    def outside(self, d):
        """The colour of a ray that leaves the scene: the background, and the environment beside it."""
        background, light = self.scene.values['background'], self.scene.environment
        if light is None or light.values['ki'] == 0:
            return background
        return vadd(background, vscale(vmul(light.values['IL'], light.shines.radiance(d)), light.values['ki']))

    def color(self, o, d, start, depth, path=(1.0, 1.0, 1.0)):
        """Equation (2) for the ray from o in unit direction d, leaving the surface `start`: body and part (None, None: the camera).
        path: the product of the weights on the way, for the variance."""
        g = self.scene.values
        body, t, part = self.first_hit(o, d, start)
        if body is None:
            return self.outside(d)
        A = vadd(o, vscale(d, t))
        outward, shading, T, u, v = body.at(A, part)
        front = dot(d, outward) < 0
        V = vneg(d)
        Ng = outward if front else vneg(outward)                       # turned to the side the ray came from
        N = shading if front else vneg(shading)
        if dot(N, V) < 0:                        # interpolated, and looks away: turned until it just does not  [CHOICE 35]
            N = normalize(vsub(N, vscale(V, dot(N, V))))
        angle = lambda x, y: acos(max(min(dot(x, y), 1.0), -1.0))      # NaN stays NaN: Python's min/max keep the first
        gamma = angle(N, V)
        B = cross(N, T)
        p = body.values
        total = (0.0, 0.0, 0.0)
        for light in self.scene.lights:
            ki = light.values['ki']
            if ki == 0:                          # a zero factor: the term is exactly 0
                continue
            mean, square = None, (0.0, 0.0, 0.0)
            for arrival in light.shines.arriving(A, self.points, self.turn):
                L = arrival.direction
                faces = dot(N, L) > 0 and dot(Ng, L) > 0               # language 2.1: both see the light
                if not self.all_lights and (self.shadows and not faces or not arrival.inside):
                    continue
                visible = self.visible(A, (body, part), L, arrival.distance)
                if not (visible or self.all_lights):
                    continue                     # a formula that reads visible has no visible_i
                R = vsub(vscale(N, 2 * dot(N, L)), L)
                H = normalize(vadd(L, V))
                own = light.values if arrival.factor is lights.WHITE else {**light.values, 'IL': vmul(light.values['IL'], arrival.factor)}
                e = self.local(N, L, V, R, angle(N, L), angle(R, V), gamma, A, H, T, B, arrival.dist, float(visible), None, None, Ng, u, v, p, own, g)
                part_of_mean = vscale(e, arrival.weight)
                mean = part_of_mean if mean is None else vadd(mean, part_of_mean)
                if arrival.weight != 1 and e != (0.0, 0.0, 0.0):
                    square = vadd(square, vover(vmul(part_of_mean, part_of_mean), arrival.chance))
            if mean is not None:
                total = vadd(total, vscale(mean, ki))
                if arrival.weight != 1:          # a grid
                    weight = vscale(path, ki)
                    self.variance = vadd(self.variance, vmul(vmul(weight, weight), vsub(square, vmul(mean, mean))))
        n12 = 1 / body.index if front else body.index
        beyond = 1 - n12 * n12 * (1 - dot(N, V) ** 2) < 0
        own = {name: f(N, None, V, None, None, None, gamma, A, None, T, B, None, None, n12, float(beyond), Ng, u, v, p, None, g)
               for name, f in self.surface.items()}
        if 'ambient' in own:                     # in place of ka Cd Ia
            total = vadd(total, own['ambient'])
        elif g['ka'] != 0:
            total = vadd(total, vscale(vmul(p['Cd'], g['Ia']), g['ka']))
        if 'emission' in own:
            total = vadd(total, own['emission'])
        if depth < self.depth:
            weight = own.get('reflected', (p['kr'],) * 3)
            if any(w != 0 for w in weight) and not body.matte:
                r = normalize(vsub(vscale(N, 2 * dot(N, V)), V))
                total = vadd(total, vmul(self.color(A, r, (body, part), depth + 1, vmul(path, weight)), weight))
            weight = own.get('refracted', (p['kt'],) * 3)
            if any(w != 0 for w in weight) and not body.opaque and not beyond:
                r = self.refracted(N, V, n12)
                total = vadd(total, vmul(self.color(A, r, (body, part), depth + 1, vmul(path, weight)), weight))
        return total

    @staticmethod
    def refracted(N, V, n12):                    # thesis 3.2.5: T = [n12 (N.V) - sqrt(1 - n12^2 (1 - (N.V)^2))] N - n12 V
        c = dot(N, V)
        radicand = 1 - n12 * n12 * (1 - c * c)
        radicand = max(radicand, 0.0)            # not beyond the critical angle: the caller has looked
        return normalize(vsub(vscale(N, n12 * c - math.sqrt(radicand)), vscale(V, n12)))


# =====================================================================================================================
# 8  Picture (language 2 camera, language 3)
# =====================================================================================================================
def primary(scene, x, y, width, height):
    """Unit direction through the point (x, y) of the picture, in pixels from its top left corner, y down."""
    sx = (2 * x / width - 1) * scene.tan_half * width / height         # square pixels
    sy = (1 - 2 * y / height) * scene.tan_half
    return normalize(vadd(scene.forward, vadd(vscale(scene.right, sx), vscale(scene.up, sy))))


def render_row(job):
    """-> RGB of the row's pixels, NaN already 0; with `shifts` also whether each is stable; the standard deviations of one pass."""
    tracer, y, width, height, samples, offset, shifts = job
    count = samples * samples
    step = lights.generator(count, 0.29)

    def pixel(x, dx, dy):
        total, squares, tracer.variance = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        for k in range(count):                   # [CHOICE 21]
            d = primary(tracer.scene, x + (k + 0.5) / count + dx, y + (k * step + 0.5) / count % 1 + dy, width, height)
            tracer.turn = (k, count, y * width + x)
            c = tracer.color(tracer.scene.eye, d, (None, None), 1)
            total, squares = vadd(total, c), vadd(squares, vmul(c, c))
        c = vover(total, count)
        variance = vover(vadd(vsub(squares, vmul(total, c)), tracer.variance), count)
        return tuple(0.0 if v != v else v for v in c), tuple(sqrt(max(v, 0.0)) for v in variance)      # [CHOICE 8] NaN -> 0 after the average

    row, stable, deviations = [], [], []
    for x in range(width):
        c, deviation = pixel(x, *offset)
        row.append(c)
        deviations.append(deviation)
        ok = True
        for dx, dy in shifts:
            s, _ = pixel(x, offset[0] + dx, offset[1] + dy)
            if not all(a == b or abs(a - b) <= 1e-3 for a, b in zip(c, s)):
                ok = False
                break
        stable.append(255 if ok else 0)
    return row, stable, deviations


def render(tracer, width, height, samples=1, offset=(0.0, 0.0), shifts=(), processes=None):
    """-> (list of rows, top first, of RGB tuples; list of rows of 0/255; list of rows of the standard deviations of one pass)"""
    jobs = [(y, width, height, samples, offset, shifts) for y in range(height)]
    global _tracer
    _tracer = tracer                             # inherited by fork: the compiled formula cannot be pickled
    with multiprocessing.get_context('fork').Pool(processes or os.cpu_count()) as pool:
        rows = pool.map(_row, jobs, chunksize=1)
    return tuple(map(list, zip(*rows)))


def _row(job):
    return render_row((_tracer,) + job)


def write_pfm(path, rows):
    """PFM, little-endian ("-1.0"), rows from the BOTTOM to the top as the format prescribes."""
    with open(path, 'wb') as f:
        f.write(b'PF\n%d %d\n-1.0\n' % (len(rows[0]), len(rows)))
        for row in reversed(rows):
            for c in row:
                f.write(struct.pack('<3f', *(to_f32(v) for v in c)))


def to_f32(v):                                   # struct.pack raises where a float overflows
    return math.copysign(INF, v) if abs(v) > 3.4028235e38 else v


def write_pgm(path, rows):
    """PGM (P5), rows from the TOP to the bottom as that format prescribes; 255 stable, 0 not."""
    with open(path, 'wb') as f:
        f.write(b'P5\n%d %d\n255\n' % (len(rows[0]), len(rows)))
        for row in rows:
            f.write(bytes(row))


# =====================================================================================================================
# 9  Command line
# =====================================================================================================================
def read(path):
    with open(path, encoding='utf-8', newline='') as f:
        return f.read()


def build(formula_path, scene_path, sets=(), ior=1.5, background=None, depth=5, shadows=True):
    formula = FormulaParser(read(formula_path), formula_path).formula_file()
    local = formula.compile()
    scene = parse_scene(read(scene_path), scene_path, ior)
    assign_values(formula, scene, list(sets), background)
    return Tracer(scene, local, depth, shadows, formula.all_lights, formula.surface), formula


def main():
    sys.setrecursionlimit(20000)
    a = argparse.ArgumentParser()
    a.add_argument('--formula', required=True)
    a.add_argument('--scene', required=True)
    a.add_argument('--set', action='append', default=[], metavar='OWNER.PARAM=VALUE')
    a.add_argument('--size', default='640x480')
    a.add_argument('--depth', type=int, default=5)
    a.add_argument('--shadows', action=argparse.BooleanOptionalAction, default=True)
    a.add_argument('--ior', type=float, default=1.5)
    a.add_argument('--background')
    a.add_argument('--samples', type=int, default=1)
    a.add_argument('--points', type=int, default=1, help='a grid of N x N points on lights with an area, 2N x N directions of an environment')
    a.add_argument('--offset', default='0,0', help='DX,DY in pixels, x to the right, y down')
    a.add_argument('--stable', metavar='MASK')
    a.add_argument('--deviation', metavar='PFM', help='the standard deviation of one pass, over the pixel and the points of lights')
    a.add_argument('--values', action='store_true', help='print the parameter values used')
    a.add_argument('--source', action='store_true', help='print the compiled formula')
    a.add_argument('-o', required=True)
    o = a.parse_args()
    try:
        if not 1 <= o.depth <= 9:
            raise Wrong('depth is 1..9')
        m = re.fullmatch(r'([1-9][0-9]*)x([1-9][0-9]*)', o.size)
        if not m or o.samples < 1 or o.points < 1 or not o.ior > 0:
            raise Wrong('size, samples or index is wrong')
        width, height = map(int, m.groups())
        offset = tuple(map(float, o.offset.split(',')))
        background = parse_color(o.background) if o.background else None
        tracer, formula = build(o.formula, o.scene, o.set, o.ior, background, o.depth, o.shadows)
        if o.source:
            print(formula.source)
        if o.values:
            for x in tracer.scene.bodies + tracer.scene.lights:
                print(x.name, x.values)
            print('global', tracer.scene.values)
        e = 0.01
        shifts = ((e, e), (e, -e), (-e, e), (-e, -e)) if o.stable else ()
        tracer.points = o.points
        rows, stable, deviations = render(tracer, width, height, o.samples, offset, shifts)
    except Wrong as w:
        print('error: %s' % w, file=sys.stderr)
        sys.exit(1)
    write_pfm(o.o, rows)
    if o.stable:
        write_pgm(o.stable, stable)
    if o.deviation:
        write_pfm(o.deviation, deviations)


if __name__ == '__main__':
    main()
