// x to the power y as C's powf: whole exponents take negative bases, and x^0 is 1.
float power(float x, float y) {
    float size = pow(abs(x), y);
    if (y == 0.0 || x == 1.0) { return 1.0; }
    if (x == 0.0) { return y > 0.0 ? 0.0 : 1.0 / abs(x); }
    if (x > 0.0) { return size; }
    if (floor(y) != y) { return (x - x) / (x - x); }
    return floor(y * 0.5) * 2.0 == y ? size : -size;
}
