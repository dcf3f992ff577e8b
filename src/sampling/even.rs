//! Points that fill a cube of any number of dimensions evenly, however few there are.

/// The sequence of Roberts (2018), "The Unreasonable Effectiveness of Quasirandom Sequences": an additive recurrence,
/// whose steps are powers of a root.
#[derive(Debug, Clone, Copy)]
pub struct EvenSequence {
    /// The reciprocal of the root of x^(d+1) = x + 1 that is greater than 1. It makes the recurrence even.
    ratio: f64,
}

impl EvenSequence {
    /// The sequence in two dimensions.
    pub const SQUARE: Self = Self { ratio: 0.754_877_666_246_692_7 };

    /// The sequence in this many dimensions, at least 1.
    pub fn new(dimensions: usize) -> Self {
        let power = 1.0 / (dimensions as f64 + 1.0);
        let root = (0..64).fold(1.5_f64, |root, _| (1.0 + root).powf(power));
        Self { ratio: 1.0 / root }
    }

    /// A coordinate of the point with this index, from 0 to less than 1. Axes count from 0. The first point is the
    /// middle of the cube.
    pub fn coordinate(self, index: u32, axis: usize) -> f64 {
        (0.5 + f64::from(index) * self.ratio.powi(axis as i32 + 1)).fract()
    }

    /// The first coordinates of the point with this index.
    pub fn point<const DIMENSIONS: usize>(self, index: u32) -> [f64; DIMENSIONS] {
        std::array::from_fn(|axis| self.coordinate(index, axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_paper() {
        // Roberts 2018: 1/φ in one dimension, and 0.7548776662… with its square in two.
        for (dimensions, wanted) in [(1, 0.618_033_988_749_895), (2, 0.754_877_666_246_693), (3, 0.819_172_513_396_164)] {
            let sequence = EvenSequence::new(dimensions);
            assert!((sequence.ratio - wanted).abs() < 1e-14, "{dimensions}: {}", sequence.ratio);
        }
        let [x, y] = EvenSequence::SQUARE.point(1);
        assert!((x - 0.254_877_666_246_693).abs() < 1e-14 && (y - 0.069_840_290_998_053).abs() < 1e-14);
    }

    #[test]
    fn few_points_fill_each_part_of_a_square() {
        let mut counts = [0_u32; 64];
        for index in 0..640 {
            let [x, y] = EvenSequence::SQUARE.point(index).map(|share: f64| (8.0 * share) as usize);
            counts[8 * y + x] += 1;
        }
        assert!(counts.iter().all(|count| (7..=13).contains(count)), "{counts:?}");
    }
}
