//! Plans against printed values, closed forms, and the cycles that they generalise; points that make no plan.

use super::*;
use crate::motion::MotionLaw;
use std::f64::consts::{FRAC_PI_2, PI};

/// A point at `phi` degrees.
fn at(phi: f64, u: f64) -> PlanPoint {
    let none = None;
    PlanPoint {
        phi: phi.to_radians(),
        u,
        velocity: None,
        acceleration: None,
        free: false,
        jerk: none,
        law: None,
        inflection: none,
    }
}

fn with(law: SegmentLaw, point: PlanPoint) -> PlanPoint {
    PlanPoint { law: Some(law), ..point }
}

fn turning(point: PlanPoint) -> PlanPoint {
    PlanPoint { free: true, ..point }
}

fn law(points: Vec<PlanPoint>) -> MotionLaw {
    let law = MotionLaw::Plan(MotionPlan::new(points));
    law.validate().unwrap();
    law
}

/// The largest U⁽ⁿ⁾ and the least over [a, b] degrees, of all pieces that meet there.
fn extremes(law: &MotionLaw, [a, b]: [f64; 2], value: impl Fn([f64; 5]) -> f64) -> [f64; 2] {
    const COUNT: usize = 40_000;
    let values = (0..=COUNT).map(|i| {
        let phi = (a + (b - a) * i as f64 / COUNT as f64).to_radians();
        value(law.at_in(law.segment(phi, i < COUNT), phi).0)
    });
    values.fold([f64::NEG_INFINITY, f64::INFINITY], |[most, least], x| [most.max(x), least.min(x)])
}

/// A rise of 1 over one radian by `law` with this inflection, from and to these velocities and rests or turning points, and a
/// polynomial back.
fn normalised(law: Option<SegmentLaw>, inflection: f64, [v0, v1]: [f64; 2], turns: [bool; 2]) -> MotionLaw {
    let end = |v: f64, free: bool| PlanPoint { velocity: Some(v), free, ..at(0.0, 0.0) };
    let back = Some(SegmentLaw::Standard(StandardLaw::Polynomial345));
    let first = PlanPoint { law: back, ..end(v0, turns[0]) };
    let second = PlanPoint { phi: 1.0, u: 1.0, law, inflection: Some(inflection), ..end(v1, turns[1]) };
    self::law(vec![first, second])
}

/// A plan with a segment of each kind.
pub fn of_all_kinds() -> MotionLaw {
    let general = PlanPoint { velocity: Some(0.01), acceleration: Some(-0.02), ..at(200.0, 0.02) };
    law(vec![
        at(0.0, 0.0),
        at(40.0, 0.01),
        with(SegmentLaw::Straight, at(80.0, 0.02)),
        turning(at(120.0, 0.03)),
        at(150.0, 0.015),
        PlanPoint { inflection: Some(0.45), ..with(SegmentLaw::Polynomial6, at(175.0, 0.01)) },
        general,
        PlanPoint { jerk: Some(0.1), ..at(260.0, 0.01) },
        at(300.0, 0.01),
        with(SegmentLaw::Cosines, at(330.0, 0.004)),
    ])
}

fn close(found: f64, printed: f64) {
    assert!((found - printed).abs() <= 6e-12 * printed.abs().max(0.1), "{found} {printed}");
}

#[test]
fn laws_by_halves_have_the_values_of_the_formula() {
    use StandardLaw::*;
    let degrees = [0.0, 1f64.to_degrees()];
    for (law, inflection, ends, turns, values, acceleration, torque) in [
        (
            ModifiedSine,
            0.6,
            [0.0, 0.0],
            [false; 2],
            [0.05171641894184, 0.4267034102377, 0.9840148730267],
            [4.606630892120, -6.909946338180],
            [4.548127302266, -6.822190953399],
        ),
        (
            Polynomial345,
            0.4,
            [0.0, 0.0],
            [false; 2],
            [0.0828125, 0.5840567129630, 0.9938946759259],
            [7.216878364870, -4.811252243247],
            [8.367835909370, -5.578557272913],
        ),
        (
            ModifiedTrapezoid,
            0.45,
            [0.5, 0.0],
            [false; 2],
            [0.1450900178519, 0.5997015651473, 0.9929660089476],
            [3.462420998659, -3.943827126815],
            [5.354771233977, -5.792840075546],
        ),
        (
            ModifiedSine,
            0.55,
            [0.0, 0.0],
            [false, true],
            [0.05620242700528, 0.4386894144884, 0.9711596516282],
            [4.767542762743, -5.826996710019],
            [4.465462167216, -4.863536581962],
        ),
    ] {
        let rise = normalised(Some(SegmentLaw::Standard(law)), inflection, ends, turns);
        for (z, printed) in [0.2, 0.5, 0.9].into_iter().zip(values) {
            close(rise.at(z).0[0], printed);
        }
        for (value, printed) in
            [(extremes(&rise, degrees, |u| u[2]), acceleration), (extremes(&rise, degrees, |u| u[1] * u[2]), torque)]
        {
            for (found, printed) in value.into_iter().zip(printed) {
                assert!((found / printed - 1.0).abs() < 1e-7, "{law:?} {found} {printed}");
            }
        }
    }
}

/// A plan: rise to a straight line, rest, return with an inflection at 0.42.
fn example(inflections: [Option<f64>; 2]) -> MotionLaw {
    let v = 0.02;
    let straight = 0.01 + v * 70f64.to_radians();
    let rise = |point: PlanPoint, inflection| PlanPoint { inflection, ..point };
    let fall = SegmentLaw::Standard(StandardLaw::ModifiedTrapezoid);
    law(vec![
        at(0.0, 0.0),
        rise(at(50.0, 0.01), inflections[0]),
        with(SegmentLaw::Straight, at(120.0, straight)),
        rise(at(165.0, straight + 0.008), inflections[1]),
        at(200.0, straight + 0.008),
        PlanPoint { inflection: Some(0.42), ..with(fall, at(320.0, 0.0)) },
    ])
}

#[test]
fn a_plan_with_a_straight_line_has_the_printed_values() {
    let mm = |law: &MotionLaw, phi: f64, printed: [f64; 3]| {
        for (n, printed) in printed.into_iter().enumerate() {
            close(1e3 * law.at(phi.to_radians()).0[n], printed);
        }
    };
    let halves = example([Some(0.5), Some(0.55)]);
    mm(&halves, 30.0, [4.22722213936, 13.0494633938, 10.8830001335]);
    mm(&halves, 150.0, [41.3577347589, 8.53543942776, -21.9712873891]);
    mm(&halves, 260.0, [17.9817390072, -37.7430378822, 31.0695176066]);
    mm(&halves, 180.0, [42.4346095279, 0.0, 0.0]);
    for (ends, printed) in [([0.0, 50.0], 45.2431284), ([50.0, 120.0], 0.0), ([120.0, 165.0], 42.52238074)] {
        let [most, least] = extremes(&halves, ends, |u| 1e3 * u[2]);
        assert!((most.max(-least) - printed).abs() <= 1e-7 * printed.max(1e-6), "{ends:?}");
    }
    let humps = example([None; 2]);
    mm(&humps, 30.0, [3.59779343022, 15.1344159852, 26.3010687230]);
    mm(&humps, 150.0, [41.9526382877, 5.28987224484, -36.0674321277]);
    for (ends, printed) in [([0.0, 50.0], 36.0), ([120.0, 165.0], 40.0)] {
        let [most, least] = extremes(&humps, ends, |u| 1e3 * u[2]);
        assert!((most.max(-least) / printed - 1.0).abs() < 1e-7, "{ends:?}");
    }
}

#[test]
fn a_turning_point_has_the_acceleration_that_is_given_or_that_its_laws_share() {
    let turn = PlanPoint { acceleration: Some(-0.0790305232410), ..at(90.0, 0.03) };
    let given = law(vec![at(0.0, 0.0), turn, at(200.0, 0.0)]);
    for (phi, printed) in
        [(40.0, [9.71273903746, 28.7625001241, 27.1880582163]), (130.0, [16.5719195536, -25.9703636453, 7.57321166512])]
    {
        for (n, printed) in printed.into_iter().enumerate() {
            let found = 1e3 * given.at(f64::to_radians(phi)).0[n];
            assert!((found - printed).abs() < 1e-9, "{phi} {n}: {found} {printed}");
        }
    }
    // Without a value the law that leads there decides, with its inflection in the middle or as given.
    for inflection in [None, Some(0.594533504771)] {
        let turn = PlanPoint { inflection, ..turning(at(90.0, 0.03)) };
        let free = law(vec![at(0.0, 0.0), turn, at(200.0, 0.0)]);
        let [before, behind] = [false, true].map(|forward| free.at_in(free.segment(FRAC_PI_2, forward), FRAC_PI_2).0);
        for n in 0..3 {
            assert!((before[n] - behind[n]).abs() < 1e-15, "{before:?} {behind:?}");
        }
        // vₘ (π/2)/((1 − λ) β) with vₘ = (h/β)/(σ₀ λ + (1 − λ) 2/π).
        let l = inflection.unwrap_or(0.5);
        let greatest = 0.03 / FRAC_PI_2 / ((0.25 + 1.0 / PI) * l + FRAC_2_PI * (1.0 - l));
        assert!((before[2] + greatest / (1.0 - l)).abs() < 1e-12);
    }
}

#[test]
fn polynomials_meet_all_that_is_given_at_their_ends() {
    let general = |jerks: [Option<f64>; 2]| {
        let point =
            |phi: f64, u, v, a, jerk| PlanPoint { phi, velocity: Some(v), acceleration: Some(a), jerk, ..at(0.0, u) };
        law(vec![point(0.0, 0.0, 0.4, -3.0, jerks[0]), point(1.0, 1.0, 1.1, 2.0, jerks[1])])
    };
    let expand = |law: MotionLaw| {
        let mut c = [0.0; 8];
        law.expand(law.segment(0.5, true), 0.0, 1.0, &mut c);
        c
    };
    for (found, printed) in expand(general([None; 2])).into_iter().zip([0.0, 0.4, -1.5, 8.7, -10.6, 4.0, 0.0, 0.0]) {
        assert!((found - printed).abs() < 1e-13);
    }
    let seventh = [0.0, 0.4, -1.5, 10.0 / 6.0, 24.66666666667, -59.6, 49.53333333333, -14.16666666667];
    for (found, printed) in expand(general([Some(10.0), Some(-5.0)])).into_iter().zip(seventh) {
        assert!((found - printed).abs() < 2e-11);
    }
    let degrees = [0.0, 1f64.to_degrees()];
    for (inflection, half, peaks) in [
        (0.40, 0.45568, [2.0736, 8.134530459216, 5.974530459216, 120.0]),
        (0.42, 0.4586354427303, [1.989283191193, 7.426879357729, 5.543677958497, 104.0366972477]),
        (0.48, 0.4876208194065, [1.881062895484, 6.072116456264, 5.542007917099, 69.67741935484]),
    ] {
        let rise = normalised(Some(SegmentLaw::Polynomial6), inflection, [0.0; 2], [false; 2]);
        close(rise.at(inflection).0[0], half);
        let [most, least] = extremes(&rise, degrees, |u| u[2]);
        let found = [extremes(&rise, degrees, |u| u[1])[0], most, -least, extremes(&rise, degrees, |u| u[3].abs())[0]];
        for (found, printed) in found.into_iter().zip(peaks) {
            assert!((found / printed - 1.0).abs() < 1e-7, "{inflection} {found} {printed}");
        }
    }
}

#[test]
fn unasked_the_sine_leaves_the_border_of_its_range_to_the_modified_sine() {
    // A quarter sine of no length would be a jump of U″.
    for velocity in [FRAC_PI_2, 1.571, 2.7] {
        let to = PlanPoint { velocity: Some(velocity), phi: 1.0, ..at(0.0, 1.0) };
        let law = law(vec![at(0.0, 0.0), to, at(200.0, 2.0)]);
        assert!(law.at_in(law.segment(0.0, true), 0.0).0[2].abs() < 1e-12, "{velocity}");
    }
}

#[test]
fn cosines_meet_the_acceleration_of_both_ends() {
    let end = |u: f64, b: f64| PlanPoint { acceleration: Some(b * PI * PI), ..at(0.0, u) };
    let rise = |b: [f64; 2]| {
        let to = PlanPoint { phi: 1.0, law: Some(SegmentLaw::Cosines), ..end(1.0, -b[1]) };
        law(vec![with(SegmentLaw::Standard(StandardLaw::Polynomial345), end(0.0, b[0])), to])
    };
    let law = rise([0.6, 1.1]);
    for (z, printed) in [(0.2, 0.1012190519688), (0.5, 0.375), (0.9, 0.9476987024959)] {
        close(law.at(z).0[0], printed);
    }
    for (inflection, b, velocity, [most, least]) in [
        (0.55, 0.463582557827, 2.049534570675, [6.759958691282, -5.920631837048]),
        (0.65, 0.923793350840, 2.006923005380, [5.570236283189, -9.117474921144]),
    ] {
        let (law, degrees) = (rise([0.0, b]), [0.0, 1f64.to_degrees()]);
        assert!(law.at(inflection).0[2].abs() < 1e-10 && law.at_in(law.segment(0.5, true), 1.0).0[3].abs() < 1e-12);
        let found = [extremes(&law, degrees, |u| u[1])[0], extremes(&law, degrees, |u| u[2])[0]];
        for (found, printed) in found.into_iter().zip([velocity, most]) {
            assert!((found / printed - 1.0).abs() < 1e-7, "{found} {printed}");
        }
        assert!((extremes(&law, degrees, |u| u[2])[1] / least - 1.0).abs() < 1e-7);
    }
}

#[test]
fn a_cycle_is_a_plan_of_four_points() {
    use crate::motion::{Cycle, CyclePlan};
    for (rise_law, return_law, inflections) in [
        (StandardLaw::ModifiedSine, StandardLaw::Polynomial4567, [None, Some(0.6)]),
        (StandardLaw::InclinedSine, StandardLaw::ModifiedTrapezoid, [Some(0.45), None]),
    ] {
        let cycle = MotionLaw::Cycle(Cycle::new(CyclePlan {
            stroke: 0.04,
            lower: 0.01,
            rise_start: 0.5,
            rise_angle: 1.5,
            upper_dwell: 0.7,
            return_angle: 2.0,
            rise_law,
            return_law,
            inflections,
        }));
        let point = |phi: f64, u, law, inflection| PlanPoint { phi, inflection, law, ..at(0.0, u) };
        let plan = law(vec![
            point(0.5, 0.01, None, None),
            point(2.0, 0.05, Some(SegmentLaw::Standard(rise_law)), inflections[0]),
            point(2.7, 0.05, None, None),
            point(4.7, 0.01, Some(SegmentLaw::Standard(return_law)), inflections[1]),
        ]);
        assert_eq!(cycle.breakpoints(), plan.breakpoints());
        for i in 0..500 {
            let phi = 0.013 * f64::from(i);
            for n in 0..5 {
                assert!((cycle.at(phi).0[n] - plan.at(phi).0[n]).abs() <= 1e-13 * cycle.bound(n), "{phi} {n}");
            }
        }
    }
}

#[test]
fn what_makes_no_plan_is_refused_by_name_and_rests() {
    let refused = |points: Vec<PlanPoint>, part: &str| {
        let plan = MotionPlan::new(points);
        let said = plan.validate().unwrap_err().to_string();
        assert!(said.contains(part), "{said}");
        assert_eq!(MotionLaw::Plan(plan.clone()).at(1.0).0[1..], [0.0; 4]);
    };
    let standard = |law| SegmentLaw::Standard(law);
    refused(vec![at(0.0, 0.0)], "a plan has 2 to 100");
    refused(vec![at(0.0, 0.0), at(90.0, f64::NAN)], "point[2].U: out of range");
    refused(vec![at(0.0, 0.0), at(90.0, 1.0), at(80.0, 0.0)], "point[3].phi: 80 deg is not beyond");
    refused(vec![at(0.0, 0.0), at(90.0, 1.0), at(361.0, 0.0)], "point[3].phi");
    refused(vec![at(0.0, 0.0), PlanPoint { inflection: Some(1.0), ..at(90.0, 1.0) }], "point[2].inflection");
    let straight = PlanPoint { velocity: Some(1.0), ..with(SegmentLaw::Straight, at(90.0, 1.0)) };
    refused(vec![at(0.0, 0.0), straight], "point[2].dU: 1 m/rad, but a straight segment next to it has");
    refused(vec![at(0.0, 0.0), with(SegmentLaw::Sine, at(90.0, 1.0))], "point[2].law: `sine` cannot lead");
    let moving = PlanPoint { velocity: Some(1.0), acceleration: Some(1.0), ..at(90.0, 1.0) };
    refused(
        vec![at(0.0, 0.0), with(standard(StandardLaw::ModifiedSine), moving)],
        "only polynomial_345 and polynomial_4567",
    );
    refused(vec![at(0.0, 0.0), PlanPoint { free: true, ..moving }], "only at a turning point");
    let between = PlanPoint { free: true, ..at(90.0, 1.0) };
    refused(vec![at(0.0, 0.0), between, at(180.0, 2.0)], "point[2].ddU: only at a turning point");
    refused(vec![at(0.0, 0.0), PlanPoint { acceleration: Some(-0.1), ..at(90.0, 1.0) }], "needs an inflection");
    let sixth = PlanPoint { inflection: Some(0.3), ..with(SegmentLaw::Polynomial6, at(90.0, 1.0)) };
    refused(vec![at(0.0, 0.0), sixth], "polynomial_6 has one inflection and no overshoot from 0.4 to 0.6 only");
    let sine = PlanPoint {
        inflection: Some(0.4),
        ..with(SegmentLaw::Sine, PlanPoint { velocity: Some(2.0), ..at(57.3, 1.0) })
    };
    refused(vec![at(0.0, 0.0), sine], "the law of this segment has no such parameter");
    refused(vec![turning(at(0.0, 0.0)), turning(at(150.0, 0.01))], "have no common ddU");
    let cosines = PlanPoint { velocity: Some(1.0), ..with(SegmentLaw::Cosines, at(90.0, 1.0)) };
    refused(vec![at(0.0, 0.0), cosines], "from standstill to standstill only");
    let cosines = PlanPoint { inflection: Some(0.6), ..with(SegmentLaw::Cosines, at(90.0, 1.0)) };
    refused(vec![at(0.0, 0.0), cosines], "follows from ddU at both ends");
    let polynomials = |u| with(standard(StandardLaw::Polynomial345), turning(at(90.0, u)));
    let back = with(standard(StandardLaw::Polynomial345), at(0.0, 0.0));
    refused(vec![back, polynomials(1.0)], "do not determine it; give its value");
    let sine = |point| with(standard(StandardLaw::ModifiedSine), point);
    let jerky = PlanPoint { jerk: Some(1.0), ..sine(at(90.0, 1.0)) };
    refused(vec![sine(at(0.0, 0.0)), jerky], "point[2].dddU: no polynomial next to");
}
