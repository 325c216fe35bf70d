//! Where an axis has its ticks, and what stands beside them.

/// 1, 2 or 5 times a power of ten, at most six of them in `span`.
pub fn decimal_step(span: f64) -> f64 {
    let power = 10f64.powf((span / 6.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| span / step <= 6.0).unwrap_or(power)
}

/// Degrees between ticks that divide the turn, at most six of them in `span`.
pub fn angular_step(span: f64) -> f64 {
    let steps = [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0];
    let step = steps.into_iter().find(|step| span / step <= 6.0 && span >= *step);
    step.unwrap_or_else(|| decimal_step(span))
}

/// `value` with as many decimals as steps of `step` need.
pub fn decimal(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    format!("{value:.decimals$}").replace('-', "−")
}

/// Powers of ten, every n-th of them where there are many, and 1, 2, 5 times them where there are few.
pub fn logarithmic_ticks(low: f64, high: f64) -> Vec<(f64, String)> {
    let span = high - low;
    let multiples: &[f64] = match span {
        s if s <= 0.9 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
        s if s <= 2.2 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let every = ((span / 8.0).ceil() as i64).max(1);
    let exponents = (low.floor() as i64..=high.ceil() as i64).filter(|n| n.rem_euclid(every) == 0);
    exponents
        .flat_map(|n| multiples.iter().map(move |m| (n as f64 + m.log10(), *m, n)))
        .filter(|(place, ..)| (low..=high).contains(place))
        .map(|(place, m, n)| (place, logarithmic_label(m, n)))
        .collect()
}

/// m · 10ⁿ, in plain digits from 0.01 to 100000.
fn logarithmic_label(m: f64, n: i64) -> String {
    if (-2..=5).contains(&n) {
        let decimals = (-n).max(0) as usize + usize::from(m.fract() != 0.0 && n <= 0);
        return format!("{:.decimals$}", m * 10f64.powi(n as i32));
    }
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let power: String =
        n.to_string().chars().map(|c| c.to_digit(10).map_or('⁻', |digit| digits[digit as usize])).collect();
    if m == 1.0 { format!("10{power}") } else { format!("{m}·10{power}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        let labels = |low: f64, high: f64| -> Vec<String> {
            logarithmic_ticks(low.log10(), high.log10()).into_iter().map(|(_, text)| text).collect()
        };
        assert_eq!(labels(1e-16, 1e-1), ["10⁻¹⁶", "10⁻¹⁴", "10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "0.01"]);
        assert_eq!(labels(90.0, 2000.0), ["100", "200", "500", "1000", "2000"]);
        assert_eq!(labels(0.3, 0.9), ["0.3", "0.4", "0.5", "0.6", "0.8"]);
        assert_eq!(decimal_step(7.3), 2.0);
        assert_eq!([403.0, 270.0, 60.0, 0.7, 1e5].map(angular_step), [90.0, 45.0, 10.0, 0.2, 20000.0]);
        assert_eq!(decimal(-0.25, 0.05), "−0.25");
    }
}
