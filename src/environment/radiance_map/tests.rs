//! Maps against closed forms, and what is drawn against what is there.

use super::*;
use std::f64::consts::TAU;

/// A map by a function of column and row.
fn map(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3] + Sync) -> RadianceMap {
    let write = |row: u32, texels: &mut [[f32; 3]]| {
        texels.iter_mut().zip(0..).for_each(|(written, column)| *written = texel(column, row));
    };
    let (map, repairs) = RadianceMap::of_rows(width, height, write).expect("a size");
    assert_eq!(repairs, MapRepairs::default());
    map
}

/// How densely directions are drawn around one of any length greater than 0, per steradian, by the weights of the
/// cells.
fn density(map: &RadianceMap, direction: DVec3) -> f64 {
    let Some(map) = &map.texels else { return 0.25 / PI };
    let place = MapPlace::of(direction);
    let [column, row] = [(place.u, map.texels.width), (place.v, map.texels.height)]
        .map(|(place, count)| ((place * count as f64) as usize).min(count - 1) / map.side);
    map.cells.probability(column, row) / map.solid_angle(column, row)
}

/// A sky that is brighter above, with a sun of a few texels, 10⁵ times as bright, and a black floor.
fn sunny(width: u32, height: u32) -> RadianceMap {
    map(width, height, |column, row| {
        let is_sun = (width / 3..width / 3 + 2).contains(&column) && (height / 4..height / 4 + 2).contains(&row);
        match (is_sun, 2 * row < height) {
            (true, _) => [1e5, 0.9e5, 0.7e5],
            (false, true) => [0.4, 0.5, 1.0 + (height - row) as f32 / height as f32],
            (false, false) => [0.0; 3],
        }
    })
}

/// The points of a sequence that fills the unit square evenly (Roberts 2018: the additive recurrence R2).
fn points(count: u32) -> impl Iterator<Item = [f64; 2]> {
    (1..=count).map(|index| [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step: f64| (step * f64::from(index)).fract()))
}

/// Points of a generator of pseudorandom numbers (Steele, Lea, Flood 2014: SplitMix64).
fn random_points(count: u32) -> impl Iterator<Item = [f64; 2]> {
    let number = |index: u64| {
        let mut bits = (index + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..u64::from(count)).map(move |index| [number(2 * index), number(2 * index + 1)])
}

/// The directions of the middles of a grid over the sphere, each with its solid angle.
fn grid(columns: u32, rows: u32) -> impl Iterator<Item = (DVec3, f64)> {
    (0..rows).flat_map(move |row| {
        let polar = PI * (f64::from(row) + 0.5) / f64::from(rows);
        let part = 2.0 * polar.sin() * (0.5 * PI / f64::from(rows)).sin() * TAU / f64::from(columns);
        (0..columns).map(move |column| {
            let longitude = TAU * (f64::from(column) + 0.5) / f64::from(columns);
            (DVec3::new(polar.sin() * longitude.sin(), polar.cos(), polar.sin() * longitude.cos()), part)
        })
    })
}

#[test]
fn a_bright_texel_is_found_where_the_convention_puts_it() {
    // The middles of the texels of an image of 8×4, by hand: longitude 180° − 45°·(column + 0.5), polar angle
    // 45°·(row + 0.5).
    for (column, row, longitude, polar) in
        [(0, 0, 157.5, 22.5), (1, 1, 112.5, 67.5), (3, 2, 22.5, 112.5), (4, 1, -22.5, 67.5), (7, 3, -157.5, 157.5_f64)]
    {
        let map = map(8, 4, |x, y| if (x, y) == (column, row) { [3.0, 2.0, 1.0] } else { [0.0; 3] });
        let (longitude, polar) = (f64::to_radians(longitude), polar.to_radians());
        let direction = DVec3::new(polar.sin() * longitude.sin(), polar.cos(), polar.sin() * longitude.cos());
        let found = map.radiance(direction);
        assert!(found.iter().zip([3.0, 2.0, 1.0]).all(|(found, expected)| (found - expected).abs() < 1e-5), "{found:?}");
        assert!(map.radiance(-direction).iter().all(|component| *component < 1e-5));
        let drawn = map.sample([0.5, 0.5]).expect("a direction");
        assert!(drawn.direction.dot(direction) > (45_f64.to_radians()).cos(), "{drawn:?}");
    }
}

#[test]
fn radiance_is_interpolated_around_and_ends_at_the_poles() {
    let map = map(4, 2, |column, row| [column as f32, row as f32, 0.0]);
    let at = |u: f64, v: f64| map.radiance(direction(u, [(PI * v).sin(), (PI * v).cos()]));
    let near = |found: [f32; 3], expected: [f32; 3]| {
        assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-5), "{found:?} {expected:?}");
    };
    near(at(0.375, 0.25), [1.0, 0.0, 0.0]);
    near(at(0.5, 0.25), [1.5, 0.0, 0.0]);
    near(at(0.5, 0.5), [1.5, 0.5, 0.0]);
    // Between the last column and the first.
    near(at(0.0, 0.75), [1.5, 1.0, 0.0]);
    near(at(0.9375, 0.75), [2.25, 1.0, 0.0]);
    near(at(0.375, 0.01), [1.0, 0.0, 0.0]);
    near(at(0.375, 0.99), [1.0, 1.0, 0.0]);
    assert_eq!(map.radiance(1e-30 * DVec3::Z), map.radiance(1e30 * DVec3::Z));
}

#[test]
fn the_density_is_that_of_a_distribution() {
    // Cells of one texel, where the grid divides them, and of a map whose width is odd.
    for map in [sunny(32, 16), sunny(33, 16), map(1, 1, |_, _| [2.0; 3]), RadianceMap::WHITE] {
        let total: f64 = grid(528, 256).map(|(direction, part)| density(&map, direction) * part).sum();
        assert!((total - 1.0).abs() < 1e-9, "{total}");
    }
}

#[test]
fn light_comes_only_from_where_directions_are_drawn() {
    let map = sunny(32, 16);
    let (mut lit, mut dark) = (0, 0);
    for (direction, _) in grid(331, 171) {
        let brightest = map.radiance(direction).into_iter().fold(0.0, f32::max);
        let density = density(&map, direction);
        assert!(density > 0.0 || brightest == 0.0, "{direction}");
        lit += u32::from(brightest > 0.0);
        dark += u32::from(density == 0.0);
    }
    assert!(lit > 20_000 && dark > 20_000, "{lit} {dark}");
}

#[test]
fn samples_have_the_density_that_is_said() {
    for map in [sunny(32, 16), map(7, 5, |column, row| [column as f32, 0.5, row as f32]), RadianceMap::WHITE] {
        for point in points(2000) {
            let drawn = map.sample(point).expect("a direction");
            assert!((drawn.direction.length() - 1.0).abs() < 1e-14 && drawn.density > 0.0);
            // The direction is not between two cells but by chance.
            let density = density(&map, drawn.direction);
            assert!((drawn.density / density - 1.0).abs() < 1e-9, "{drawn:?} {density}");
            let radiance = map.radiance(drawn.direction);
            let error = |(a, b): (&f32, f32)| (a - b).abs() <= 1e-4 * (a.abs() + 1.0);
            assert!(drawn.radiance.iter().zip(radiance).all(error), "{drawn:?} {radiance:?}");
        }
    }
}

#[test]
fn samples_pass_the_chi_square_test() {
    const COUNT: u32 = 200_000;
    let gentle = map(24, 12, |column, row| [1.0 + (column % 5) as f32, 1.0 + (row % 3) as f32, 0.5]);
    for map in [gentle, sunny(24, 12), RadianceMap::WHITE] {
        // Bins other than the cells.
        let (columns, rows) = (10, 9);
        let bin = |direction: DVec3| {
            let turn = direction.x.atan2(direction.z) / TAU + 0.5;
            let polar = direction.y.clamp(-1.0, 1.0).acos() / PI;
            let at = |share: f64, count: usize| ((share * count as f64) as usize).min(count - 1);
            at(polar, rows) * columns + at(turn, columns)
        };
        let (mut expected, mut counted) = (vec![0.0; columns * rows], vec![0.0; columns * rows]);
        for (direction, part) in grid(960, 1080) {
            expected[bin(direction)] += f64::from(COUNT) * density(&map, direction) * part;
        }
        for point in random_points(COUNT) {
            counted[bin(map.sample(point).expect("a direction").direction)] += 1.0;
        }
        // Bins of few samples are put together.
        let (mut rest, mut chi_square, mut bins) = ([0.0; 2], 0.0, 0);
        for (expected, counted) in expected.into_iter().zip(counted) {
            if expected < 5.0 {
                rest = [rest[0] + expected, rest[1] + counted];
            } else {
                chi_square += (counted - expected) * (counted - expected) / expected;
                bins += 1;
            }
        }
        if rest[0] > 5.0 {
            chi_square += (rest[1] - rest[0]) * (rest[1] - rest[0]) / rest[0];
        } else {
            assert!(rest[1] < 30.0, "{rest:?}");
        }
        // Far beyond the mean and the standard deviation of the distribution: n and √(2n).
        let freedom = f64::from(bins);
        assert!(chi_square < freedom + 5.0 * (2.0 * freedom).sqrt() + 5.0, "{chi_square} {bins}");
        assert!(bins >= 3, "{bins}");
    }
}

#[test]
fn sampling_gives_the_integral_of_the_radiance() {
    let map = sunny(64, 32);
    let weight = |radiance: [f32; 3]| radiance.map(f64::from);
    let mut expected = [0.0; 3];
    // The cosine of a floor that looks up.
    for (direction, part) in grid(2048, 1024) {
        let radiance = weight(map.radiance(direction));
        (0..3).for_each(|index| expected[index] += radiance[index] * direction.y.max(0.0) * part);
    }
    let (mut found, mut largest, count) = ([0.0; 3], 0.0_f64, 1 << 14);
    for point in points(count) {
        let drawn = map.sample(point).expect("a direction");
        let radiance = weight(drawn.radiance).map(|component| component * drawn.direction.y.max(0.0) / drawn.density);
        (0..3).for_each(|index| found[index] += radiance[index] / f64::from(count));
        largest = largest.max(radiance[1]);
    }
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
    }
    // No sample stands out. The worst is the corner of a bright texel: it has 1/4 of its light, and the cell beyond the
    // corner has 0.174² of its weight.
    assert!(largest < 1.1 * 0.25 / (0.174 * 0.174) * expected[1], "{largest} {expected:?}");
}

#[test]
fn one_bright_texel_has_the_least_variance() {
    // At the equator, where rows are of one size. The second moment of light by density is, along each axis, the square
    // of the sum of the roots of the mean squares: (√(7/12) + 2·√(1/24))² = 1.37361.
    let map = map(512, 256, |column, row| if (column, row) == (100, 128) { [1.0; 3] } else { [0.0; 3] });
    let (mut first, mut second, count) = (0.0, 0.0, 1 << 15);
    for point in points(count) {
        let drawn = map.sample(point).expect("a direction");
        let light = f64::from(drawn.radiance[1]) / drawn.density;
        first += light / f64::from(count);
        second += light * light / f64::from(count);
    }
    let moment = second / (first * first);
    assert!((moment / (1.37361 * 1.37361) - 1.0).abs() < 0.005, "{moment}");
}

#[test]
fn white_is_even() {
    let white = RadianceMap::WHITE;
    assert_eq!((white.radiance(DVec3::new(1.0, -2.0, 3.0)), white.size(), white.memory()), ([1.0; 3], None, 0));
    let count = 4096;
    let mut mean = DVec3::ZERO;
    let mut upwards = 0.0;
    for point in points(count) {
        let drawn = white.sample(point).expect("a direction");
        assert_eq!((drawn.radiance, drawn.density), ([1.0; 3], 0.25 / PI));
        mean += drawn.direction / f64::from(count);
        upwards += drawn.direction.y.max(0.0) / drawn.density / f64::from(count);
    }
    assert!(mean.length() < 0.01, "{mean}");
    // The irradiance of a floor under radiance 1 is π.
    assert!((upwards / PI - 1.0).abs() < 0.01, "{upwards}");
}

#[test]
fn black_has_no_samples() {
    let black = map(8, 4, |_, _| [0.0; 3]);
    assert_eq!((black.sample([0.3, 0.7]), density(&black, DVec3::X), black.radiance(DVec3::X)), (None, 0.0, [0.0; 3]));
}

#[test]
fn texels_that_are_no_radiance_are_counted() {
    let given = [[f32::NAN, -1.0, 2.0], [-0.5, -0.5, 1.0], [f32::INFINITY, 0.0, 0.0], [1e20, 0.0, 0.0], [1.0, 2.0, 3.0]];
    let (map, repairs) = RadianceMap::of_rows(5, 1, |_, texels| texels.copy_from_slice(&given)).expect("a size");
    let MapRepairs { not_numbers, too_bright, negative, negative_part } = repairs;
    assert_eq!((not_numbers, too_bright, negative), (1, 2, 2));
    // Below 0 are −1 and twice −0.5, above 2, 1, 1, 2 and 3. What is too large does not count.
    assert!((negative_part - 2.0 / 9.0).abs() < 1e-12, "{negative_part}");
    for beyond in [[-1.0; 3], [f32::NEG_INFINITY, 1.0, 1.0], [-1e20, 1.0, 1.0]] {
        let (_, repairs) = RadianceMap::of_rows(5, 1, |_, texels| texels.fill(beyond)).expect("a size");
        assert_eq!((repairs.negative, repairs.negative_part), (5, f64::INFINITY));
    }
    let texel = |column: f64| map.radiance(direction((column + 0.5) / 5.0, [1.0, 0.0]));
    assert_eq!((texel(0.0)[0], texel(0.0)[1]), (0.0, 0.0));
    assert!((texel(2.0)[0] / 8.585_741e9 - 1.0).abs() < 1e-3 && map.sample([0.5, 0.5]).is_some());
    for (width, height) in [(0, 1), (1, 0), (MAX_MAP_SIDE + 1, 1)] {
        assert!(RadianceMap::of_rows(width, height, |_, _| ()).is_none());
    }
}

#[test]
fn large_maps_have_cells_of_several_texels() {
    assert_eq!([cell_side(4096, 2048), cell_side(4097, 2048), cell_side(8192, 4096), cell_side(16_384, 8192)], [1, 2, 2, 4]);
    // 16384×8192 texels of 6 bytes, and at most 2²³ cells of 4 bytes with sums of 8 bytes for 16 of them.
    let memory = RadianceMap::memory_of(16_384, 8192);
    assert!((805_306_368..805_306_368 + (40 << 20)).contains(&memory), "{memory}");
    // Cells of 3×3 texels at most, where the last ones are smaller: 10 = 3 + 3 + 3 + 1, 8 = 3 + 3 + 2.
    let small = map(10, 8, |column, row| [(column * column) as f32, (row % 3) as f32, 1.0]);
    let Some(TexelMap { texels, .. }) = small.texels else { panic!("texels") };
    let cells = CellWeights::of_rows(4, 3, |row, weights| weigh(&texels, 3, row, weights));
    let large = RadianceMap { texels: Some(TexelMap { texels, side: 3, cells }) };
    let total: f64 = grid(480, 240).map(|(direction, part)| density(&large, direction) * part).sum();
    assert!((total - 1.0).abs() < 1e-9, "{total}");
    for point in points(500) {
        let drawn = large.sample(point).expect("a direction");
        assert!((drawn.density / density(&large, drawn.direction) - 1.0).abs() < 1e-9, "{drawn:?}");
    }
    // A texel sends the same light into cells of 2×2 texels as into those of one.
    let Some(one) = map(512, 512, |column, row| if (column, row) == (255, 255) { [1.0; 3] } else { [0.0; 3] }).texels else {
        panic!("texels")
    };
    let cells = |side: usize| {
        let count = 512 / side;
        CellWeights::of_rows(count, count, |row, weights| weigh(&one.texels, side, row, weights))
    };
    let (fine, coarse) = (cells(1), cells(2));
    assert!((coarse.total() / fine.total() - 1.0).abs() < 0.01);
    // Texel 255 is in cell 127, and sends a part into cell 128.
    let expected = [(127, 127, 0.826 * 0.826), (128, 127, 0.174 * 0.826), (128, 128, 0.174 * 0.174), (126, 127, 0.0)];
    for (column, row, expected) in expected {
        assert!((coarse.probability(column, row) - expected).abs() < 0.01, "{column} {row}");
    }
}
