//! The numbers of a chart as rows of text.

use crate::plot::typeface::SUBSCRIPT;
use std::collections::HashSet;
use std::fmt::Write;

/// Columns of numbers and texts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NumberTable {
    /// The names of the columns.
    pub columns: Vec<String>,
    /// The rows, each with one number for each column.
    pub rows: Vec<Vec<f64>>,
    /// Rows and columns where there is nothing, not even a value that is no number.
    pub empty: HashSet<[usize; 2]>,
}

impl NumberTable {
    /// The table as comma-separated values (RFC 4180, with line feeds): a row of names, then the numbers, with as many
    /// digits as tell them apart. NaN is `nan`; where there is nothing, the cell is empty.
    pub fn csv(&self) -> String {
        let mut text = String::new();
        let names: Vec<String> = self.columns.iter().map(|name| quoted(name)).collect();
        text.push_str(&names.join(","));
        text.push('\n');
        for (number_of_row, row) in self.rows.iter().enumerate() {
            for (index, number) in row.iter().enumerate() {
                let comma = if index == 0 { "" } else { "," };
                // Writing to a string does not fail.
                let _ = match number.is_nan() {
                    true if self.empty.contains(&[number_of_row, index]) => write!(text, "{comma}"),
                    true => write!(text, "{comma}nan"),
                    false => write!(text, "{comma}{number}"),
                };
            }
            text.push('\n');
        }
        text
    }
}

/// A name as a cell. What charts show small and low is as large as the rest.
fn quoted(name: &str) -> String {
    let name: String = name.chars().filter(|character| !character.is_control() && *character != SUBSCRIPT).collect();
    if name.contains([',', '"']) { format!("\"{}\"", name.replace('"', "\"\"")) } else { name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_are_quoted() {
        let table = NumberTable {
            columns: vec!["angle (°)".into(), "a, \"b\"\n".into()],
            rows: vec![vec![-90.0, 0.1 + 0.2], vec![1e-12, f64::NAN], vec![2.0, f64::NAN]],
            empty: HashSet::from([[2, 1]]),
        };
        assert_eq!(table.csv(), "angle (°),\"a, \"\"b\"\"\"\n-90,0.30000000000000004\n0.000000000001,nan\n2,\n");
    }
}
