//! Places of ticks at round numbers, and how the numbers are written.

/// A tick of an axis.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    /// The number there.
    pub(super) value: f64,
    /// What is written beside it; empty for a tick between others.
    pub(super) label: String,
}

/// The step between ticks: the smallest round number with at most `most` steps in a range.
fn step(range: f64, most: f64, rounds: &[f64]) -> f64 {
    let least = range / most.max(1.0);
    let decade = 10_f64.powf(least.log10().floor());
    let round = rounds.iter().copied().find(|round| round * decade >= least * (1.0 - 1e-9));
    round.unwrap_or(10.0) * decade
}

/// The step of an axis of angles in degrees.
fn angle_step(range: f64, most: f64) -> f64 {
    const STEPS: [f64; 9] = [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0];
    STEPS.into_iter().find(|step| range / step <= most.max(1.0)).unwrap_or(360.0)
}

/// A number of an axis whose ticks are this far apart, with the digits that the distance asks for. The minus is that of
/// mathematics.
fn label(value: f64, step: f64) -> String {
    let value = if value.abs() < step * 1e-6 { 0.0 } else { value };
    let large = value.abs().max(step) >= 1e6 || (step < 1e-5 && step > 0.0);
    let text = if large {
        exponential(value, step)
    } else {
        let digits = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        // Steps such as 0.25 have a digit more.
        let more = usize::from((step * 10_f64.powi(digits as i32)).fract().abs() > 1e-6 && digits < 9);
        format!("{value:.*}", digits + more)
    };
    text.replace('-', "−")
}

/// A number with an exponent, with the digits that ticks this far apart ask for.
fn exponential(value: f64, step: f64) -> String {
    let decade = step.log10().floor();
    let more = f64::from(u8::from((step / 10_f64.powf(decade)).fract().abs() > 1e-6));
    let digits = (value.abs().log10().floor() - decade + more).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$e}");
    match text.split_once('e') {
        Some((_, _)) if value == 0.0 => "0".to_owned(),
        Some((mantissa, power)) if mantissa.contains('.') => {
            format!("{}e{power}", mantissa.trim_end_matches('0').trim_end_matches('.'))
        }
        Some(_) | None => text,
    }
}

/// The range of an axis of numbers: widened to whole steps.
pub(super) fn widened([low, high]: [f64; 2], most: f64) -> [f64; 2] {
    if high - low <= 0.0 || !(high - low).is_finite() {
        let around = if low.is_finite() && low != 0.0 { low.abs() } else { 1.0 };
        return if low >= 0.0 { [0.0, around] } else { [-around, around] };
    }
    let step = step(high - low, most, &[1.0, 2.0, 2.5, 5.0, 10.0]);
    [(low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step]
}

/// The ticks of a linear axis, at most about `most`.
pub(super) fn linear([low, high]: [f64; 2], most: f64, is_angle: bool) -> Vec<Tick> {
    let step = if is_angle { angle_step(high - low, most) } else { step(high - low, most, &[1.0, 2.0, 2.5, 5.0, 10.0]) };
    if !(step > 0.0 && step.is_finite()) {
        return Vec::new();
    }
    let (first, last) = ((low / step - 1e-6).ceil(), (high / step + 1e-6).floor());
    let values = (0..=(last - first).clamp(0.0, 1000.0) as u32).map(|index| (first + f64::from(index)) * step);
    values.map(|value| Tick { value, label: label(value, step) + if is_angle { "°" } else { "" } }).collect()
}

/// A power of ten as people write it: 0.01, 1, 10, 10⁵.
fn decade_label(exponent: i32) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    if (-3..=3).contains(&exponent) {
        return format!("{}", 10_f64.powi(exponent));
    }
    let digits = exponent.unsigned_abs().to_string();
    let raised: String = digits.bytes().map(|digit| DIGITS[usize::from(digit - b'0') % 10]).collect();
    format!("10{}{raised}", if exponent < 0 { "⁻" } else { "" })
}

/// The ticks of a logarithmic axis: powers of ten with labels, and between them 2 to 9 without, if there are few.
pub(super) fn logarithmic([low, high]: [f64; 2], most: f64) -> Vec<Tick> {
    let (first, last) = ((low.log10() - 1e-9).ceil() as i32, (high.log10() + 1e-9).floor() as i32);
    let decades = (last - first).max(0);
    let every = ((f64::from(decades) / most.max(1.0)).ceil() as i32).max(1);
    let mut ticks = Vec::new();
    for exponent in first - 1..=last {
        if exponent >= first {
            let label = if (exponent - first) % every == 0 { decade_label(exponent) } else { String::new() };
            ticks.push(Tick { value: 10_f64.powi(exponent), label });
        }
        if decades <= 4 {
            let between = (2..10).map(|digit| f64::from(digit) * 10_f64.powi(exponent));
            let within = between.filter(|value| (low..=high).contains(value));
            ticks.extend(within.map(|value| Tick { value, label: String::new() }));
        }
    }
    ticks
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &[Tick]) -> Vec<&str> {
        ticks.iter().map(|tick| tick.label.as_str()).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn ticks_are_at_round_numbers() {
        assert_eq!(labels(&linear([0.0, 1.0], 5.0, false)), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(&linear([-0.5, 0.5], 4.0, false)), ["−0.50", "−0.25", "0.00", "0.25", "0.50"]);
        assert_eq!(labels(&linear([-90.0, 90.0], 7.0, true)), ["−90°", "−60°", "−30°", "0°", "30°", "60°", "90°"]);
        assert_eq!(labels(&linear([0.0, 3e7], 3.0, false)), ["0", "1e7", "2e7", "3e7"]);
        assert_eq!(labels(&linear([0.0, 3e-6], 3.0, false)), ["0", "1e−6", "2e−6", "3e−6"]);
        assert_eq!(labels(&linear([0.0, 5e-6], 3.0, false)), ["0", "2e−6", "4e−6"]);
        assert_eq!(labels(&linear([0.0, 1e7], 4.0, false)), ["0", "2.5e6", "5e6", "7.5e6", "1e7"]);
        assert_eq!(labels(&logarithmic([1e-4, 100.0], 8.0)), ["10⁻⁴", "0.001", "0.01", "0.1", "1", "10", "100"]);
        assert_eq!(labels(&logarithmic([1e-6, 1e6], 6.0)), ["10⁻⁶", "10⁻⁴", "0.01", "1", "100", "10⁴", "10⁶"]);
        assert_eq!(logarithmic([1.0, 10.0], 5.0).len(), 10);
        assert!(linear([f64::NAN, 1.0], 5.0, false).is_empty() && linear([0.0, f64::INFINITY], 5.0, false).is_empty());
    }

    #[test]
    fn ranges_end_at_ticks() {
        assert_eq!(widened([0.0, 0.93], 5.0), [0.0, 1.0]);
        assert_eq!(widened([-0.13, 0.4], 5.0).map(|end| (end * 100.0).round()), [-20.0, 40.0]);
        assert_eq!((widened([0.0, 0.0], 5.0), widened([2.0, 2.0], 5.0)), ([0.0, 1.0], [0.0, 2.0]));
        assert_eq!(widened([0.0, 1.0], 5.0), [0.0, 1.0]);
    }
}
