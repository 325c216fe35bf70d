//! The ticks of an axis and their labels.

/// 1, 2 or 5 times a power of ten, at most six of them in `span`.
pub fn decimal_step(span: f64) -> f64 {
    let power = 10f64.powf((span / 6.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| span / step <= 6.0).unwrap_or(power)
}

/// Degrees between ticks that divide the turn, at most eight of them in `span`.
pub fn angular_step(span: f64) -> f64 {
    let steps = [1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0];
    let step = steps.into_iter().find(|step| span / step <= 8.0 && span >= *step);
    step.unwrap_or_else(|| decimal_step(span))
}

/// `value` with as many decimals as steps of `step` need; where these are many, as a multiple of a power of ten.
pub fn decimal(value: f64, step: f64) -> String {
    let exponent = step.log10().floor() as i64;
    if !(-4..=5).contains(&exponent) && value != 0.0 {
        return format!("{:.0}·10{}", value / 10f64.powi(exponent as i32), raised(exponent)).replace('-', "−");
    }
    let decimals = if (-4..=5).contains(&exponent) { (-exponent).max(0) as usize } else { 0 };
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
    let ticks = exponents.flat_map(|n| multiples.iter().map(move |m| (n as f64 + m.log10(), *m, n)));
    let ticks: Vec<(f64, f64, i64)> = ticks.filter(|(place, ..)| (low..=high).contains(place)).collect();
    // One way of writing for all of them.
    let plain = ticks.iter().all(|(_, _, n)| (-3..=5).contains(n));
    ticks.into_iter().map(|(place, m, n)| (place, if plain { plainly(m, n) } else { as_power(m, n) })).collect()
}

/// m · 10ⁿ in digits.
fn plainly(m: f64, n: i64) -> String {
    let decimals = (-n).max(0) as usize + usize::from(m.fract() != 0.0 && n <= 0);
    format!("{:.decimals$}", m * 10f64.powi(n as i32))
}

fn as_power(m: f64, n: i64) -> String {
    if m == 1.0 { format!("10{}", raised(n)) } else { format!("{m}·10{}", raised(n)) }
}

/// The number as an exponent.
fn raised(n: i64) -> String {
    let digits = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    n.to_string().chars().map(|c| c.to_digit(10).map_or('⁻', |digit| digits[digit as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        let labels = |low: f64, high: f64| -> Vec<String> {
            logarithmic_ticks(low.log10(), high.log10()).into_iter().map(|(_, text)| text).collect()
        };
        assert_eq!(labels(1e-16, 1e-1), ["10⁻¹⁶", "10⁻¹⁴", "10⁻¹²", "10⁻¹⁰", "10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²"]);
        assert_eq!(labels(1e-4, 2.0), ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"]);
        assert_eq!(labels(1e-3, 20.0), ["0.001", "0.01", "0.1", "1", "10"]);
        assert_eq!(labels(90.0, 2000.0), ["100", "200", "500", "1000", "2000"]);
        assert_eq!(labels(0.3, 0.9), ["0.3", "0.4", "0.5", "0.6", "0.8"]);
        assert_eq!(decimal_step(7.3), 2.0);
        assert_eq!([403.0, 360.0, 170.0, 60.0, 0.7, 1e5].map(angular_step), [90.0, 45.0, 30.0, 10.0, 0.2, 20000.0]);
        assert_eq!(decimal(-0.25, 0.05), "−0.25");
        assert_eq!([0.0, -4e-7, 1e-6].map(|value| decimal(value, 2e-7)), ["0", "−4·10⁻⁷", "10·10⁻⁷"]);
    }
}
