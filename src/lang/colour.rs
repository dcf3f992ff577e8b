//! Colours as other programs write them: `#rrggbb`, and the transfer function of sRGB (IEC 61966-2-1).

/// The linear component 0..1 that sRGB stores as this number 0..1.
pub fn linear_from_srgb(stored: f64) -> f64 {
    if stored <= 0.040_45 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
}

/// The colour that the digits of `#rgb` or `#rrggbb` mean, as it is stored: red, green and blue, 0..1.
pub fn hexadecimal_colour(digits: &str) -> Option<[f64; 3]> {
    let step = match digits.len() {
        3 => 1,
        6 => 2,
        _ => return None,
    };
    let largest = if step == 1 { 15.0 } else { 255.0 };
    let component = |index: usize| {
        let value = u32::from_str_radix(digits.get(step * index..step * (index + 1))?, 16).ok()?;
        Some(f64::from(value) / largest)
    };
    Some([component(0)?, component(1)?, component(2)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_colours() {
        assert_eq!(hexadecimal_colour("ff8800").map(|colour| colour[0]), Some(1.0));
        assert_eq!(hexadecimal_colour("f80"), hexadecimal_colour("ff8800"));
        assert_eq!(hexadecimal_colour("f8"), None);
        assert_eq!(hexadecimal_colour("define"), None);
    }
}
