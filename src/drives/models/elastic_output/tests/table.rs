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
    let before = at_once.statistics()[1];
    let end = 50.3 * TAU / 30.0;
    let [q, v] = run(&mut at_once, end, end);
    let found = run(&mut by_steps, end, 1e-3);
    let rate = (mcb[1] / mcb[0]).sqrt();
    assert_near(off([q, v], found, q.abs() + v.abs() / rate, rate), 1e-12, "50 turns");
    assert_eq!([at_once.statistics()[1], by_steps.statistics()[1]], [before; 2]);

    let steps = at_once.statistics()[0];
    run(&mut at_once, 1e6 * end, 1e6 * end);
    assert_eq!(at_once.statistics()[1], before);
    // Two times the cells of a turn, and two maps for each power of two.
    assert!(at_once.statistics()[0] - steps < 200.0, "{}", at_once.statistics()[0]);
}

#[test]
fn what_is_too_stiff_for_a_table_and_what_was_tuned_goes_on_in_pieces() {
    assert!(!turning([1.0, 1e10, 12.0]).response.is_on_table());
    let mut tuned = turning([1.0, 2e4, 12.0]);
    run(&mut tuned, 0.1, 0.01);
    assert!(tuned.response.is_on_table());
    tuned.parameters.b = 13.0;
    tuned.apply(0.1).unwrap();
    assert!(!tuned.response.is_on_table());
    let expected = {
        let mut drive = turning([1.0, 2e4, 12.0]);
        run(&mut drive, 0.1, 0.1);
        drive.parameters.b = 13.0;
        drive.apply(0.1).unwrap();
        run(&mut drive, 0.5, 0.4)
    };
    let found = run(&mut tuned, 0.5, 0.01);
    assert_near(off(found, expected, expected[0].abs() + expected[1].abs() / 140.0, 140.0), 1e-11, "tuned");
}
