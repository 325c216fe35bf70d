//! The whole drive against an independent computation with 34 digits (closed forms of both modes in mpmath, switching
//! instants bracketed on a grid of 4 µs).

use super::*;

/// Kind, time (s) and impulse (N·s) of impacts.
type Reference = [(&'static str, f64, f64)];

/// From rest, b = 60 N·s/m, s = 0.3 mm, 50 rad/s.
const PLASTIC: &Reference = &[
    ("release from flank A", 0.034179725743604485, 0.0),
    ("impact on flank B", 0.043651882296635434, -0.035008248381939354),
    ("release from flank B", 0.05357914249135902, 0.0),
    ("impact on flank B", 0.05418869093306477, -0.00012295254129562956),
    ("release from flank B", 0.08850648709360713, 0.0),
    ("impact on flank A", 0.09243863186687817, 0.05837947222452),
    ("release from flank A", 0.09243863186687817, 0.0),
    ("impact on flank A", 0.09255000455447439, 0.00011285101963667923),
    ("release from flank A", 0.102648543907161, 0.0),
    ("impact on flank A", 0.10623954786206394, 0.029442973064648846),
    ("release from flank A", 0.11410681576234033, 0.0),
    ("impact on flank A", 0.1201118383628317, 0.03474432558405067),
    ("release from flank A", 0.12849002459897785, 0.0),
];

/// q, q̇, z at 0.13 s.
const PLASTIC_END: [f64; 3] = [4.3758996705357906e-05, -0.00846651406042957, 2.4581545293423456e-05];

/// From rest, b = 60 N·s/m, s = 0.3 mm, 50 rad/s.
const ELASTIC: &Reference = &[
    ("release from flank A", 0.034179725743604485, 0.0),
    ("impact on flank B", 0.043651882296635434, -0.07001649676387871),
    ("impact on flank B", 0.04540151681395989, -0.09748272932135199),
    ("impact on flank B", 0.04658954194926981, -0.10157322227226899),
    ("impact on flank B", 0.04763548892235271, -0.0987093119590595),
    ("impact on flank B", 0.0486646878585417, -0.0912384914972812),
    ("impact on flank B", 0.049782425206980924, -0.0789385750520606),
    ("impact on flank B", 0.05119977638914067, -0.05870504487142961),
    ("impact on flank B", 0.05401454777450632, -0.02294575365014883),
    ("impact on flank B", 0.055966113368661585, -0.042484415930735396),
    ("impact on flank B", 0.05696920453007398, -0.048753099636252045),
    ("impact on flank B", 0.05773421240874237, -0.05156329773223101),
    ("impact on flank B", 0.058389738928557075, -0.05271692609254824),
    ("impact on flank B", 0.058985513127536526, -0.05283432953582542),
    ("impact on flank B", 0.059547939695677274, -0.05218770715151281),
];

/// q, q̇, z at 0.06 s.
const ELASTIC_END: [f64; 3] = [0.00016942409646374942, -0.03766693953677909, 0.0002959879243824665];

fn compare(e: f64, end: f64, reference: &Reference, state: [f64; 3]) {
    let mut drive = started(scene(50.0, 3e-4, 60.0, e));
    drive.advance(0.0, end).unwrap();
    let events: Vec<Event> = drive.log.iter().copied().collect();
    assert_eq!(events.len(), reference.len());
    for (event, (kind, time, impulse)) in events.iter().zip(reference) {
        assert_eq!(event.kind, *kind);
        assert!((event.time - time).abs() < 1e-14, "{event:?}: {time}");
        assert!(kind.starts_with("release") || (event.value - impulse).abs() < 1e-13, "{event:?}: {impulse}");
    }
    let State { q, home, zeta } = drive.now.point.state;
    let found = [q[0], q[1], home + zeta[0]];
    for (n, size) in [1e-3, 0.5, 3e-4].into_iter().enumerate() {
        assert!((found[n] - state[n]).abs() < 1e-12 * size, "{n}: {} instead of {}", found[n], state[n]);
    }
}

#[test]
fn a_turn_with_plastic_impacts() {
    compare(0.0, 0.13, PLASTIC, PLASTIC_END);
}

#[test]
fn a_landing_with_elastic_impacts() {
    compare(1.0, 0.06, ELASTIC, ELASTIC_END);
}
