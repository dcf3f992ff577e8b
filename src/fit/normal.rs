//! Residuals and their derivatives, multiplied out: what a least-squares step needs of any number of data.

use nalgebra::{DMatrix, DVector};

/// The products of residuals r and their Jacobian J: with A = (J | r) it is AᵀA, a square of one more row than there
/// are unknowns. It is as large for a million data as for ten.
#[derive(Debug, Clone, PartialEq)]
pub struct NormalEquations {
    products: DMatrix<f64>,
    /// Jᵀ·diag(r²)·J, where it is wanted: how much the residuals scatter where each unknown counts.
    scatter: Option<DMatrix<f64>>,
    /// The sum of the weights of the data.
    weight: f64,
    /// How many residuals there are.
    count: usize,
}

impl NormalEquations {
    /// No data, for this many unknowns.
    pub fn new(unknowns: usize) -> Self {
        Self { products: DMatrix::zeros(unknowns + 1, unknowns + 1), scatter: None, weight: 0.0, count: 0 }
    }

    /// No data, for this many unknowns. Those that are added tell how they scatter too.
    pub fn with_scatter(unknowns: usize) -> Self {
        Self { scatter: Some(DMatrix::zeros(unknowns, unknowns)), ..Self::new(unknowns) }
    }

    /// How many unknowns there are.
    pub fn unknowns(&self) -> usize {
        self.products.nrows() - 1
    }

    /// Adds a residual of a weight with its derivatives: `row` is the derivatives, followed by the residual.
    pub fn add(&mut self, weight: f64, row: &[f64]) {
        for (column, factor) in row.iter().enumerate() {
            let factor = weight * factor;
            // The other half is the mirror image.
            for (at, other) in row[..=column].iter().enumerate() {
                self.products[(at, column)] += factor * other;
            }
        }
        let (Some(scatter), Some((residual, slopes))) = (&mut self.scatter, row.split_last()) else { return };
        let square = (weight * residual).powi(2);
        for (column, factor) in slopes.iter().enumerate() {
            let factor = square * factor;
            for (at, other) in slopes[..=column].iter().enumerate() {
                scatter[(at, column)] += factor * other;
            }
        }
    }

    /// Counts this many data of a weight together, by which means are taken.
    pub fn count(&mut self, data: usize, weight: f64) {
        self.weight += weight;
        self.count += data;
    }

    /// Adds further data for the same unknowns.
    #[must_use]
    pub fn join(mut self, other: &Self) -> Self {
        self.products += &other.products;
        if let (Some(scatter), Some(other)) = (&mut self.scatter, &other.scatter) {
            *scatter += other;
        }
        self.weight += other.weight;
        self.count += other.count;
        self
    }

    /// The sum of the squares of all residuals.
    pub fn square(&self) -> f64 {
        let last = self.unknowns();
        self.products[(last, last)].max(0.0)
    }

    /// The root of the mean square of the residuals.
    pub fn root_mean_square(&self) -> f64 {
        if self.weight > 0.0 { (self.square() / self.weight).sqrt() } else { 0.0 }
    }

    /// Jᵀ·diag(r²)·J · n/(n − p) for n data and p unknowns: the middle of the covariance by White (1980), with the
    /// factor that MacKinnon and White (1985) call HC1. `None` if there are no more data than unknowns, or nobody
    /// wanted it.
    pub fn scatter(&self) -> Option<DMatrix<f64>> {
        let rest = self.count.checked_sub(self.unknowns()).filter(|rest| *rest > 0)?;
        let mut scatter = self.scatter.clone()?;
        scatter.fill_lower_triangle_with_upper_triangle();
        Some(scatter * (self.count as f64 / rest as f64))
    }

    /// The same data for other unknowns, on which these depend. `slopes` has a row for each of these, and a column for
    /// each of the others.
    #[must_use]
    pub fn in_terms_of(&self, slopes: &DMatrix<f64>) -> Self {
        let (from, to) = (self.unknowns(), slopes.ncols());
        let mut change = DMatrix::zeros(from + 1, to + 1);
        change.view_mut((0, 0), (from, to)).copy_from(slopes);
        change[(from, to)] = 1.0;
        let mut whole = self.products.clone();
        whole.fill_lower_triangle_with_upper_triangle();
        let scatter = self.scatter.as_ref().map(|scatter| {
            let mut scatter = scatter.clone();
            scatter.fill_lower_triangle_with_upper_triangle();
            slopes.transpose() * scatter * slopes
        });
        Self { products: change.transpose() * whole * change, scatter, weight: self.weight, count: self.count }
    }

    /// JᵀJ.
    pub fn curvature(&self) -> DMatrix<f64> {
        let unknowns = self.unknowns();
        let mut square = self.products.view((0, 0), (unknowns, unknowns)).into_owned();
        square.fill_lower_triangle_with_upper_triangle();
        square
    }

    /// A Jacobian and residuals with the same products, one more than there are unknowns: the triangle of Cholesky's
    /// decomposition. A row that is 0 but for rounding is 0.
    pub fn reduced(&self) -> (DMatrix<f64>, DVector<f64>) {
        /// What is left of a diagonal element by rounding alone.
        const ROUNDING: f64 = 1e-14;
        let size = self.products.nrows();
        let mut triangle = DMatrix::<f64>::zeros(size, size);
        for row in 0..size {
            let known: f64 = (0..row).map(|above| triangle[(above, row)] * triangle[(above, row)]).sum();
            let rest = self.products[(row, row)] - known;
            if rest <= ROUNDING * self.products[(row, row)] || !rest.is_finite() {
                continue;
            }
            let pivot = rest.sqrt();
            triangle[(row, row)] = pivot;
            for column in row + 1..size {
                let known: f64 = (0..row).map(|above| triangle[(above, row)] * triangle[(above, column)]).sum();
                triangle[(row, column)] = (self.products[(row, column)] - known) / pivot;
            }
        }
        let jacobian = triangle.columns(0, size - 1).into_owned();
        let residuals = triangle.column(size - 1).into_owned();
        (jacobian, residuals)
    }

    /// Whether every product is a number.
    pub fn is_finite(&self) -> bool {
        self.products.iter().all(|product| product.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(x: &DMatrix<f64>, y: &DMatrix<f64>) -> bool {
        (x - y).norm() <= 1e-12 * y.norm().max(1.0)
    }

    #[test]
    fn the_reduced_system_has_the_products_of_the_data() {
        let rows = [[1.0, 2.0, 0.5], [0.3, -1.0, 2.0], [4.0, 0.1, -0.7], [2.0, 2.0, 2.0], [-1.0, 0.4, 0.2]];
        let weights = [1.0, 2.0, 0.5, 0.0, 3.0];
        let mut equations = NormalEquations::new(2);
        for (weight, row) in weights.iter().zip(&rows) {
            equations.add(*weight, row);
            equations.count(1, *weight);
        }
        let scaled = |index: usize| weights[index].sqrt() * DVector::from_row_slice(&rows[index]).transpose();
        let data = DMatrix::from_rows(&(0..5).map(scaled).collect::<Vec<_>>());
        let (jacobian, residuals) = equations.reduced();
        let (j, r) = (data.columns(0, 2).into_owned(), data.column(2).into_owned());
        assert!(near(&(jacobian.transpose() * &jacobian), &(j.transpose() * &j)));
        assert!(near(&equations.curvature(), &(j.transpose() * &j)));
        assert!((jacobian.transpose() * &residuals - j.transpose() * &r).norm() < 1e-12);
        assert!((residuals.norm_squared() - r.norm_squared()).abs() < 1e-12);
        assert!((equations.root_mean_square() - (r.norm_squared() / 6.5).sqrt()).abs() < 1e-12);
        // u = (x + y, 2x): the derivative by x and y.
        let slopes = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 2.0, 0.0]);
        let (jacobian, _) = equations.in_terms_of(&slopes).reduced();
        let wanted = &j * slopes;
        assert!(near(&(jacobian.transpose() * &jacobian), &(wanted.transpose() * &wanted)));
    }

    #[test]
    fn unknowns_without_effect_have_rows_of_zeros() {
        let mut equations = NormalEquations::new(2);
        equations.add(1.0, &[0.0, 2.0, 1.0]);
        equations.add(1.0, &[0.0, 4.0, 2.0]);
        let (jacobian, residuals) = equations.reduced();
        assert!(jacobian.column(0).iter().all(|value| *value == 0.0));
        assert!((residuals[1] - 5.0_f64.sqrt()).abs() < 1e-12 && residuals[2] == 0.0);
    }
}
