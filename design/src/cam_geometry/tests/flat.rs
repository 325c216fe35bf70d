//! The flat face: the contour as an envelope of lines, its width and undercut, what is drawn and written.

use super::*;

fn flat(law: MotionLaw, sense: f64) -> Cam {
    Cam { law, follower: Follower::Flat { start: 0.05 }, sense, roller: 0.0 }
}

#[test]
fn the_contour_is_the_envelope_of_the_face() {
    for sense in [1.0, -1.0] {
        let cam = flat(lively(), sense);
        // Seen from the cam the face is the line Re(x n̄) = h with n = i e^{−iσφ}: no point of the contour is beyond it, one on it.
        let mesh = Mesh::new(&cam, &[Side::Inner], 1e-7).unwrap();
        let points = mesh.outline(&cam, Side::Inner).points;
        for k in 0..40 {
            let phi = TAU * f64::from(k) / 40.0;
            let (normal, height) = (I * Point::from_polar(1.0, -sense * phi), 0.05 + cam.law.at(phi).0[0]);
            let beyond = |p: &Point| (p * normal.conj()).re - height;
            let most = points.iter().map(|(_, p)| beyond(p)).fold(f64::NEG_INFINITY, f64::max);
            assert!(most < 1e-16 && most > -2e-7, "{most}");
            let at = cam.at(phi).unwrap();
            assert!(beyond(&Side::Inner.point(&cam, &at)).abs() < 1e-16);
            // It moves along the contour by h + U″ per radian.
            let h = 1e-4;
            let [before, after] = [-h, h].map(|d| Side::Inner.point(&cam, &cam.at((phi + d).rem_euclid(TAU)).unwrap()));
            let step = (after - before) / (2.0 * h) / at.tangent;
            let radius = height + cam.law.at(phi).0[2];
            assert!((step - radius).norm() < 1e-7 && (Side::Inner.closeness(&cam, &at) - radius).abs() < 1e-16);
            assert!((at.place.re - sense * cam.law.at(phi).0[1]).abs() < 1e-16 && at.pressure == 0.0);
        }
        // A cutter on the other side of the face leaves the same contour.
        let cut = Cam { roller: 0.03, ..cam.clone() };
        for phi in [0.3, 2.0, 5.0] {
            let [a, b] = [&cam, &cut].map(|cam| Side::Inner.point(cam, &cam.at(phi).unwrap()));
            assert!((a - b).norm() < 1e-16);
            let radius = Side::Inner.closeness(&cut, &cut.at(phi).unwrap());
            assert!((radius - 0.05 - cam.law.at(phi).0[0] - cam.law.at(phi).0[2]).abs() < 1e-15);
        }
    }
}

#[test]
fn the_face_is_as_wide_as_its_contact_moves() {
    // U = a + b cos φ + c sin 2φ: U′ = −b sin φ + 2c cos 2φ, with s = sin φ extreme at its ends s = ±1 or at s = −b/(8c).
    let (b, c): (f64, f64) = (0.004, 0.001);
    let law = fourier(vec![0.0, b], vec![0.0, 0.0, c]);
    let slope = |s: f64| -b * s + 2.0 * c * (1.0 - 2.0 * s * s);
    let (most, least) = (slope(-b / (8.0 * c)), slope(1.0));
    for sense in [1.0, -1.0] {
        let cam = flat(law.clone(), sense);
        let list = findings(&cam, &plan(&cam, Cut::Inner), &outlines(&cam, Cut::Inner, 1e-6)).unwrap();
        let face = find(&list, "width of the face");
        assert!((face.value - (most - least)).abs() < 1e-12, "{face:?}");
        let left = if sense > 0.0 { least } else { -most };
        assert!(
            face.remark.contains(&format!("x = {}", crate::report::terminal::shown(left, &crate::report::unit::MM))),
            "{face:?}"
        );
        assert!(!list.iter().any(|f| f.what.contains("path") || f.what.contains("pressure")), "{list:?}");
    }
}

#[test]
fn a_base_circle_above_the_least_one_has_no_undercut() {
    // U = b (1 − cos 3φ): h + U″ = h₀ + b + 8 b cos 3φ is least at 60°, h₀ − 7b, so that h₀ has to be above 7b.
    let law = fourier(vec![0.002, 0.0, 0.0, -0.002], vec![]);
    for (start, verdict) in [(0.0141, Level::Good), (0.0139, Level::Bad)] {
        let cam = Cam { follower: Follower::Flat { start }, ..flat(law.clone(), 1.0) };
        let based = Plan { start: Start::Base(start), ..plan(&cam, Cut::Inner) };
        assert_eq!(based.cams(&law).unwrap()[0].1, cam);
        let list = findings(&cam, &based, &outlines(&cam, Cut::Inner, 1e-6)).unwrap();
        let undercut = find(&list, "undercut");
        assert!((undercut.value - (start - 0.014)).abs() < 1e-12 && undercut.verdict == verdict, "{undercut:?}");
        let place = (undercut.phi.to_degrees() + 60.0) % 120.0;
        assert!(place.min(120.0 - place) < 1e-3, "{undercut:?}");
        assert_eq!(undercut.remark.contains("above 14.0000 mm"), verdict == Level::Bad, "{undercut:?}");
        assert_eq!(list.iter().any(|f| f.what.contains("crosses")), verdict == Level::Bad);
    }
}

#[test]
fn the_face_is_drawn_and_written() {
    let cam = Cam { roller: 0.01, ..flat(lively(), 1.0) };
    let tolerances = Tolerances { chord: 1e-5, table: 1e-6 };
    let shape = Shape::new("tappet", &cam.law, plan(&cam, Cut::Inner), tolerances).unwrap();
    let shapes = [shape];
    let found = report::CamSet::new("tappet", &shapes).report();
    let [shape] = &shapes;
    let files = || shape.files().into_iter().chain(found.files());
    let file = |ending: &str| files().find(|(name, _)| name == ending).unwrap().1.unwrap();
    let drawing = file("dxf");
    assert!(drawing.contains("0\nLINE\n8\nFACE\n") && drawing.contains("CUTTER_PATH") && !drawing.contains("ROLLER"));
    assert!(file("svg").contains("flat face, stroke") && !file("svg").contains("roller"));
    assert!(file("csv").lines().next().unwrap().contains(",contact_x_mm,"));
    assert_eq!(shape.diagrams().map(|(name, _)| name), ["contact", "curvature"]);
    assert!(found.text(100, false).contains("flat face"));
}
