// The operations of formulas that WGSL leaves to the device, or that its compilers may change: they may take numbers
// for finite, fuse a product with a sum, and compute a sine to eleven bits.

const SIGN: u32 = 0x80000000u;
const MAGNITUDE: u32 = 0x7fffffffu;
const INFINITE: u32 = 0x7f800000u;

// A number by its bits. No compiler knows that they are not changed.
fn opaque(bits: u32) -> f32 { return bitcast<f32>(bits ^ frame.zero); }

fn is_nan(x: f32) -> bool { return (bitcast<u32>(x) & MAGNITUDE) > INFINITE; }
fn with_sign_of(x: f32, sign: f32) -> f32 { return bitcast<f32>(bitcast<u32>(x) ^ (bitcast<u32>(sign) & SIGN)); }

// A quotient. Devices multiply by the reciprocal, which is 0 for the largest numbers, and the last bits are wrong.
fn divided(x: f32, y: f32) -> f32 {
    let scale = select(1.0, 0.25, abs(y) > 4.2535296e37);
    let a = x * scale;
    let b = y * scale;
    let quotient = a / b;
    let better = quotient + fma(-quotient, b, a) / b;
    // A zero keeps its sign.
    let is_better = quotient != 0.0 && (bitcast<u32>(better) & MAGNITUDE) < INFINITE;
    let is_finite = (bitcast<u32>(quotient) & MAGNITUDE) < INFINITE;
    return strict(select(quotient, better, is_better && is_finite));
}

// The smaller of x and a limit, and the greater one. NaN stays NaN.
fn at_most(x: f32, limit: f32) -> f32 { return select(x, limit, limit < x); }
fn at_least(x: f32, limit: f32) -> f32 { return select(x, limit, limit > x); }

// 2^n for a whole n from -126 to 127; 0 for -127 and infinite for 128.
fn power_of_two(n: f32) -> f32 { return opaque(bitcast<u32>(strict(n + (ROUNDER + 127.0))) << 23u); }

fn exponential_2(x: f32) -> f32 {
    let clamped = at_least(at_most(x, 128.0), -127.0);
    let whole = floor(clamped);
    return strict(polynomial_exp2(clamped - whole) * power_of_two(whole));
}

fn exponential(x: f32) -> f32 {
    let clamped = at_least(at_most(x, 89.0), -88.0);
    let whole = floor(clamped * LOG2_E);
    let fraction = strict(clamped - strict(whole * LN_2_HEAD)) - whole * LN_2_TAIL;
    return strict(polynomial_exp(fraction) * power_of_two(whole));
}

// A positive number as 2^e * m with m from the root of a half to the root of two: e * 2^23, and m.
struct Scaled { field: i32, significand: f32 }

fn split(x: f32) -> Scaled {
    let bits = bitcast<i32>(x);
    let field = (bits - 0x3f3504f3) & bitcast<i32>(0xff800000u);
    return Scaled(field, opaque(bitcast<u32>(bits - field)));
}

// A logarithm where x is positive and finite, else its special case.
fn logarithm_edges(x: f32, logarithm: f32) -> f32 {
    let bits = bitcast<u32>(x);
    if (is_nan(x)) { return x; }
    if ((bits & INFINITE) == 0u) { return opaque(INFINITE | SIGN); }
    if ((bits & SIGN) != 0u) { return opaque(MAGNITUDE); }
    return select(logarithm, x, bits == INFINITE);
}

fn logarithm_2(x: f32) -> f32 {
    let scaled = split(x);
    let r = scaled.significand - 1.0;
    return logarithm_edges(x, strict(r * polynomial_log2(r) + f32(scaled.field >> 23u)));
}

fn logarithm(x: f32) -> f32 {
    let scaled = split(x);
    let field = f32(scaled.field);
    let r = scaled.significand - 1.0;
    let inner = r + (r * r * polynomial_log(r) + field * (LN_2_TAIL * FIELD));
    return logarithm_edges(x, strict(field * (LN_2_HEAD * FIELD) + inner));
}

fn twelve_bits(x: f32) -> f32 { return opaque(bitcast<u32>(x) & 0xfffff000u); }

// log2 of a positive finite number as a sum of two numbers. The first has twelve bits.
fn extended_log2(x: f32) -> vec2<f32> {
    let scaled = split(x);
    let exponent = f32(scaled.field >> 23u);
    let numerator = strict(scaled.significand - 1.0);
    let denominator = strict(scaled.significand + 1.0);
    let reciprocal = 1.0 / denominator;
    let short_quotient = twelve_bits(numerator * reciprocal);
    let denominator_head = twelve_bits(denominator);
    let denominator_tail = strict(scaled.significand - strict(denominator_head - 1.0));
    let rest = strict(numerator - strict(short_quotient * denominator_head));
    let remainder = strict(rest - strict(short_quotient * denominator_tail));
    let quotient_tail = strict(remainder * reciprocal);
    let first = strict(short_quotient * TWO_LOG2_E_HEAD);
    let head = strict(exponent + first);
    let head_tail = strict(first - strict(head - exponent));
    let full = strict(short_quotient + quotient_tail);
    let added = strict(full - short_quotient);
    var tail = head_tail + short_quotient * TWO_LOG2_E_TAIL;
    tail = tail + added * TWO_LOG2_E;
    let square = full * full;
    tail = tail + strict(quotient_tail - added) * (square * TWO_LOG2_E + TWO_LOG2_E);
    tail = strict(tail + full * square * polynomial_artanh(square));
    let sum = strict(head + tail);
    let short = twelve_bits(sum);
    return vec2<f32>(short, tail + strict(head - short));
}

// x to the power y as C's powf.
fn power(x: f32, y: f32) -> f32 {
    if (y == 0.0 || x == 1.0) { return 1.0; }
    if (is_nan(x) || is_nan(y)) { return opaque(MAGNITUDE); }
    let fractional = floor(y) != y;
    let odd = !fractional && floor(y * 0.5) != y * 0.5;
    let sign = select(0u, bitcast<u32>(x) & SIGN, odd);
    let size = bitcast<u32>(x) & MAGNITUDE;
    if ((size & INFINITE) == 0u || size == INFINITE) {
        return opaque(select(0u, INFINITE, (y > 0.0) == (size == INFINITE)) | sign);
    }
    if (x < 0.0 && fractional) { return opaque(MAGNITUDE); }
    let logarithm = extended_log2(bitcast<f32>(size));
    let exponent = at_least(at_most(y, 4294967296.0), -4294967296.0);
    let wide = strict(exponent * 4097.0);
    let exponent_head = strict(wide - strict(wide - exponent));
    let exponent_tail = strict(exponent - exponent_head);
    let product = strict(exponent_head * logarithm.x);
    let inexact = exponent * logarithm.y + strict(exponent_tail * logarithm.x);
    let tail = at_least(at_most(inexact, TAIL_LIMIT), -TAIL_LIMIT);
    let sum = strict(product + tail);
    if (sum < -127.0) { return opaque(sign); }
    let whole = at_most(floor(sum), 127.0);
    // From here on the result is infinite, whatever the fraction.
    let fraction = at_most(strict(product - whole) + tail, 4.0);
    return opaque(bitcast<u32>(polynomial_exp2(fraction) * power_of_two(whole)) | sign);
}

// x - n * scale * pi.
fn reduced(x: f32, n: f32, scale: f32) -> f32 {
    var r = strict(x - strict(n * (PI_0 * scale)));
    r = strict(r - strict(n * (PI_1 * scale)));
    var part = strict(n * (PI_2 * scale));
    var next = strict(r - part);
    var lost = strict(strict(r - next) - part);
    r = next;
    part = strict(n * (PI_3 * scale));
    next = strict(r - part);
    lost = lost + strict(strict(r - next) - part);
    r = strict(next - strict(strict(n * (PI_4 * scale)) - lost));
    r = r - n * (PI_5 * scale);
    return strict(r - n * (PI_6 * scale));
}

fn odd_sign(rounded: f32) -> f32 { return bitcast<f32>(bitcast<u32>(rounded) << 31u); }

fn alternating_sine(r: f32, rounded: f32) -> f32 {
    let square = r * r;
    let sine = r + r * square * polynomial_sin(square);
    return with_sign_of(at_least(at_most(sine, 1.0), -1.0), bitcast<f32>((bitcast<u32>(rounded) & 1u) << 31u));
}

fn sine(x: f32) -> f32 {
    // A zero keeps its sign.
    if (x == 0.0) { return x; }
    let rounded = strict(strict(x * FRAC_1_PI) + ROUNDER);
    return strict(alternating_sine(reduced(x, strict(rounded - ROUNDER), 1.0), rounded));
}

fn cosine(x: f32) -> f32 {
    let rounded = strict(strict(strict(x * FRAC_1_PI) - 0.5) + (ROUNDER + 1.0));
    return strict(alternating_sine(reduced(x, strict(rounded - (ROUNDER + 1.0)) + 0.5, 1.0), rounded));
}

fn tangent(x: f32) -> f32 {
    let rounded = strict(strict(x * FRAC_2_PI) + ROUNDER);
    let r = reduced(x, strict(rounded - ROUNDER), 0.5);
    let square = r * r;
    let tangent = strict(r + r * square * polynomial_tan(square));
    let value = select(tangent, -1.0 / tangent, (bitcast<u32>(rounded) & 1u) == 1u);
    if (is_nan(x) || (bitcast<u32>(x) & MAGNITUDE) == INFINITE) { return opaque(MAGNITUDE); }
    return strict(select(0.0, value, abs(x) <= TAN_RANGE));
}

fn arc_sine(x: f32) -> f32 {
    let size = abs(x);
    let is_large = size > 0.5;
    let folded = 0.5 - 0.5 * size;
    let square = select(size * size, folded, is_large);
    let s = select(size, -2.0 * sqrt(max(folded, 0.0)), is_large);
    let small = s * square * polynomial_asin(square) + select(0.0, FRAC_PI_2_TAIL, is_large);
    let value = (select(0.0, FRAC_PI_2, is_large) + s) + small;
    if (!(size <= 1.0)) { return opaque(MAGNITUDE); }
    return strict(with_sign_of(value, x));
}

fn arc_cosine(x: f32) -> f32 {
    let size = abs(x);
    if (!(size <= 1.0)) { return opaque(MAGNITUDE); }
    let angle = sqrt(1.0 - size) * polynomial_acos(size);
    return strict(select(angle, PI - angle, (bitcast<u32>(x) & SIGN) != 0u));
}

fn arc_tangent(x: f32) -> f32 {
    let size = abs(x);
    let is_large = size > 1.0;
    let t = select(size, divided(-1.0, size), is_large);
    let square = t * t;
    let small = t * square * polynomial_atan(square) + select(0.0, FRAC_PI_2_TAIL, is_large);
    if (is_nan(x)) { return x; }
    return strict(with_sign_of((select(0.0, FRAC_PI_2, is_large) + t) + small, x));
}

fn arc_tangent_2(y: f32, x: f32) -> f32 {
    if (is_nan(x) || is_nan(y)) { return opaque(MAGNITUDE); }
    let width = abs(x);
    let height = abs(y);
    let is_steep = height > width;
    let small = select(height, width, is_steep);
    let large = select(width, height, is_steep);
    // 0 / 0 becomes 0, and infinity / infinity becomes 1.
    let quotient = select(divided(small, at_least(large, 1.17549435e-38)), 1.0, small == large && large > 0.0);
    let is_left = (bitcast<u32>(x) & SIGN) != 0u;
    let offset = select(select(0.0, PI, is_left), FRAC_PI_2, is_steep);
    let square = quotient * quotient;
    let t = select(quotient, -quotient, is_left != is_steep);
    let rest = t * square * polynomial_atan(square) + offset * (FRAC_PI_2_TAIL / FRAC_PI_2);
    return strict(with_sign_of((offset + t) + rest, y));
}

fn texel_fraction(x: f32) -> f32 {
    let part = x - floor(x);
    return select(0.0, part, (bitcast<u32>(x) & MAGNITUDE) < 0x4b000000u);
}

// A component of the colour of the texture of a number, between the middles of texels. It repeats.
fn texture_component(number: f32, u: f32, v: f32, component: f32) -> f32 {
    let index = select(0u, u32(at_most(number, 65536.0) + 0.5), number > 0.0);
    if (index >= arrayLength(&textures)) { return 1.0; }
    let place = textures[index];
    if (place.y == 0u) { return 1.0; }
    let column = texel_fraction(u) * f32(place.y) - 0.5;
    let row = texel_fraction(v) * f32(place.z) - 0.5;
    let left = select(min(u32(max(column, 0.0)), place.y - 1u), place.y - 1u, column < 0.0);
    let low = select(min(u32(max(row, 0.0)), place.z - 1u), place.z - 1u, row < 0.0);
    let right = select(left + 1u, 0u, left + 1u == place.y);
    let high = select(low + 1u, 0u, low + 1u == place.z);
    let channel = min(u32(max(component, 0.0) + 0.5), 2u);
    let s = column - floor(column);
    let t = row - floor(row);
    let below = mixed(texel(place, left, low, channel), texel(place, right, low, channel), s);
    let above = mixed(texel(place, left, high, channel), texel(place, right, high, channel), s);
    return mixed(below, above, t);
}

fn mixed(a: f32, b: f32, share: f32) -> f32 { return a * (1.0 - share) + b * share; }

fn texel(place: vec4<u32>, x: u32, y: u32, channel: u32) -> f32 {
    return texels[place.x + 3u * (y * place.y + x) + channel];
}
