//! Live pages: which values may be moved, and what a page answers.

use camdrive_cli::document::Document;
use camdrive_cli::live::{Depth, Live, dials};
use serde_json::Value;
use std::path::Path;

fn example(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(path)).unwrap()
}

fn live(text: String) -> Live {
    Live::new("scene.toml", Document::new(text), Path::new("")).unwrap()
}

fn answer(live: &Live, values: &[(&str, &str)], as_sketch: bool) -> Value {
    let values = values.iter().map(|(key, text)| ((*key).to_owned(), (*text).to_owned())).collect();
    live.answer(&values, if as_sketch { Depth::Sketch } else { Depth::Whole }, |_| ())
}

#[test]
fn speed_is_the_first_of_the_numbers_of_a_scene_and_sliders_stay_in_the_range() {
    let found = dials(&Document::new(example("guide_bar/scene.toml")));
    let keys: Vec<&str> = found.iter().map(|dial| dial.key.as_str()).collect();
    // A series has a[0], but no b[0].
    let list = |name: &str, of: std::ops::Range<usize>| of.map(|k| format!("cam.{name}[{k}]")).collect::<Vec<_>>();
    let others = ["elasticity.m", "elasticity.natural_frequency", "elasticity.damping_ratio"].map(str::to_owned);
    let first = ["drive.speed", "cam.scale"].map(str::to_owned);
    assert_eq!(keys, [&first[..], &list("a", 0..6), &list("b", 1..6), &others].concat());
    // A zero of a list moves as far as its largest number is.
    assert_eq!((found[2].text.as_str(), found[2].ends), ("0", Some([-0.5867065, 0.5867065])));
    assert_eq!((found[0].text.as_str(), found[0].ends), ("1800 rpm", Some([600.0, 5400.0])));
    let narrow = "[[follower]]\nbacklash = { e = 0.6, s = \"inf\" }\n[follower.geometry]\nbase_radius = 1\n[solver]\ntolerance = 1e-9\n";
    let found = dials(&Document::new(narrow.to_owned()));
    // A longer list is a table of points.
    let long = format!("[cam]\na = {:?}\n", [0.5; 17]);
    assert!(dials(&Document::new(long)).is_empty());
    // A restitution is 1 at most; a word and what moves nothing have no slider.
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].key.as_str(), found[0].ends), ("follower[1].backlash.e", Some([0.2, 1.0])));
}

#[test]
fn a_value_moves_what_steady_finds_and_the_scene_stays_as_a_thin_line() {
    let live = live(example("guide_bar/scene.toml"));
    let html =
        |values: &[(&str, &str)], as_sketch| answer(&live, values, as_sketch)["html"].as_str().unwrap().to_owned();
    let (own, moved) = (html(&[], false), html(&[("drive.speed", "1900 rpm")], false));
    assert!(
        own.contains("At 1800\u{a0}rpm the motion repeats") && moved.contains("At 1900\u{a0}rpm the motion repeats")
    );
    let lines = |html: &str| html.matches("<polyline").count() + html.matches("<path").count();
    assert!(lines(&moved) > lines(&own), "{} {}", lines(&moved), lines(&own));
    let sketch = html(&[("drive.speed", "1900 rpm")], true);
    assert!(
        sketch.contains("data-key=\"deformation\"")
            && sketch.contains("data-key=\"force\"")
            && !sketch.contains("<table")
    );
    // A scene that follows inputs shows its default experiment.
    let run = answer(&self::live(example("guide_bar/run_up.toml")), &[], true);
    assert!(run["html"].as_str().unwrap().contains("Time [s]"), "{run}");
}

#[test]
fn wrong_values_get_the_message_of_the_reader() {
    let live = live(example("guide_bar/scene.toml"));
    for (value, words) in
        [("1800 mm", "is a length"), ("1e9 rpm", "is out of range; admissible: "), ("", "finite number")]
    {
        let told = answer(&live, &[("drive.speed", value)], true);
        assert_eq!(told["faults"][0]["key"], "drive.speed", "{told}");
        assert!(told["faults"][0]["text"].as_str().unwrap().contains(words), "{told}");
    }
}
