//! How reflectance is compared with data. A row of the table is a metric: its name, where it comes from, and the
//! function that is applied to f · cos θ before differences are squared.

/// A metric.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Metric {
    /// The name by which it is chosen.
    pub name: &'static str,
    /// What it does, in one line.
    pub doc: &'static str,
    kind: Kind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Linear,
    Logarithm,
}

/// All metrics; the first is the default.
pub const METRICS: [Metric; 2] = [
    Metric {
        name: "cosine",
        doc: "differences of f cos(theta), so bright highlights count most (Ngan, Durand and Matusik 2005)",
        kind: Kind::Linear,
    },
    Metric {
        name: "log",
        doc: "differences of log(1 + f cos(theta)), so dark parts and highlights both count (Löw and others 2012)",
        kind: Kind::Logarithm,
    },
];

impl Metric {
    /// The metric of this name.
    pub fn named(name: &str) -> Option<Metric> {
        METRICS.into_iter().find(|metric| metric.name == name)
    }

    /// The function of f · cos θ, and its derivative. Below 0 the logarithm goes on as a line.
    pub fn apply(self, value: f64) -> [f64; 2] {
        match self.kind {
            Kind::Linear => [value, 1.0],
            Kind::Logarithm if value >= 0.0 => [value.ln_1p(), 1.0 / (1.0 + value)],
            Kind::Logarithm => [value, 1.0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_slopes() {
        for metric in METRICS {
            assert_eq!(Metric::named(metric.name), Some(metric));
            for value in [-0.5, 0.3, 7.0, 200.0] {
                let h = 1e-6;
                let slope = (metric.apply(value + h)[0] - metric.apply(value - h)[0]) / (2.0 * h);
                assert!((metric.apply(value)[1] - slope).abs() < 1e-6, "{} at {value}", metric.name);
            }
        }
    }
}
