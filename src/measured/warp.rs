//! Functions on grids over the unit square, which may depend on the direction to the view, and the map that a density
//! gives: the marginal and conditional distributions of J. Dupuy and W. Jakob, "An Adaptive Parameterization for
//! Efficient Material Acquisition and Rendering", SIGGRAPH Asia 2018, section 4.

/// Numbers on grids over the unit square: one grid for each azimuth and each polar angle of a direction. Values between
/// the points are interpolated linearly in all four coordinates.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grids<const N: usize> {
    /// Points along x and along y, at least 2 each. x varies fastest.
    pub(super) size: [usize; 2],
    /// The azimuths and the polar angles of the grids in radians, growing, at least 1 each. Polar angles vary faster.
    pub(super) angles: [Vec<f32>; 2],
    pub(super) values: Vec<[f32; N]>,
}

/// Up to four grids with their weights.
pub(super) type GridWeights = [(usize, f64); 4];

/// A point of the unit square between four points of a grid.
struct GridCell {
    column: usize,
    row: usize,
    /// The shares of the right and of the upper points.
    x: f64,
    y: f64,
}

/// The index of the point of a growing list below a number, and the share of the next point.
fn between(points: &[f32], number: f64) -> (usize, f64) {
    if points.len() < 2 {
        return (0, 0.0);
    }
    let first = points.partition_point(|point| f64::from(*point) <= number).saturating_sub(1).min(points.len() - 2);
    let [from, to] = [points[first], points[first + 1]].map(f64::from);
    (first, ((number - from) / (to - from)).clamp(0.0, 1.0))
}

fn mixed(a: f64, b: f64, share: f64) -> f64 {
    a * (1.0 - share) + b * share
}

impl<const N: usize> Grids<N> {
    /// One grid for all directions.
    pub(super) fn alone(size: [usize; 2], values: Vec<[f32; N]>) -> Self {
        Self { size, angles: [vec![0.0], vec![0.0]], values }
    }

    /// The grids around a direction.
    pub(super) fn around(&self, azimuth: f64, polar: f64) -> GridWeights {
        let [azimuths, polars] = &self.angles;
        let (column, across) = between(azimuths, azimuth);
        let (row, along) = between(polars, polar);
        let next = |index: usize, points: &[f32]| (index + 1).min(points.len() - 1);
        let (columns, rows) = ([column, next(column, azimuths)], [row, next(row, polars)]);
        [0, 1, 2, 3].map(|corner| {
            let (right, upper) = (corner & 1, corner >> 1);
            let weight = if right == 1 { across } else { 1.0 - across } * if upper == 1 { along } else { 1.0 - along };
            (columns[right] * polars.len() + rows[upper], weight)
        })
    }

    fn cell(&self, [x, y]: [f64; 2]) -> GridCell {
        let place = |coordinate: f64, count: usize| {
            let place = coordinate.clamp(0.0, 1.0) * (count - 1) as f64;
            let first = (place as usize).min(count - 2);
            (first, place - first as f64)
        };
        let ((column, x), (row, y)) = (place(x, self.size[0]), place(y, self.size[1]));
        GridCell { column, row, x, y }
    }

    /// The values at a point of a grid.
    fn of_grid(&self, grid: usize, column: usize, row: usize) -> [f32; N] {
        let [width, height] = self.size;
        self.values[(grid * height + row) * width + column]
    }

    /// The values at a point of the unit square.
    pub(super) fn at(&self, grids: &GridWeights, point: [f64; 2]) -> [f64; N] {
        let GridCell { column, row, x, y } = self.cell(point);
        let corners = [(0, 0, (1.0 - x) * (1.0 - y)), (1, 0, x * (1.0 - y)), (0, 1, (1.0 - x) * y), (1, 1, x * y)];
        let mut sums = [0.0; N];
        for &(grid, weight) in grids.iter().filter(|(_, weight)| *weight > 0.0) {
            for (right, upper, share) in corners {
                let values = self.of_grid(grid, column + right, row + upper);
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += weight * share * f64::from(value);
                }
            }
        }
        sums
    }
}

/// The map of the unit square onto itself that makes a density even.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Warp {
    /// The densities. The integral of each over its grid, with distance 1 between points, is 1.
    density: Grids<1>,
    /// For each point, the integral along its row from x = 0.
    along_rows: Grids<1>,
    /// For each row, the integral over all below it: grids of one column. They are asked for at points alone.
    below_rows: Grids<1>,
}

impl Warp {
    /// The map of these densities. `None` if one of them is negative somewhere, or 0 everywhere.
    pub(super) fn new(mut density: Grids<1>) -> Option<Self> {
        let [width, height] = density.size;
        let mut along_rows = density.clone();
        let mut below = Vec::with_capacity(density.values.len() / width);
        for (grid, sums) in
            density.values.chunks_exact_mut(width * height).zip(along_rows.values.chunks_exact_mut(width * height))
        {
            if grid.iter().any(|[value]| *value < 0.0) {
                return None;
            }
            // The sums are kept in double precision until they are divided by the whole.
            let mut totals = Vec::with_capacity(height);
            let mut exact = Vec::with_capacity(width * height);
            for row in grid.chunks_exact(width) {
                let mut sum = 0.0;
                exact.push(sum);
                for pair in row.windows(2) {
                    sum += 0.5 * (f64::from(pair[0][0]) + f64::from(pair[1][0]));
                    exact.push(sum);
                }
                totals.push(sum);
            }
            let whole: f64 = totals.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).sum();
            let factor = 1.0 / whole;
            if !(factor.is_finite() && factor > 0.0) {
                return None;
            }
            let mut sum = 0.0;
            below.push([0.0]);
            for pair in totals.windows(2) {
                sum += 0.5 * (pair[0] + pair[1]);
                below.push([(sum * factor) as f32]);
            }
            sums.iter_mut().zip(exact).for_each(|([to], sum)| *to = (sum * factor) as f32);
            grid.iter_mut().for_each(|[value]| *value = (f64::from(*value) * factor) as f32);
        }
        let below_rows = Grids { size: [1, height], angles: density.angles.clone(), values: below };
        Some(Self { density, along_rows, below_rows })
    }

    /// How many numbers it holds.
    pub(super) fn count(&self) -> usize {
        self.density.values.len() + self.along_rows.values.len() + self.below_rows.values.len()
    }

    /// The grids around a direction.
    pub(super) fn around(&self, azimuth: f64, polar: f64) -> GridWeights {
        self.density.around(azimuth, polar)
    }

    /// Where the map takes a point: its integrals along the row, in proportion to the whole row, and over all rows
    /// below.
    pub(super) fn invert(&self, grids: &GridWeights, point: [f64; 2]) -> [f64; 2] {
        let GridCell { column, row, x, y } = self.density.cell(point);
        let last = self.density.size[0] - 1;
        // Everything is linear in the grids, so each adds its part. Lookups are most of the work of a measurement, and
        // this way each of the grids is found once.
        let (mut left, mut right, mut before) = (0.0, 0.0, 0.0);
        let (mut lower, mut upper, mut rows_below) = (0.0, 0.0, 0.0);
        for &(grid, weight) in grids.iter().filter(|(_, weight)| *weight > 0.0) {
            let of = |grids: &Grids<1>, column: usize, row: usize| f64::from(grids.of_grid(grid, column, row)[0]);
            let in_cell = |grids: &Grids<1>, column: usize| mixed(of(grids, column, row), of(grids, column, row + 1), y);
            left += weight * in_cell(&self.density, column);
            right += weight * in_cell(&self.density, column + 1);
            before += weight * in_cell(&self.along_rows, column);
            lower += weight * of(&self.along_rows, last, row);
            upper += weight * of(&self.along_rows, last, row + 1);
            rows_below += weight * of(&self.below_rows, 0, row);
        }
        let along = before + x * (left + 0.5 * x * (right - left));
        let whole = mixed(lower, upper, y);
        let below = rows_below + y * (lower + 0.5 * y * (upper - lower));
        [if whole > 0.0 { along / whole } else { 0.0 }, below].map(|coordinate| coordinate.clamp(0.0, 1.0))
    }
}
