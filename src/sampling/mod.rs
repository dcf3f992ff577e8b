//! Low-discrepancy points: where the ray of a pixel goes through it in each pass, and which samples of lights a hit
//! takes.
//!
//! A picture is the mean of passes. The points of one pixel over the passes are a Sobol sequence (Sobol 1967), so they
//! fill the unit square evenly. In the first pass, the point is the centre. A light has another pair of coordinates of
//! the same sequence, so that the points of a pixel and of a light together fill four dimensions evenly: the edge of a
//! shadow becomes smooth faster than by independent points. Each pixel has an order of its own, and each pair of a
//! route of rays and a light is scrambled on its own after Owen (Burley 2020, "Practical Hash-based Owen Scrambling"),
//! so that neighbouring pixels and different lights have independent errors. The first 2^m points stay evenly spread. A
//! point depends on nothing else: any pass can be made alone, in any order.
//!
//! [`EvenSequence`] is for choosing a few points of anything else.
//!
//! What points are used for is not known here.

mod even;

pub use even::EvenSequence;

/// Which samples a hit takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleKey {
    /// The pass, counted from 0.
    pub pass: u32,
    /// The pixel, counted row by row from the top left of the picture.
    pub pixel: u32,
    /// The route to the hit.
    pub route: Route,
}

/// How the rays from the camera to a hit went on: reflected or refracted at each hit between.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Route(u32);

impl Route {
    /// That of the camera's ray.
    pub const PRIMARY: Route = Route(1);

    /// The route that goes on by a reflected ray.
    #[must_use]
    pub fn reflected(self) -> Self {
        Self(2 * self.0)
    }

    /// The route that goes on by a refracted ray.
    #[must_use]
    pub fn refracted(self) -> Self {
        Self(2 * self.0 + 1)
    }
}

/// A sample of one light at one hit.
#[derive(Debug, Clone, Copy)]
pub struct Draw {
    pass: u32,
    pixel: u32,
    seed: u32,
}

impl SampleKey {
    /// The sample of the light with this index.
    #[inline]
    pub fn draw(&self, light: u32) -> Draw {
        Draw { pass: self.pass, pixel: self.pixel, seed: mixed(mixed(self.pixel, self.route.0), light + 1) }
    }
}

impl Draw {
    /// Its point in the unit square, each number greater than 0 and less than 1.
    pub fn point(&self) -> [f64; 2] {
        // Most lights ask for no point, so it is computed only here.
        scrambled(second_pair(order(self.pass, self.pixel)), self.seed)
    }
}

/// The point of a pixel through which its ray goes, 0..1 from its top left corner. It is the centre in the first pass.
#[inline]
pub fn pixel_point(pass: u32, pixel: u32) -> [f64; 2] {
    if pass == 0 { [0.5; 2] } else { scrambled(order(pass, pixel), mixed(pixel, 0)) }
}

/// The index in the sequence of the point of a pixel in a pass. Orders of different pixels are independent, and the
/// first 2^m passes have the indices of 2^m points that stand together.
fn order(pass: u32, pixel: u32) -> u32 {
    permuted(pass.reverse_bits(), mixed(pixel, 0)).reverse_bits()
}

/// The index of the point that is the second pair of coordinates of another index: its bits times a matrix over the
/// numbers modulo 2, of which these are the columns. The matrix is triangular with ones in its diagonal, so the second
/// pair is spread as evenly as the first. A search found it: the first 2^m points of all four coordinates are a
/// (2, m, 4)-net up to m = 8 and a (3, m, 4)-net up to m = 11, while the first four coordinates of Sobol's sequence are
/// a (3, m, 4)-net. (A (t, m, s)-net has 2^t points in each box of the volume 2^(t−m); Niederreiter 1987.)
const SECOND_PAIR: [u32; 16] = [
    0x0001, 0x0003, 0x0004, 0x000d, 0x0012, 0x0032, 0x0061, 0x00e7, 0x013c, 0x0265, 0x06bf, 0x0dcb, 0x1b4e, 0x29c6, 0x7fa4,
    0xe897,
];

/// The index of the point that is the second pair of coordinates, see [`SECOND_PAIR`].
fn second_pair(index: u32) -> u32 {
    // There are no more passes than the matrix has indices, but an order may set higher bits.
    let high = index >> SECOND_PAIR.len() << SECOND_PAIR.len();
    let columns = SECOND_PAIR.iter().enumerate().filter(|(bit, _)| index >> bit & 1 == 1);
    columns.fold(high, |product, (_, column)| product ^ column)
}

/// A point of the Sobol sequence, scrambled after Owen: points with different seeds are independent.
fn scrambled(index: u32, seed: u32) -> [f64; 2] {
    // The first coordinate is the index with its bits in reverse order. Here that order is reversed again.
    let [x, y] = [permuted(index, mixed(seed, 1)), permuted(second(index).reverse_bits(), mixed(seed, 2))];
    [x, y].map(|bits| (f64::from(bits.reverse_bits()) + 0.5) / 4_294_967_296.0)
}

/// The second coordinate of the Sobol sequence, as a fraction of 2³². Its direction numbers are the rows of Pascal's
/// triangle modulo 2.
fn second(mut index: u32) -> u32 {
    let mut direction = 1 << 31;
    let mut coordinate = 0;
    while index != 0 {
        if index & 1 == 1 {
            coordinate ^= direction;
        }
        index >>= 1;
        direction ^= direction >> 1;
    }
    coordinate
}

/// A permutation of numbers in which a bit depends on the bits below it alone: Owen scrambling of bits in reverse order
/// (Laine and Karras 2011, with the constants of Burley 2020).
fn permuted(bits: u32, seed: u32) -> u32 {
    let mut x = bits.wrapping_add(seed);
    for constant in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6_u32] {
        x ^= x.wrapping_mul(constant);
    }
    x
}

/// A number that depends on all bits of two others (Steele, Lea and Flood 2014, the last step of SplitMix).
#[inline]
fn mixed(one: u32, other: u32) -> u32 {
    let mut z = (u64::from(one) << 32 | u64::from(other)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ z >> 31) >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draws(pixel: u32) -> impl Fn(u32) -> Draw {
        move |pass| SampleKey { pass, pixel, route: Route::PRIMARY.reflected() }.draw(3)
    }

    #[test]
    fn the_sequence_is_that_of_sobol() {
        // The first points of Sobol's sequence in two dimensions, in the order of its definition, without Gray code.
        let expected = [[0.0, 0.0], [0.5, 0.5], [0.25, 0.75], [0.75, 0.25], [0.125, 0.625], [0.625, 0.125], [0.375, 0.375]];
        for (index, expected) in expected.into_iter().enumerate() {
            let index = index as u32;
            let point = [index.reverse_bits(), second(index)].map(|bits| f64::from(bits) / 4_294_967_296.0);
            assert_eq!(point, expected, "{index}");
        }
    }

    #[test]
    fn as_many_points_as_a_power_of_two_lie_in_all_elementary_intervals() {
        for pixel in 0..40 {
            let draw = draws(pixel);
            for power in [1, 4, 6] {
                let points: Vec<[f64; 2]> = (0..1 << power).map(|pass| draw(pass).point()).collect();
                for columns in 0..=power {
                    let sides = [1 << columns, 1 << (power - columns)].map(f64::from);
                    let mut cells: Vec<[u32; 2]> =
                        points.iter().map(|[x, y]| [(x * sides[0]) as u32, (y * sides[1]) as u32]).collect();
                    cells.sort_unstable();
                    cells.dedup();
                    assert_eq!(cells.len(), points.len(), "pixel {pixel}, {points:?}");
                }
            }
        }
    }

    #[test]
    fn the_points_of_a_pixel_and_a_light_are_nets_in_four_dimensions() {
        // The bits of the coordinates, the first in the highest place.
        let first = |index: u32| [index.reverse_bits(), second(index)];
        let coordinates = |index: u32| [first(index), first(second_pair(index))].concat();
        // The points that share their first bits, as many bits of each coordinate as `lengths` says, are equally many.
        let is_even = |power: u32, lengths: &[u32]| {
            let mut counts = vec![0_u32; 1 << lengths.iter().sum::<u32>()];
            for index in 0..1 << power {
                let cell = coordinates(index).into_iter().zip(lengths).fold(0_usize, |cell, (bits, length)| {
                    let first = if *length == 0 { 0 } else { bits >> (32 - length) };
                    cell << length | first as usize
                });
                counts[cell] += 1;
            }
            counts.iter().all(|count| *count == counts[0])
        };
        for power in 4..=11 {
            let (loss, all) = if power <= 8 { (2, power - 2) } else { (3, power - 3) };
            for a in 0..=all {
                for b in 0..=all - a {
                    for c in 0..=all - a - b {
                        let lengths = [a, b, c, all - a - b - c];
                        assert!(is_even(power, &lengths), "2^{power} points, t = {loss}, {lengths:?}");
                    }
                }
            }
            for length in 0..=power {
                assert!(is_even(power, &[0, 0, length, power - length]), "the second pair of 2^{power} points, {length}");
            }
        }
    }

    #[test]
    fn pairs_of_sequences_are_spread_together() {
        for pixel in 0..40 {
            let draw = draws(pixel);
            let mut counts = [0; 4];
            for pass in 0..256 {
                let halves = [pixel_point(pass, pixel)[0], draw(pass).point()[0]].map(|x| usize::from(x >= 0.5));
                counts[2 * halves[0] + halves[1]] += 1;
            }
            assert!(counts.iter().all(|count| (40..90).contains(count)), "pixel {pixel}: {counts:?}");
        }
    }

    #[test]
    fn pixels_routes_and_lights_have_points_of_their_own() {
        let key = SampleKey { pass: 5, pixel: 70, route: Route::PRIMARY };
        let others = [
            SampleKey { pass: 6, ..key },
            SampleKey { pixel: 71, ..key },
            SampleKey { route: Route::PRIMARY.reflected(), ..key },
            SampleKey { route: Route::PRIMARY.refracted(), ..key },
        ];
        let mut points: Vec<[f64; 2]> = others.iter().map(|key| key.draw(0).point()).collect();
        points.extend([key.draw(0).point(), key.draw(1).point(), pixel_point(5, 70)]);
        points.sort_by(|one, other| one[0].total_cmp(&other[0]));
        assert!(points.windows(2).all(|pair| (pair[0][0] - pair[1][0]).abs() > 1e-6), "{points:?}");
        assert_eq!(pixel_point(0, 70), [0.5; 2]);
    }

    #[test]
    fn points_of_neighbouring_pixels_are_independent() {
        // The correlation of 4000 pairs of independent numbers is within 4/√4000 in all but one of 15,000 cases.
        let centred = |pixel: u32| draws(pixel)(9).point()[0] - 0.5;
        let correlation = (0..4000).map(|pixel| 12.0 * centred(pixel) * centred(pixel + 1)).sum::<f64>() / 4000.0;
        assert!(correlation.abs() < 0.063, "{correlation}");
    }
}
