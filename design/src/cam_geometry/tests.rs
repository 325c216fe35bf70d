//! Circles, the formulas of the lever in real quantities, cusps and crossings, rollers on their contours, files read back.

use super::checks::{findings, worst};
use super::files::{CamDrawing, csv, drawing, dxf};
use super::*;
use crate::report::Level;
use camdrive::motion::{Cycle, CyclePlan, Fourier, StandardLaw};

fn fourier(a: Vec<f64>, b: Vec<f64>) -> MotionLaw {
    MotionLaw::Fourier(Fourier::new(a, b))
}

/// A law that no symmetry helps.
fn lively() -> MotionLaw {
    fourier(vec![0.02, -0.02, 0.003], vec![0.0, 0.004])
}

fn cycle(law: StandardLaw, rise_start: f64) -> MotionLaw {
    let plan = CyclePlan {
        stroke: 0.03,
        lower: 0.0,
        rise_start,
        rise_angle: 1.0,
        upper_dwell: 0.5,
        return_angle: 1.0,
        rise_law: law,
        return_law: law,
        inflections: [None; 2],
    };
    MotionLaw::Cycle(Cycle::new(plan))
}

fn lever(law: MotionLaw, side: f64, sense: f64) -> Cam {
    let follower = Follower::Lever { pivot: 0.16, length: 0.12, start: 0.5, transmission: 0.2, side };
    Cam { law, follower, sense, roller: 0.02 }
}

fn translating(law: MotionLaw, eccentricity: f64, sense: f64) -> Cam {
    Cam { law, follower: Follower::Translating { eccentricity, start: 0.06 }, sense, roller: 0.015 }
}

fn plan(cam: &Cam, cut: Cut) -> Plan {
    let (carrier, start) = match cam.follower {
        Follower::Lever { pivot, length, start, transmission, side } => {
            (Carrier::Lever { pivot, length, transmission, side }, start)
        }
        Follower::Translating { eccentricity, start } => (Carrier::Translating { eccentricity }, start),
        Follower::Flat { start } => (Carrier::Flat, start),
    };
    let limits = Limits { pressure: 0.785, cutter: 0.005, hub: 0.0 };
    Plan { carrier, angular: false, start: Start::Coordinate(start), sense: cam.sense, roller: cam.roller, cut, limits }
}

fn outlines(cam: &Cam, cut: Cut, tolerance: f64) -> Vec<Outline> {
    let mesh = Mesh::new(cam, cut.sides(), tolerance).unwrap();
    cut.sides().iter().map(|side| mesh.outline(cam, *side)).collect()
}

/// The finding whose name has this part.
fn find(list: &[Finding], what: &str) -> Finding {
    list.iter().find(|f| f.what.contains(what)).unwrap_or_else(|| panic!("{what} is missing in {list:?}")).clone()
}

fn all_followers(law: &MotionLaw) -> Vec<Cam> {
    let mut list = Vec::new();
    for sense in [1.0, -1.0] {
        for side in [1.0, -1.0] {
            list.push(lever(law.clone(), side, sense));
            list.push(translating(law.clone(), 0.02 * side, sense));
        }
    }
    list
}

#[test]
fn without_motion_the_cam_is_a_circle() {
    for cam in all_followers(&fourier(vec![0.01], vec![])) {
        let radius = cam.at(0.0).unwrap().centre.norm();
        for i in 0..20 {
            let at = cam.at(TAU * f64::from(i) / 20.0).unwrap();
            assert!((at.centre.norm() - radius).abs() < 1e-16);
            // A cam that turns counter-clockwise sees the roller run clockwise.
            assert!((at.curvature + cam.sense / radius).abs() < 1e-12 / radius);
            for (side, sign) in [(Side::Inner, -1.0), (Side::Outer, 1.0), (Side::Path, 0.0)] {
                assert!((side.point(&cam, &at).norm() - (radius + sign * cam.roller)).abs() < 1e-16);
                assert!((side.curvature(&cam, &at).abs() - 1.0 / (radius + sign * cam.roller)).abs() < 1e-9);
            }
        }
        // The polygon is as near to the circle as is asked for, and not much nearer; its error is told.
        let mesh = Mesh::new(&cam, &[Side::Inner], 1e-7).unwrap();
        let error = radius * (1.0 - (TAU / (2.0 * mesh.at.len() as f64)).cos());
        assert!(error < 1e-7 && error > 1e-8 && (mesh.chord_error - error).abs() < 1e-3 * error);
        let list = findings(&cam, &plan(&cam, Cut::Groove), &outlines(&cam, Cut::Groove, 1e-6)).unwrap();
        let close = |what: &str, value: f64| assert!((find(&list, what).value - value).abs() < 1e-12, "{what}");
        close("smallest radius of curvature of the roller path", radius);
        close("undercut of the inner contour", radius);
        close("base circle", radius - cam.roller);
        close("smallest convex radius of curvature, inner", radius - cam.roller);
        close("smallest concave radius of curvature, outer", radius + cam.roller);
        assert_eq!(find(&list, "undercut of the outer").value, f64::INFINITY);
        assert!(!list.iter().any(|f| f.what.contains("cross") || f.what.contains("hollow of the inner")));
    }
}

#[test]
fn an_eccentric_circle() {
    // A circle of radius R about a point at the distance e from the cam's centre moves a central translating follower by
    // h(φ) = √(R² − e² sin² φ) − e cos φ; path and contours are circles about that point, exactly.
    let (radius, e): (f64, f64) = (0.06, 0.008);
    let n = 512;
    let height = |phi: f64| (radius * radius - (e * phi.sin()).powi(2)).sqrt() - e * phi.cos();
    let coefficient = |k: usize| {
        let sum: f64 = (0..n).map(|i| TAU * i as f64 / n as f64).map(|phi| height(phi) * (k as f64 * phi).cos()).sum();
        sum * if k == 0 { 1.0 } else { 2.0 } / n as f64
    };
    let law = fourier((0..=24).map(coefficient).collect(), vec![]);
    for sense in [1.0, -1.0] {
        let follower = Follower::Translating { eccentricity: 0.0, start: 0.0 };
        let cam = Cam { law: law.clone(), follower, sense, roller: 0.012 };
        let middle = Point::new(0.0, -e);
        for i in 0..50 {
            let phi = TAU * f64::from(i) / 50.0;
            let at = cam.at(phi).unwrap();
            assert!(((at.centre - middle).norm() - radius).abs() < 1e-15);
            assert!((at.curvature + sense / radius).abs() < 1e-10 / radius);
            // The normal passes through the middle of the circle, e sin φ beside the follower's line.
            assert!((at.pressure - (e * phi.sin() / radius).abs().asin()).abs() < 1e-13);
            for (side, r) in [(Side::Inner, radius - 0.012), (Side::Outer, radius + 0.012)] {
                assert!(((side.point(&cam, &at) - middle).norm() - r).abs() < 1e-15);
            }
        }
        let list = findings(&cam, &plan(&cam, Cut::Inner), &outlines(&cam, Cut::Inner, 1e-6)).unwrap();
        let pressure = find(&list, "pressure");
        assert!((pressure.value - (e / radius).asin()).abs() < 1e-12, "{pressure:?}");
        assert!((find(&list, "base circle").value - (radius - e - 0.012)).abs() < 1e-14);
        assert!((find(&list, "largest radius of the inner").value - (radius + e - 0.012)).abs() < 1e-14);
    }
}

#[test]
fn the_lever_in_real_quantities() {
    // r² = d² + l² − 2dl cos ψ, N = l(1 + εψ′), V² = N² + d² − 2Nd cos ψ, tan α = |N − d cos ψ|/|d sin ψ|,
    // σκ = (l d ψ″ sin ψ − εψ′N(N − d cos ψ) − V²)/V³, ε = σs.
    for (side, sense) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let cam = lever(lively(), side, sense);
        let (d, l, e) = (0.16, 0.12, sense * side);
        for i in 0..50 {
            let phi = TAU * f64::from(i) / 50.0;
            let at = cam.at(phi).unwrap();
            let [u, u1, u2, ..] = cam.law.at(phi).0;
            let (psi, psi1, psi2) = (0.5 + u / 0.2, u1 / 0.2, u2 / 0.2);
            assert!((at.lift - u).abs() < 1e-16 && (at.coordinate - psi).abs() < 1e-15);
            let n = l * (1.0 + e * psi1);
            let across = n - d * psi.cos();
            let v = (n * n + d * d - 2.0 * n * d * psi.cos()).sqrt();
            assert!((at.centre.norm_sqr() - (d * d + l * l - 2.0 * d * l * psi.cos())).abs() < 1e-16);
            assert!((at.speed - v).abs() < 1e-15);
            assert!((at.pressure - across.abs().atan2((d * psi.sin()).abs())).abs() < 1e-13);
            let kappa = sense * (l * d * psi2 * psi.sin() - e * psi1 * n * across - v * v) / v.powi(3);
            assert!((at.curvature - kappa).abs() < 1e-11 * (1.0 / v), "{side} {sense} {phi}: {} {kappa}", at.curvature);
        }
    }
}

#[test]
fn the_pressure_angle_of_a_translating_follower() {
    for sense in [1.0, -1.0] {
        let cam = translating(fourier(vec![0.0, 0.01], vec![0.0, 0.005]), 0.012, sense);
        for i in 0..40 {
            let phi = TAU * f64::from(i) / 40.0;
            let [u, u1, ..] = cam.law.at(phi).0;
            let tangent = (u1 - sense * 0.012).abs() / (0.06 + u);
            assert!((cam.at(phi).unwrap().pressure - tangent.atan()).abs() < 1e-14);
        }
    }
}

#[test]
fn tangent_and_curvature_are_those_of_the_path() {
    let cam = lever(lively(), 1.0, 1.0);
    let h = 1e-4;
    for i in 0..20 {
        let phi = 0.05 + 6.1 * f64::from(i) / 20.0;
        let at = cam.at(phi).unwrap();
        let z = |k: f64| cam.at(phi + k * h).unwrap();
        let slope = (z(1.0).centre - z(-1.0).centre) / (2.0 * h);
        assert!((slope / slope.norm() - at.tangent).norm() < 1e-7);
        // κ = d(direction)/ds.
        let turn = (z(1.0).tangent / z(-1.0).tangent).arg();
        assert!((turn / (2.0 * h * at.speed) - at.curvature).abs() < 1e-4 * at.curvature.abs().max(1.0));
        // The contour's own direction is that of the path, and its curvature that of the parallel curve.
        for side in [Side::Inner, Side::Outer] {
            let step = (side.point(&cam, &z(1.0)) - side.point(&cam, &z(-1.0))) / (2.0 * h);
            assert!((step / at.tangent - side.growth(&cam, &at) * at.speed).norm() < 1e-7);
        }
    }
}

#[test]
fn rollers_touch_their_contours_and_nothing_else() {
    // No point of the polygon is nearer to the roller's centre than its radius, less the chord error, and one is that near.
    let touches = |cam: &Cam, side: Side| {
        let outline = &Mesh::new(cam, &[side], 1e-7).unwrap().outline(cam, side).points;
        for i in 0..60 {
            let centre = cam.at(TAU * (f64::from(i) + 0.3) / 60.0).unwrap().centre;
            let edges = (0..outline.len()).map(|j| (outline[j].1, outline[(j + 1) % outline.len()].1));
            let nearest = edges.map(|(a, b)| contour::distance(centre, a, b)).fold(f64::INFINITY, f64::min);
            assert!((nearest - cam.roller).abs() < 1e-7, "{side:?}: {nearest}");
        }
    };
    for law in [lively(), cycle(StandardLaw::ModifiedSine, 0.4)] {
        for cam in all_followers(&law) {
            for side in [Side::Inner, Side::Outer] {
                touches(&Cam { roller: 0.008, ..cam.clone() }, side);
            }
        }
    }
    let second = Second { place: 1.4, length: 0.1, roller: 0.01 };
    touches(&lever(lively(), 1.0, 1.0).conjugate(second), Side::Inner);
    touches(&translating(lively(), 0.01, 1.0).conjugate(Second { place: 0.15, ..second }), Side::Inner);
}

#[test]
fn both_cams_of_a_conjugate_pair_hold_the_follower() {
    for (side, sense) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)] {
        let cam = lever(lively(), side, sense);
        let second = cam.conjugate(Second { place: 1.4, length: 0.1, roller: 0.018 });
        for i in 0..40 {
            let phi = TAU * f64::from(i) / 40.0;
            let turn = Point::from_polar(1.0, sense * phi);
            let arm = |cam: &Cam| turn * cam.at(phi).unwrap().centre - 0.16;
            // Both arms are those of one rigid rocker, one on either side of the line to the cam's centre.
            let (first, other) = (arm(&cam), arm(&second));
            assert!((first.norm() - 0.12).abs() < 1e-15 && (other.norm() - 0.1).abs() < 1e-15);
            assert!(((other / first).arg() - side * 1.4).abs() < 1e-14);
            assert!(first.im * other.im < 0.0);
        }
    }
    let cam = translating(fourier(vec![0.0, 0.01], vec![]), 0.0, -1.0);
    let second = cam.conjugate(Second { place: 0.13, length: 0.0, roller: 0.015 });
    for phi in [0.3, 2.0, 4.0] {
        let distance = (cam.at(phi).unwrap().centre - second.at(phi).unwrap().centre).norm();
        assert!((distance - 0.13).abs() < 1e-15);
    }
    let list = findings(&second, &plan(&cam, Cut::Inner), &outlines(&second, Cut::Inner, 1e-6)).unwrap();
    assert!(list.iter().all(|finding| finding.verdict == Level::Good), "{list:?}");
}

#[test]
fn base_and_prime_circle_fix_the_size() {
    for law in [lively(), cycle(StandardLaw::Polynomial345, 2.0)] {
        for cam in all_followers(&law) {
            for transmission in [0.2, -0.3] {
                let mut plan = plan(&cam, Cut::Inner);
                if let Carrier::Lever { transmission: r, .. } = &mut plan.carrier {
                    *r = transmission;
                }
                let nearest = |start: Start| {
                    let (_, cam) = Plan { start, ..plan }.cams(&law).unwrap().remove(0);
                    // A thousand places of the turn, then as many around the nearest of them.
                    let norm = |at: &f64| cam.at(at.rem_euclid(TAU)).unwrap().centre.norm();
                    let around = |middle: f64, width: f64| {
                        let places = (0..1000).map(|i| middle + width * (1e-3 * f64::from(i) - 0.5));
                        places.min_by(|a, b| norm(a).total_cmp(&norm(b))).unwrap()
                    };
                    norm(&around(around(0.5 * TAU, TAU), 4e-3 * TAU))
                };
                assert!((nearest(Start::Prime(0.07)) - 0.07).abs() < 1e-9);
                assert!((nearest(Start::Base(0.05)) - 0.05 - cam.roller).abs() < 1e-9);
                let too =
                    |radius: f64| Plan { start: Start::Prime(radius), ..plan }.cams(&law).unwrap_err().to_string();
                assert!(too(0.01).contains("of 10 mm"), "{}", too(0.01));
            }
        }
    }
}

#[test]
fn undercut_begins_where_the_roller_is_as_large_as_the_radius_of_curvature() {
    let mut cam = translating(cycle(StandardLaw::Polynomial345, 0.0), 0.0, 1.0);
    let look = |cam: &Cam| findings(cam, &plan(cam, Cut::Inner), &outlines(cam, Cut::Inner, 1e-6)).unwrap();
    let most = find(&look(&cam), "undercut").value;
    cam.roller = most * (1.0 - 1e-6);
    assert_eq!(find(&look(&cam), "undercut").verdict, Level::Good);
    cam.roller = most * 1.001;
    let finding = find(&look(&cam), "undercut");
    assert!(finding.verdict == Level::Bad && finding.remark.contains("smaller"), "{finding:?}");
    // It does not hide what else is wrong: hollows of the path are no places of undercut, ϱ wider than those of the path.
    let hollow = |cam: &Cam| find(&look(cam), "smallest concave").value - cam.roller;
    let slender = Cam { roller: 0.5 * most, ..cam.clone() };
    assert!((hollow(&cam) / hollow(&slender) - 1.0).abs() < 1e-12);
    let mut coarse = plan(&cam, Cut::Inner);
    coarse.limits.cutter = 2.0 * hollow(&cam) + cam.roller;
    let list = findings(&cam, &coarse, &outlines(&cam, Cut::Inner, 1e-6)).unwrap();
    assert!(["undercut", "smallest concave"].iter().all(|what| find(&list, what).verdict == Level::Bad));
    // A much larger roller leaves a contour that crosses itself, which the search for crossings finds by itself.
    cam.roller = 1.3 * most;
    assert_eq!(find(&look(&cam), "crosses itself").verdict, Level::Bad);
}

#[test]
fn a_groove_whose_passages_meet_is_refused() {
    // Five steep lifts in a turn: the path comes nearer to itself than two rollers, though no contour has a cusp.
    let cam = Cam { roller: 0.011, ..translating(fourier(vec![0.04, 0.0, 0.0, 0.0, 0.0, -0.035], vec![]), 0.0, 1.0) };
    let shapes = outlines(&cam, Cut::Groove, 1e-6);
    let list = findings(&cam, &plan(&cam, Cut::Groove), &shapes).unwrap();
    assert!(list.iter().any(|f| f.what.contains("cross") && f.verdict == Level::Bad), "{list:?}");
    let slender = Cam { roller: 0.0005, ..cam };
    let shapes = outlines(&slender, Cut::Groove, 1e-6);
    let list = findings(&slender, &plan(&slender, Cut::Groove), &shapes).unwrap();
    assert!(!list.iter().any(|f| f.what.contains("cross")), "{list:?}");
}

#[test]
fn a_steep_cam_is_warned_of_with_its_angle() {
    let cam = translating(fourier(vec![0.05, -0.05], vec![]), 0.0, 1.0);
    let mut plan = plan(&cam, Cut::Inner);
    plan.limits.pressure = 0.4;
    let pressure = find(&findings(&cam, &plan, &outlines(&cam, Cut::Inner, 1e-6)).unwrap(), "pressure");
    // tan α = U′/(h₀ + U), largest where its derivative vanishes: cos φ = 0.05/0.11.
    let best = (0.05_f64 / 0.11).acos();
    let tangent = 0.05 * best.sin() / (0.11 - 0.05 * best.cos());
    assert!((pressure.value.tan() - tangent).abs() < 1e-14, "{pressure:?}");
    assert!((pressure.phi - best).abs() < 1e-6 || (pressure.phi - TAU + best).abs() < 1e-6);
    assert_eq!(pressure.verdict, Level::Mind);
}

#[test]
fn places_where_no_cam_can_move_the_follower_are_faults() {
    let with = |start: f64, cam: &Cam| {
        let mut cam = cam.clone();
        match &mut cam.follower {
            Follower::Lever { start: s, .. } | Follower::Translating { start: s, .. } | Follower::Flat { start: s } => {
                *s = start
            }
        }
        findings(&cam, &plan(&cam, Cut::Inner), &outlines(&cam, Cut::Inner, 1e-5)).unwrap()
    };
    let rocker = lever(fourier(vec![0.0, 0.02], vec![]), 1.0, 1.0);
    assert_eq!(find(&with(0.05, &rocker), "least angle of the lever").verdict, Level::Bad);
    assert_eq!(find(&with(3.1, &rocker), "largest angle of the lever").verdict, Level::Bad);
    assert_eq!(find(&with(1.0, &rocker), "largest angle of the lever").verdict, Level::Good);
    let slide = translating(fourier(vec![0.0, 0.02], vec![]), 0.03, 1.0);
    assert_eq!(find(&with(0.01, &slide), "least height").verdict, Level::Bad);
    // A disc that reaches the pivot of its lever, and one that leaves no room for the shaft.
    assert_eq!(find(&with(2.2, &rocker), "largest radius").verdict, Level::Mind);
    let mut plan = plan(&rocker, Cut::Inner);
    plan.limits.hub = 0.2;
    let list = findings(&rocker, &plan, &outlines(&rocker, Cut::Inner, 1e-5)).unwrap();
    assert_eq!(find(&list, "base circle").verdict, Level::Bad);
}

#[test]
fn a_roller_at_the_centre_stands_still() {
    let cam = Cam { law: fourier(vec![0.0], vec![]), ..translating(lively(), 0.0, 1.0) };
    let cam = Cam { follower: Follower::Translating { eccentricity: 0.0, start: 0.0 }, ..cam };
    let fault = Fault::from(Mesh::new(&cam, &[Side::Inner], 1e-6).unwrap_err());
    assert!(fault.to_string().contains("stands still") && fault.to_string().contains("0.000°"), "{fault}");
    let fine = Mesh::new(&translating(lively(), 0.0, 1.0), &[Side::Inner], 1e-16).unwrap_err();
    assert!(Fault::from(fine).to_string().contains("points"));
}

#[test]
fn turns_begin_at_zero_whatever_the_breakpoints() {
    for start in [0.0, 0.7, 5.9, -1.0] {
        let cam = translating(cycle(StandardLaw::ModifiedTrapezoid, start), 0.0, 1.0);
        let mesh = Mesh::new(&cam, &[Side::Inner], 1e-6).unwrap();
        assert!(mesh.at[0].phi == 0.0 && mesh.at.windows(2).all(|w| w[0].phi < w[1].phi));
        assert!(mesh.at.last().unwrap().phi < TAU);
        // Neighbours are near each other all around.
        let n = mesh.at.len();
        assert!((0..n).all(|i| (mesh.at[i].centre - mesh.at[(i + 1) % n].centre).norm() < 0.004));
    }
}

/// Polylines with the names of their layers.
type Layers = Vec<(String, Vec<Point>)>;

/// The polylines of a DXF by layer, closed ones only, and its circles; a reader that knows no more than the format's rules.
fn polylines(text: &str) -> (Layers, Vec<(Point, f64)>) {
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len() % 2, 0);
    let pairs: Vec<(i32, &str)> = lines.chunks(2).map(|pair| (pair[0].parse().unwrap(), pair[1])).collect();
    let (mut found, mut circles) = (Vec::new(), Vec::new());
    let mut entity = "";
    for (code, value) in pairs {
        let number = || value.parse::<f64>().unwrap() / 1e3;
        match (code, entity) {
            (0, _) => {
                entity = value;
                match entity {
                    "POLYLINE" => found.push((String::new(), Vec::new())),
                    "VERTEX" => found.last_mut().unwrap().1.push(Point::from(0.0)),
                    "CIRCLE" => circles.push((Point::from(0.0), 0.0)),
                    _ => {}
                }
            }
            (8, "POLYLINE") => found.last_mut().unwrap().0 = value.to_owned(),
            (8, "VERTEX") => assert_eq!(found.last().unwrap().0, value),
            (70, "POLYLINE") => assert_eq!(value, "1"),
            (10, "VERTEX") => found.last_mut().unwrap().1.last_mut().unwrap().re = number(),
            (20, "VERTEX") => found.last_mut().unwrap().1.last_mut().unwrap().im = number(),
            (10, "CIRCLE") => circles.last_mut().unwrap().0.re = number(),
            (20, "CIRCLE") => circles.last_mut().unwrap().0.im = number(),
            (40, "CIRCLE") => circles.last_mut().unwrap().1 = number(),
            _ => {}
        }
    }
    (found, circles)
}

#[test]
fn files_hold_the_contours() {
    let cam = lever(lively(), 1.0, 1.0);
    let mesh = Mesh::new(&cam, &[Side::Inner, Side::Outer], 1e-5).unwrap();
    let drawn =
        [CamDrawing { name: "", cam: &cam, mesh: &mesh, sides: Cut::Groove.sides(), angular: false, hub: 0.015 }];
    let text = dxf("a\nname", &drawn);
    assert!(text.starts_with("999\na name: ") && text.ends_with("0\nEOF\n") && text.contains("$INSUNITS\n70\n4\n"));
    let (found, circles) = polylines(&text);
    assert_eq!(found.len(), 3);
    for (layer, points) in found {
        let side = match layer.as_str() {
            "ROLLER_PATH" => Side::Path,
            "INNER_CONTOUR" => Side::Inner,
            _ => Side::Outer,
        };
        assert!(text.contains(&format!("LAYER\n2\n{layer}\n")));
        assert_eq!(points.len(), mesh.at.len());
        for (point, at) in points.iter().zip(&mesh.at) {
            assert!((point - side.point(&cam, at)).norm() < 1e-10);
        }
    }
    assert!((circles[0].0 - cam.at(0.0).unwrap().centre).norm() < 1e-10 && circles[0].1 == 0.02);
    let drawing = drawing("a < b & c", &drawn).svg("Cam of a < b & c", 1.0);
    let mut reader = quick_xml::Reader::from_str(&drawing);
    while !matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {}
    assert!(drawing.contains("mm\" viewBox") && drawing.contains("Cam of a &lt; b &amp; c"));
    for part in ["330°", "roller Ø 40,", "hub Ø 30", "turns counter-clockwise"] {
        assert!(drawing.contains(part), "{part}: {drawing:.2000}");
    }
    let table = csv(&drawn[0]).unwrap();
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    for (row, at) in reader.deserialize::<Vec<f64>>().zip(&mesh.at) {
        let row = row.unwrap();
        assert_eq!(row.len(), 15);
        let polar = Point::from_polar(row[5], row[6].to_radians());
        assert!((polar / 1e3 - at.centre).norm() < 1e-16 && row[0] == at.phi.to_degrees());
    }
    assert_eq!(table.lines().count(), mesh.at.len() + 1);
}

#[test]
fn cam_tables_keep_their_error() {
    let law = lively();
    let table = cam_table::CamTable::new(&law, false, 1e-6);
    assert!((table.rows.len() - 1).is_multiple_of(360) && table.error <= 1e-6);
    let middle = |pair: &[[f64; 4]]| law.at(0.5 * (pair[0][0] + pair[1][0])).0[0] - 0.5 * (pair[0][1] + pair[1][1]);
    let worst = table.rows.windows(2).map(|pair| middle(pair).abs()).fold(0.0, f64::max);
    assert!(worst <= table.error && worst > 0.3 * table.error, "{worst} {}", table.error);
    assert_eq!(table.plcopen().lines().count(), table.rows.len() + 1);
    assert!(table.two_columns().lines().all(|line| line.split('\t').count() == 2));
    // The longest table tells what it cannot keep.
    let table = cam_table::CamTable::new(&law, false, 1e-15);
    assert!(table.rows.len() <= 65_537 && table.error > 1e-15);
}

#[test]
fn the_report_tells_all() {
    let cam = lever(lively(), 1.0, 1.0);
    let second = Second { place: 1.4, length: 0.1, roller: 0.018 };
    let tolerances = Tolerances { chord: 1e-6, table: 1e-6 };
    let shape = Shape::new("rocker", &cam.law, plan(&cam, Cut::Conjugate(second)), tolerances).unwrap();
    let shapes = [shape];
    let found = report::CamSet::new("machine", &shapes);
    let (text, [shape]) = (found.report().text(400, false), &shapes);
    for part in ["conjugate", "rocker F", "rocker P", "pressure angle", "points, chord error", "cam table of"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let endings: Vec<String> =
        shape.files().into_iter().map(|(ending, content)| (content.unwrap(), ending).1).collect();
    assert_eq!(endings, ["F.csv", "P.csv", "dxf", "plcopen.csv", "plc.txt"]);
    assert_eq!(shape.diagrams().map(|(name, _)| name), ["pressure_angle", "curvature"]);
    let summary = serde_json::to_value(&found).unwrap();
    assert!(summary["followers"][0]["cams"][1]["findings"].as_array().unwrap().len() > 6);
}

#[test]
fn jumps_of_the_acceleration_are_told_with_the_cam_table() {
    let cycle = |rise_law| {
        let [rise_angle, upper_dwell, return_angle] = [100_f64, 60.0, 90.0].map(f64::to_radians);
        let plan = CyclePlan {
            stroke: 0.02,
            lower: 0.0,
            rise_start: 0.0,
            rise_angle,
            upper_dwell,
            return_angle,
            rise_law,
            return_law: StandardLaw::ModifiedTrapezoid,
            inflections: [None; 2],
        };
        MotionLaw::Cycle(plan.into())
    };
    let told = |law| cam_table::CamTable::new(&cycle(law), false, 1e-6).jumps_told();
    assert_eq!(told(StandardLaw::Polynomial345), None);
    let told = told(StandardLaw::SimpleSine).unwrap();
    assert!(told.starts_with("U″ jumps at 0.00°, 100.00°;"), "{told}");
    // Of a table its spline has none.
    let points = |i: i32| (f64::from(i) * TAU / 36.0, (f64::from(i) * TAU / 36.0).sin());
    let (angles, lifts) = (0..36).map(points).unzip();
    let table =
        MotionLaw::Table(camdrive::motion::Table::new(camdrive::motion::table::Points { angles, lifts }).unwrap());
    assert_eq!(cam_table::CamTable::new(&table, false, 1e-2).jumps_told(), None);
}

#[test]
fn a_law_of_the_levers_angle_cuts_the_same_cam() {
    // U/R = 0.2⁻¹ U as an angle with the ratio 1: contours, and the controller's table in degrees within 1 µm of the roller.
    let (along, tolerances) = (lever(lively(), 1.0, 1.0), Tolerances { chord: 1e-6, table: 1e-6 });
    let MotionLaw::Fourier(series) = lively() else { panic!("the law is a series") };
    let angle = fourier(series.a.iter().map(|a| a / 0.2).collect(), series.b.iter().map(|b| b / 0.2).collect());
    let mut turning = Plan { angular: true, ..plan(&along, Cut::Inner) };
    if let Carrier::Lever { transmission, .. } = &mut turning.carrier {
        *transmission = 1.0;
    }
    let one = Shape::new("x", &lively(), plan(&along, Cut::Inner), tolerances).unwrap();
    let other = Shape::new("x", &angle, turning, tolerances).unwrap();
    for (a, b) in one.cams[0].mesh.at.iter().zip(&other.cams[0].mesh.at) {
        assert!((a.centre - b.centre).norm() < 1e-15 && (a.lift - 0.2 * b.lift).abs() < 1e-16);
    }
    let file = |shape: &Shape, ending: &str| {
        shape.files().into_iter().find(|(name, _)| name == ending).map(|(_, content)| content.unwrap()).unwrap()
    };
    assert!(file(&other, "csv").starts_with("phi_deg,lift_deg,") && file(&one, "csv").starts_with("phi_deg,lift_mm,"));
    let table = file(&other, "plcopen.csv");
    assert!(table.starts_with("MasterPosition[deg];SlavePosition[deg];SlaveVelocity[deg/deg];"));
    let first: f64 = table.lines().nth(1).unwrap().split(';').nth(1).unwrap().parse().unwrap();
    assert!((first - angle.at(0.0).0[0].to_degrees()).abs() < 1e-6);
    assert!(0.12 * other.table.error <= 1e-6 && 0.12 * other.table.error > 1e-7);
}

#[test]
fn the_highest_summit_need_not_have_the_highest_sample() {
    // cos 7x + ε cos x, x = φ − δ, is least at x = π; its other minima are higher by 2ε at most, and samples miss them by far more.
    for delta in [0.1, 0.7, 1.9] {
        let law = Fourier::new(vec![0.0, 1e-7, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], vec![]).delayed(delta);
        let cam = translating(MotionLaw::Fourier(law), 0.0, 1.0);
        let (_, depth) = worst(&cam, |segment, phi| Ok(-cam.law.at_in(segment, phi).0[0])).unwrap();
        assert!((depth - 1.0 - 1e-7).abs() < 1e-14, "{delta}: {depth}");
    }
}

mod flat;
mod inverse;
