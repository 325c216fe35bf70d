//! The map of multiple impacts and its borders.

use crate::clearance::borders::*;
use crate::clearance::tuning::admissible_ratios;
use crate::formulas::passage::Passage;
use std::f64::consts::{PI, TAU};

/// The number of bands at this mass ratio: (2n+1)π < tan β − β with cos β = μ.
fn bands(mu: f64) -> f64 {
    if mu >= 1.0 || mu.is_nan() {
        return 0.0;
    }
    let tan = ((1.0 - mu) * (1.0 + mu)).sqrt() / mu;
    (0.5 * ((tan - tan.atan()) / PI + 1.0)).ceil() - 1.0
}

#[test]
fn the_map_of_multiple_impacts() {
    let map = [
        (3.008, ".........................................oooooooo"),
        (1.222, "...................................oooooooooooooo"),
        (0.496, "...............................oooooooooooooooooo"),
        (0.272, ".............................oooooooooooooooooooo"),
        (0.202, ".................ii.........ooooooooooooooooooooo"),
        (0.149, "...............iii..........ooooooooooooooooooooo"),
        (0.082, ".............iiii..........oooooooooooooooooooooo"),
        (0.045, "...........iiii....ii....i.oooooooooooooooooooooo"),
        (0.025, ".........iiii...ii...i...i.oioooooooooooooooooooo"),
        (0.010, ".......iii...ii..i..i.i..i.iooiooiooooooooooooooo"),
    ];
    for (mu, row) in map {
        let letter = |column: i32| match sequel(&Passage::new(mu, 10f64.powf(-1.0 + f64::from(column) / 12.0))) {
            Sequel::Immediate => 'i',
            Sequel::Elastic => 'o',
            _ => '.',
        };
        assert_eq!((0..49).map(letter).collect::<String>(), row, "μ = {mu}");
    }
}

#[test]
fn the_printed_borders() {
    let [tau, k] = elastic_limit();
    assert!((tau - 4.05622684325).abs() < 0.51e-11 && (k - 15.1790607982).abs() < 0.51e-10, "{tau} {k}");
    let [theta, mu] = band_tip(0);
    assert!((theta - 4.4934).abs() < 0.51e-4 && (mu - 0.2172336282).abs() < 0.51e-10, "{theta} {mu}");
    assert!((theta.tan() - theta).abs() < 1e-13);
    let printed = [
        (0.05, 16.36, 0.01),
        (0.1, 17.99, 0.01),
        (0.2, 20.56, 0.01),
        (0.3, 24.41, 0.01),
        (0.5, 32.57, 0.01),
        (1.0, 57.52, 0.01),
        (2.0, 129.0, 0.1),
        (5.0, 644.0, 1.0),
        (10.0, 2954.0, 1.0),
    ];
    for (mu, printed, unit) in printed {
        let border = elastic_border(mu).k;
        assert!((border - printed).abs() < 0.51 * unit, "μ = {mu}: {border} instead of {printed}");
    }
    for i in -90..=90 {
        let mu = 10f64.powf(0.1 * f64::from(i));
        assert!(elastic_border(mu).k > k, "15.179… is the least, not K_el({mu})");
    }
}

#[test]
fn the_sequel_changes_at_the_borders_and_nowhere_else() {
    for mu in [1e-4, 0.003, 0.02, 0.07, 0.21, 0.2173, 0.8, 30.0] {
        let list = admissible(mu);
        assert!(!list.cut);
        let calm = |k: f64| sequel(&Passage::new(mu, k)) == Sequel::None;
        for (i, [low, high]) in list.intervals.iter().enumerate() {
            assert!(calm(low.max(1e-12) * (1.0 + 1e-9)) && calm(high * (1.0 - 1e-9)), "μ = {mu}, interval {i}");
            assert!(!calm(high * (1.0 + 1e-9)), "μ = {mu}, interval {i}");
            assert!(i == 0 || !calm(low * (1.0 - 1e-9)), "μ = {mu}, interval {i}");
            for j in 1..50 {
                assert!(calm(low + (high - low) * f64::from(j) / 50.0), "μ = {mu}, interval {i}");
            }
        }
        // Between them, and beyond the last one.
        let gaps =
            list.intervals.windows(2).map(|pair| [pair[0][1], pair[1][0]]).chain([[list.elastic, 1e3 * list.elastic]]);
        for [low, high] in gaps {
            for j in 1..50 {
                let k = low * (high / low).powf(f64::from(j) / 50.0);
                assert!(!calm(k), "μ = {mu}, K = {k}");
            }
        }
        assert!((0..).take_while(|n| band(mu, *n).is_some()).count() as f64 == bands(mu), "μ = {mu}");
    }
    assert_eq!((bands(0.2173), bands(0.2172), bands(2.0)), (0.0, 1.0, 0.0));
}

#[test]
fn many_narrow_bands_are_cut_off_and_say_so() {
    let list = admissible(1e-9);
    assert!(list.cut && list.intervals.len() == 101 && bands(1e-9) > 1e8);
    let last = list.intervals[100];
    for edge in [last[0] * (1.0 + 1e-6), last[1] * (1.0 - 1e-6)] {
        assert_eq!(sequel(&Passage::new(1e-9, edge)), Sequel::None);
    }
    assert_eq!(sequel(&Passage::new(1e-9, last[1] * (1.0 + 1e-6))), Sequel::Immediate);
}

#[test]
fn the_force_is_zero_where_contact_ends() {
    for (mu, k) in [(0.01, 100.0), (0.3, 24.5), (0.3, 1e4), (1.0, 57.6), (10.0, 3000.0), (10.0, 1e9)] {
        let p = Passage::new(mu, k);
        assert_eq!(sequel(&p), Sequel::Elastic, "{mu} {k}");
        let tau = release(&p).unwrap();
        let size = (mu + 1.0) * (p.tau + tau);
        assert!(tau > 0.0 && tau < TAU && p.pressing(tau).abs() < 1e-12 * size, "{mu} {k}: {tau}");
        assert!((1..1000).all(|i| p.pressing(tau * (1.0 - 1e-6) * f64::from(i) / 1000.0) > 0.0), "{mu} {k}");
        assert!(p.pressing(tau + 1e-4) < 0.0, "{mu} {k}");
    }
    assert_eq!(release(&Passage::new(0.149, 2.2)), Some(0.0));
    assert_eq!(release(&Passage::new(0.5, 2.2)), None);
}

#[test]
fn the_points_of_the_borders_lie_on_them() {
    let list = borders([0.01, 10.0], 1000.0);
    assert_eq!(list.iter().filter(|border| border.band.is_some()).count(), 16);
    for border in &list {
        assert!(border.points.len() > 20 && border.points.len() < 2000);
        for p in &border.points {
            let passage = Passage::lasting(p.mu, p.tau);
            assert!((passage.k / p.k - 1.0).abs() < 1e-13);
            match border.band {
                // f and f′ vanish together: a double zero.
                None if passage.pressing_at_once() < 0.0 => {}
                None => {
                    let near = Passage::lasting(p.mu, p.tau * (1.0 + 1e-9));
                    let tau = release(&near).unwrap();
                    assert!(
                        near.pressing(tau + 1e-2) > 0.0
                            && sequel(&Passage::lasting(p.mu, p.tau * (1.0 - 1e-9))) == Sequel::None
                    );
                }
                Some(n) => {
                    let theta = passage.theta;
                    assert!((theta.sin() + p.mu * theta).abs() < 1e-12 * theta, "{p:?}");
                    assert!(theta >= f64::from(2 * n + 1) * PI && theta <= f64::from(2 * n + 2) * PI);
                }
            }
        }
        // Neighbours are near: a diagram shows the curve, not a polygon.
        for pair in border.points.windows(2) {
            let [dk, dm] = [(pair[1].k / pair[0].k).ln(), (pair[1].mu / pair[0].mu).ln()];
            assert!((dk * dk + dm * dm).sqrt() < 1.0, "{:?} {pair:?}", border.band);
        }
    }
}

#[test]
fn the_least_mass_ratio_without_an_elastic_release_is_that_whose_border_k_is() {
    // Numbers of an independent program in four digits of K, which moves along the border by 0.6 to 3 times as much as μ does.
    for (mu, k) in [(0.3, 24.41), (0.5, 32.57), (1.0, 57.52), (2.0, 129.0), (5.0, 644.0), (10.0, 2954.0)] {
        let ratios = admissible_ratios(k);
        let [least, most] = ratios.intervals[0];
        assert!((least / mu - 1.0).abs() < 2e-3 && most.is_infinite() && !ratios.cut, "K = {k}: {ratios:?}");
    }
}

#[test]
fn between_the_listed_mass_ratios_contact_is_interrupted() {
    for k in [0.2, 1.0, 3.0, 10.0, 16.0, 18.0, 100.0] {
        let ratios = admissible_ratios(k);
        // Below K_el(0) countless bands come ever nearer to μ = 0.
        assert_eq!(ratios.cut, k < elastic_limit()[1], "K = {k}");
        let lowest = ratios.intervals[0][0];
        for i in -500..3000 {
            let mu = lowest * 1.004_f64.powi(i);
            let listed = ratios.intervals.iter().any(|[low, high]| (*low..=*high).contains(&mu));
            let near = ratios.intervals.iter().flatten().any(|end| (mu / end - 1.0).abs() < 1e-9);
            // Below the first interval of a list that is cut nothing is known.
            if !(near || ratios.cut && mu < lowest) {
                assert_eq!(sequel(&Passage::new(mu, k)) == Sequel::None, listed, "K = {k}, μ = {mu}");
            }
        }
    }
}

#[test]
fn mass_ratios_of_a_tiny_k_are_listed_once() {
    for k in [1e-12, 1e-9, 2.566e-8, 1e-7, 1e-4] {
        let list = admissible_ratios(k).intervals;
        assert!(
            list.iter().all(|[low, high]| low < high) && list.windows(2).all(|w| w[0][1] <= w[1][0]),
            "{k}: {list:?}"
        );
    }
}
