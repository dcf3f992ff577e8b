//! Drawing cells of a map in proportion to their weights.
//!
//! Rows are drawn by their sums, and cells within a row by theirs. A search inverts the sums, so points that are close
//! together lead to directions that are close together: points that are spread evenly stay so.

use rayon::prelude::*;

/// How many weights of a row share one entry in the sums of the row.
const BLOCK: usize = 16;

/// The weights of the cells of a map, with their sums.
///
/// Weights are `f32` and sums `f64`, so the weight of a dark cell is known beside a sun that is 10⁹ times as bright.
#[derive(Debug, PartialEq)]
pub(super) struct CellWeights {
    columns: usize,
    /// Row by row.
    weights: Vec<f32>,
    /// For each row, the sums of its weights up to the end of each block.
    blocks: Vec<f64>,
    /// The sums of all weights up to the end of each row.
    rows: Vec<f64>,
}

/// A cell that was drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DrawnCell {
    pub(super) column: usize,
    pub(super) row: usize,
    /// What remains of the two numbers that it was drawn by: where in the cell, from the left and from the top, 0..=1.
    pub(super) within: [f64; 2],
    /// Its weight as a part of all.
    pub(super) probability: f64,
}

impl CellWeights {
    /// The bytes that this many cells take.
    pub(super) fn memory_of(columns: usize, rows: usize) -> u64 {
        let in_row = columns * size_of::<f32>() + (columns.div_ceil(BLOCK) + 1) * size_of::<f64>();
        rows as u64 * in_row as u64
    }

    /// Weights of cells in rows of `columns`. `row` writes those of a row, which are finite and at least 0.
    pub(super) fn of_rows(columns: usize, rows: usize, row: impl Fn(usize, &mut [f32]) + Sync) -> Self {
        let in_row = columns.div_ceil(BLOCK);
        let (mut weights, mut blocks) = (vec![0.0; columns * rows], vec![0.0; in_row * rows]);
        let each = weights.par_chunks_mut(columns).zip(blocks.par_chunks_mut(in_row)).enumerate();
        each.for_each(|(index, (weights, blocks))| {
            row(index, weights);
            let mut sum = 0.0;
            for (weights, block) in weights.chunks(BLOCK).zip(blocks) {
                weights.iter().for_each(|weight| sum += f64::from(*weight));
                *block = sum;
            }
        });
        let mut sum = 0.0;
        let add = |blocks: &[f64]| {
            sum += blocks.last().copied().unwrap_or(0.0);
            sum
        };
        let rows = blocks.chunks(in_row).map(add).collect();
        Self { columns, weights, blocks, rows }
    }

    /// The sum of all weights.
    pub(super) fn total(&self) -> f64 {
        self.rows.last().copied().unwrap_or(0.0)
    }

    /// The weight of a cell as a part of all; 0 if all are 0.
    #[cfg(test)]
    pub(super) fn probability(&self, column: usize, row: usize) -> f64 {
        let total = self.total();
        let weight = f64::from(self.weights[row * self.columns + column]);
        if total > 0.0 { weight / total } else { 0.0 }
    }

    /// The bytes that it takes.
    pub(super) fn memory(&self) -> u64 {
        (size_of_val(self.weights.as_slice()) + size_of_val(self.blocks.as_slice()) + size_of_val(self.rows.as_slice())) as u64
    }

    /// The cell at a point of the unit square: its second number draws the row, and its first one the column. Cells of
    /// weight 0 are never drawn. `None` if all weights are 0.
    pub(super) fn draw(&self, [across, down]: [f64; 2]) -> Option<DrawnCell> {
        let total = self.total();
        if total <= 0.0 {
            return None;
        }
        let target = target(down, total);
        let row = self.rows.partition_point(|sum| *sum <= target);
        let before = row.checked_sub(1).map_or(0.0, |row| self.rows[row]);
        let from_top = (target - before) / (self.rows[row] - before);
        let in_row = self.columns.div_ceil(BLOCK);
        let blocks = &self.blocks[row * in_row..][..in_row];
        let target = self::target(across, blocks[in_row - 1]);
        let block = blocks.partition_point(|sum| *sum <= target);
        let mut before = block.checked_sub(1).map_or(0.0, |block| blocks[block]);
        let weights = &self.weights[row * self.columns..][..self.columns];
        let mut column = block * BLOCK;
        // The sums are those of the block, added in the same order. So the last one is beyond the target.
        while before + f64::from(weights[column]) <= target && column + 1 < self.columns {
            before += f64::from(weights[column]);
            column += 1;
        }
        let weight = f64::from(weights[column]);
        let from_left = (target - before) / weight;
        let within = [from_left, from_top].map(|part| part.clamp(0.0, 1.0));
        Some(DrawnCell { column, row, within, probability: weight / total })
    }
}

/// A share of a sum, which stays below the sum.
fn target(share: f64, sum: f64) -> f64 {
    (share * sum).clamp(0.0, sum.next_down())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three rows of 37 cells, some of weight 0, and one 10⁹ times as heavy as the others.
    fn weights() -> CellWeights {
        CellWeights::of_rows(37, 3, |row, weights| {
            for (column, weight) in weights.iter_mut().enumerate() {
                *weight = match (row, column) {
                    (1, _) => 0.0,
                    (0, 20) => 1e9,
                    (_, 0 | 5 | 36) => 0.0,
                    _ => 1.0 + (column % 4) as f32,
                };
            }
        })
    }

    #[test]
    fn cells_have_their_shares_of_the_square() {
        let weights = weights();
        let sum: f64 =
            (0..3).flat_map(|row| (0..37).map(move |column| (column, row))).map(|(c, r)| weights.probability(c, r)).sum();
        assert!((sum - 1.0).abs() < 1e-12, "{sum}");
        // Row 0 has all but about 10⁻⁷ of the weight.
        let of_row = |row: usize| (0..37).map(|column| weights.probability(column, row)).sum::<f64>();
        let row_0 = of_row(0);
        assert_eq!(of_row(1), 0.0);
        // At the middle of the share of each cell, the cell is drawn.
        for row in [0, 2] {
            let (mut sum, share) = (0.0, of_row(row));
            let down = if row == 0 { 0.5 * row_0 } else { 1.0 - 0.5 * share };
            for column in 0..37 {
                let probability = weights.probability(column, row);
                if probability > 0.0 {
                    let drawn = weights.draw([(sum + 0.5 * probability) / share, down]).expect("a cell");
                    assert_eq!((drawn.column, drawn.row, drawn.probability), (column, row, probability));
                    assert!((drawn.within[1] - 0.5).abs() < 1e-6, "{drawn:?}");
                    assert!((drawn.within[0] - 0.5).abs() < 0.01, "{drawn:?}");
                }
                sum += probability;
            }
        }
    }

    #[test]
    fn cells_of_no_weight_are_not_drawn() {
        let weights = weights();
        for across in [0.0, 1e-300, 0.5, 1.0 - f64::EPSILON, 1.0] {
            for down in [0.0, 1e-300, 0.5, 1.0 - f64::EPSILON, 1.0] {
                let drawn = weights.draw([across, down]).expect("a cell");
                assert!(drawn.probability > 0.0 && drawn.within.iter().all(|part| (0.0..=1.0).contains(part)), "{drawn:?}");
            }
        }
        let none = CellWeights::of_rows(5, 2, |_, weights| weights.fill(0.0));
        assert_eq!((none.draw([0.5, 0.5]), none.probability(0, 0), none.total()), (None, 0.0, 0.0));
    }

    #[test]
    fn the_memory_is_known_before() {
        let weights = weights();
        assert_eq!(weights.memory(), CellWeights::memory_of(37, 3));
    }
}
