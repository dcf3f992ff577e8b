// x to the power y as C's powf: whole exponents take negative bases, and x^0 is 1.
fn power(x: f32, y: f32) -> f32 {
    let size = pow(abs(x), y);
    if (y == 0.0 || x == 1.0) { return 1.0; }
    if (x == 0.0) { return select(1.0 / abs(x), 0.0, y > 0.0); }
    if (x > 0.0) { return size; }
    if (floor(y) != y) { return (x - x) / (x - x); }
    return select(-size, size, floor(y * 0.5) * 2.0 == y);
}
