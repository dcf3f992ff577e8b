//! Colours for numbers.

/// The colours of numbers from 0 to 1, from dark to bright, evenly to the eye and also for those who see few colours:
/// viridis by Smith and van der Walt (2015), in public domain, at nine places.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The colour of a number from 0 to 1, as 8-bit sRGB. What is outside has the colour of the nearest end, and NaN is
/// magenta.
pub fn false_colour(value: f64) -> [u8; 3] {
    if value.is_nan() {
        return [255, 0, 255];
    }
    let place = value.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let index = (place.floor() as usize).min(VIRIDIS.len() - 2);
    mixed(VIRIDIS[index], VIRIDIS[index + 1], place - index as f64)
}

/// A colour between two others: the first one at 0, the second one at 1.
pub(super) fn mixed(one: [u8; 3], other: [u8; 3], share: f64) -> [u8; 3] {
    // The cast saturates.
    std::array::from_fn(|index| {
        let (from, to) = (f64::from(one[index]), f64::from(other[index]));
        (from + share * (to - from)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn false_colours_become_brighter() {
        // Relative luminance, from the components as they are stored.
        let luminance =
            |[red, green, blue]: [u8; 3]| 0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue);
        let steps: Vec<f64> = (0..=64).map(|step| luminance(false_colour(f64::from(step) / 64.0))).collect();
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0]), "{steps:?}");
        assert_eq!((false_colour(-3.0), false_colour(7.0)), ([68, 1, 84], [253, 231, 37]));
        assert_eq!(false_colour(f64::NAN), [255, 0, 255]);
    }
}
