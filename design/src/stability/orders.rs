//! The orders that a study needs.

use super::map::Instability;
use super::system::System;
use super::tongue::Tongue;
use super::{Counter, USUAL_ORDERS, hill};
use crate::parallel;

/// The instabilities by order.
pub struct Tongues {
    /// Hill's boundaries of all of them.
    pub start: hill::Boundaries,
    /// The found instabilities, by order.
    pub known: Vec<Instability>,
    /// The first order whose boundaries have not been found; it and those above are missing in the list.
    pub lost: Option<f64>,
}

/// The tongues of the first orders, and of further ones until the last are stable at the damping ratio `until`: tongues of
/// higher order lie at lower speeds.
pub fn tongues(system: &System, orders: usize, until: Option<f64>, counter: &Counter) -> Tongues {
    let mut start = hill::Boundaries::none();
    let mut known: Vec<Instability> = Vec::new();
    let mut orders = orders;
    while known.len() < orders {
        start = hill::boundaries(system, orders);
        let numbers: Vec<usize> = (known.len() + 1..=orders).collect();
        let tongue = |n: &usize| {
            let tongue = Tongue::numbered(system, *n, &start)?;
            Some((tongue, tongue.apex(system)))
        };
        for found in parallel::map(&numbers, tongue, &|| counter.step()) {
            let Some(found) = found else {
                let lost = Some(0.5 * ((known.len() + 1) * system.parts.max(1)) as f64);
                return Tongues { start, known, lost };
            };
            known.push(found);
        }
        let unstable =
            |(_, apex): &Instability| until.is_some_and(|theta| theta > 0.0 && apex.is_none_or(|a| a.theta > theta));
        if known.iter().rev().take(2).any(unstable) {
            orders = (orders + 4).min(USUAL_ORDERS);
        }
    }
    Tongues { start, known, lost: None }
}
