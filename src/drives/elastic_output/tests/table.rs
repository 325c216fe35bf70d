//! Laws of segments at constant speed: the work of a step does not depend on its length.

use super::*;

fn turning(mcb: [f64; 3]) -> ElasticOutput {
    let mode = DriveMode::Constant { w: 30.0, phi_start: 0.1 };
    drive(scene(mcb, cycle(Polynomial345, InclinedSine), mode, at_rest()))
}

#[test]
fn a_step_over_any_number_of_turns_takes_the_same_work_and_leads_to_the_same_place() {
    let mcb = [1.0, 2e4, 12.0];
    let (mut at_once, mut by_steps) = (turning(mcb), turning(mcb));
    let before = at_once.evaluations();
    let end = 50.3 * TAU / 30.0;
    let [q, v] = run(&mut at_once, end, end);
    let found = run(&mut by_steps, end, 1e-3);
    let rate = (mcb[1] / mcb[0]).sqrt();
    assert_near([q, v], found, q.abs() + v.abs() / rate, rate, 1e-12, "50 turns");
    assert_eq!([at_once.evaluations(), by_steps.evaluations()], [before; 2]);

    let steps = at_once.steps();
    run(&mut at_once, 1e6 * end, 1e6 * end);
    assert_eq!(at_once.evaluations(), before);
    // Two times the cells of a turn, and two maps for each power of two.
    assert!(at_once.steps() - steps < 200.0, "{}", at_once.steps());
}

#[test]
fn what_hardly_vibrates_and_what_was_tuned_goes_on_in_pieces() {
    assert!(!turning([1.0, 1e10, 1e7]).response.is_on_table());
    let mut tuned = turning([1.0, 2e4, 12.0]);
    run(&mut tuned, 0.1, 0.01);
    assert!(tuned.response.is_on_table());
    tuned.b = 13.0;
    tuned.apply(0.1).unwrap();
    assert!(!tuned.response.is_on_table());
    let expected = {
        let mut drive = turning([1.0, 2e4, 12.0]);
        run(&mut drive, 0.1, 0.1);
        drive.b = 13.0;
        drive.apply(0.1).unwrap();
        run(&mut drive, 0.5, 0.4)
    };
    let found = run(&mut tuned, 0.5, 0.01);
    assert_near(found, expected, expected[0].abs() + expected[1].abs() / 140.0, 140.0, 1e-11, "tuned");
}

#[test]
fn the_table_of_a_stiff_spring_agrees_with_the_pieces() {
    // At rest at the start, so that the vibrations are excited with all their strength and by every jump of the jerk.
    for c in [1e6_f64, 1e8, 1e10] {
        let mcb = [1.0, c, 1e-6 * c.sqrt()];
        let (mut tabulated, mut pieces) = (turning(mcb), turning(mcb));
        // A change that is not felt, but leaves the table.
        pieces.b *= 1.0 + 1e-14;
        pieces.apply(0.0).unwrap();
        assert!(tabulated.response.is_on_table() && !pieces.response.is_on_table());
        let (rate, size) = (c.sqrt(), 30.0 * 30.0 / c);
        for n in 1..=40 {
            let end = 0.017 * f64::from(n);
            let expected = run(&mut pieces, end, 0.017);
            let found = run(&mut tabulated, end, 0.017);
            // The phase of 7e4 rad and its roundings.
            assert_near(found, expected, size, rate, 2e-10, &format!("c = {c}, t = {end}"));
        }
    }
}
