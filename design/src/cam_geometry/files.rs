//! Files for the workshop: contours as CSV, DXF and SVG, in mm, in the frame of the cam, which at φ = 0 is that of the
//! machine.

use super::{At, Cam, Follower, Mesh, Point, Side};
use crate::text;
use camdrive::drives::Fault;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// The unit of lengths in files for workshops.
const MILLIMETRES: f64 = 1e3;

/// A cam of the drawing.
pub struct Drawn<'a> {
    /// "F" and "P" of a conjugate pair, nothing where there is but one.
    pub name: &'static str,
    /// The cam.
    pub cam: &'a Cam,
    /// Its angles.
    pub mesh: &'a Mesh,
    /// Its contours.
    pub sides: &'static [Side],
    /// Whether its law is an angle.
    pub angular: bool,
}

impl Drawn<'_> {
    /// The path of the centre of roller or cutter, where there is one, and the contours.
    fn curves(&self) -> impl Iterator<Item = Side> {
        (self.cam.roller > 0.0).then_some(Side::Path).into_iter().chain(self.sides.iter().copied())
    }

    /// A flat face at φ = 0, as wide as it has to be (mm).
    fn face(&self) -> Option<[Point; 2]> {
        let first = self.mesh.at.first().filter(|_| matches!(self.cam.follower, Follower::Flat { .. }))?;
        let x = || self.mesh.at.iter().map(|at| at.place.re);
        let end = |x: f64| Point::new(x, first.coordinate) * MILLIMETRES;
        Some([end(x().fold(0.0, f64::min)), end(x().fold(0.0, f64::max))])
    }

    /// The points of a curve (mm).
    fn points(&self, side: Side) -> impl Iterator<Item = Point> {
        self.mesh.at.iter().map(move |at| side.point(self.cam, at) * MILLIMETRES)
    }

    /// The roller's centre at φ = 0 (mm); the mesh begins there.
    fn roller(&self) -> Point {
        self.mesh.at.first().map_or(Point::from(0.0), |at| at.centre * MILLIMETRES)
    }

    /// The pivot of the lever (mm).
    fn pivot(&self) -> Option<Point> {
        match self.cam.follower {
            Follower::Lever { pivot, .. } => Some(Point::from(pivot * MILLIMETRES)),
            _ => None,
        }
    }

    fn layer_of(&self, side: Side) -> &'static str {
        match side {
            Side::Path if self.face().is_some() => "CUTTER_PATH",
            Side::Path => "ROLLER_PATH",
            Side::Inner => "INNER_CONTOUR",
            Side::Outer => "OUTER_CONTOUR",
        }
    }

    /// The layer of a curve.
    fn layer(&self, what: &str) -> String {
        if self.name.is_empty() { what.to_owned() } else { format!("{}_{what}", self.name) }
    }
}

/// A length (mm) to a tenth of a nanometre, without the sign of a zero.
fn decimal(length: f64) -> String {
    let text = format!("{length:.7}");
    if text.trim_start_matches(['-', '0', '.']).is_empty() { "0.0".to_owned() } else { text }
}

/// The layers as an ASCII DXF (AutoCAD R12, which every CAD program reads), in mm: contours and roller paths as closed
/// polylines, the rollers at φ = 0 as circles, the cam's centre and the lever's pivot as points.
pub fn dxf(title: &str, drawn: &[Drawn<'_>]) -> String {
    // Group codes: 999 comment, 0 entity, 2 name, 8 layer, 66 vertices follow, 70 flags (1: closed), 10/20/30 coordinates,
    // 40 radius; $INSUNITS 4 and $MEASUREMENT 1 are millimetres and metric.
    let mut text = format!("999\n{}: camdrive, lengths in mm\n", title.replace(['\n', '\r'], " "));
    text += "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n4\n9\n$MEASUREMENT\n70\n1\n0\nENDSEC\n";
    let mut layers: Vec<String> = Vec::new();
    let mut entities = String::new();
    let point = |layers: &mut Vec<String>, layer: &str, place: Point| {
        if !layers.iter().any(|known| known == layer) {
            layers.push(layer.to_owned());
            let (x, y) = (decimal(place.re), decimal(place.im));
            return format!("0\nPOINT\n8\n{layer}\n10\n{x}\n20\n{y}\n30\n0.0\n");
        }
        String::new()
    };
    for cam in drawn {
        for side in cam.curves() {
            let layer = cam.layer(cam.layer_of(side));
            let _ = write!(entities, "0\nPOLYLINE\n8\n{layer}\n66\n1\n70\n1\n10\n0.0\n20\n0.0\n30\n0.0\n");
            for p in cam.points(side) {
                let (x, y) = (decimal(p.re), decimal(p.im));
                let _ = write!(entities, "0\nVERTEX\n8\n{layer}\n10\n{x}\n20\n{y}\n30\n0.0\n");
            }
            let _ = write!(entities, "0\nSEQEND\n8\n{layer}\n");
            layers.push(layer);
        }
        if let Some([from, to]) = cam.face() {
            let ([x, y], [x1, y1]) = ([from.re, from.im].map(decimal), [to.re, to.im].map(decimal));
            let layer = cam.layer("FACE");
            let _ = write!(entities, "0\nLINE\n8\n{layer}\n10\n{x}\n20\n{y}\n30\n0.0\n11\n{x1}\n21\n{y1}\n31\n0.0\n");
            layers.push(layer);
            entities += &point(&mut layers, "CENTRE", Point::from(0.0));
            continue;
        }
        let (layer, p) = (cam.layer("ROLLER"), cam.roller());
        let (x, y, radius) = (decimal(p.re), decimal(p.im), decimal(cam.cam.roller * MILLIMETRES));
        let _ = write!(entities, "0\nCIRCLE\n8\n{layer}\n10\n{x}\n20\n{y}\n30\n0.0\n40\n{radius}\n");
        layers.push(layer);
        entities += &point(&mut layers, "CENTRE", Point::from(0.0));
        if let Some(pivot) = cam.pivot() {
            entities += &point(&mut layers, "PIVOT", pivot);
        }
    }
    let _ = write!(text, "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n{}\n", layers.len());
    for layer in layers {
        // Colour 7, black or white; the contours are told by their layers.
        let _ = write!(text, "0\nLAYER\n2\n{layer}\n70\n0\n62\n7\n6\nCONTINUOUS\n");
    }
    text + "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" + &entities + "0\nENDSEC\n0\nEOF\n"
}

/// Room around the drawing (mm).
const ROOM: f64 = 5.0;

/// The height of letters: at least (mm), and of the drawing's width.
const LETTERS: [f64; 2] = [3.0, 0.018];

/// The cam as a drawing in its true size, read without colours: contours thick (that of the second cam dashed), path of the
/// roller's centre thin, centre, pivot, roller and lever at φ = 0.
pub fn svg(title: &str, drawn: &[Drawn<'_>]) -> String {
    let (mut low, mut high) = (Point::new(0.0, 0.0), Point::new(0.0, 0.0));
    let mut take = |p: Point, radius: f64| {
        low = Point::new(low.re.min(p.re - radius), low.im.min(p.im - radius));
        high = Point::new(high.re.max(p.re + radius), high.im.max(p.im + radius));
    };
    for cam in drawn {
        cam.curves().flat_map(|side| cam.points(side)).for_each(|p| take(p, 0.0));
        match cam.face() {
            Some(face) => face.into_iter().for_each(|p| take(p, 0.0)),
            None => take(cam.roller(), cam.cam.roller * MILLIMETRES),
        }
        cam.pivot().into_iter().for_each(|p| take(p, 0.0));
    }
    let letter = LETTERS[0].max(LETTERS[1] * (high.re - low.re));
    let (room, below) = (ROOM, 2.0 * letter);
    let sense = if drawn.first().is_some_and(|d| d.cam.sense > 0.0) { "counter-clockwise" } else { "clockwise" };
    let words = format!("{title}, scale 1 : 1, drawn at φ = 0; the cam turns {sense}");
    // Letters are half as wide as high.
    let wide = 0.55 * letter * words.chars().count() as f64;
    let (width, height) = ((high.re - low.re).max(wide) + 2.0 * room, high.im - low.im + 2.0 * room + below);
    let (left, top) = (low.re - room, -high.im - room);
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.3}mm\" height=\"{height:.3}mm\" viewBox=\"{left:.3} {top:.3} {width:.3} {height:.3}\" role=\"img\" font-family=\"sans-serif\" font-size=\"{letter:.3}\">\n<title>{}</title>\n<rect x=\"{left:.3}\" y=\"{top:.3}\" width=\"{width:.3}\" height=\"{height:.3}\" fill=\"white\"/>\n",
        escaped(title)
    );
    let mut labels = Vec::new();
    for (i, cam) in drawn.iter().enumerate() {
        for side in cam.curves() {
            let style = match side {
                Side::Path => "stroke=\"#555\" stroke-width=\"0.3\" stroke-dasharray=\"4 1 0.5 1\"",
                _ if i == 0 => "stroke=\"#000\" stroke-width=\"0.6\"",
                _ => "stroke=\"#000\" stroke-width=\"0.6\" stroke-dasharray=\"6 1.5\"",
            };
            let id = cam.layer(cam.layer_of(side)).to_lowercase();
            let _ = write!(text, "<path id=\"{id}\" fill=\"none\" {style} d=\"");
            for (i, p) in cam.points(side).enumerate() {
                let _ = write!(text, "{}{:.4} {:.4}", if i == 0 { "M" } else { "L" }, p.re, -p.im);
            }
            text += "Z\"/>\n";
        }
        let (p, radius) = (cam.roller(), cam.cam.roller * MILLIMETRES);
        let thin = "fill=\"none\" stroke=\"#555\" stroke-width=\"0.35\"";
        match cam.face() {
            Some([a, b]) => {
                let _ = writeln!(text, "<path {thin} d=\"M{:.4} {:.4}L{:.4} {:.4}\"/>", a.re, -a.im, b.re, -b.im);
            }
            None => {
                let _ = writeln!(text, "<circle cx=\"{:.4}\" cy=\"{:.4}\" r=\"{radius:.4}\" {thin}/>", p.re, -p.im);
            }
        }
        if let Some(pivot) = cam.pivot() {
            let _ = writeln!(text, "<path {thin} d=\"M{:.4} {:.4}L{:.4} {:.4}\"/>", pivot.re, -pivot.im, p.re, -p.im);
            let _ = writeln!(text, "<circle cx=\"{:.4}\" cy=\"{:.4}\" r=\"1.5\" {thin}/>", pivot.re, -pivot.im);
        }
        if !cam.name.is_empty() {
            let place = label(cam, drawn, letter, &labels);
            labels.push(place);
            let (x, y) = (place.re, -place.im + 0.35 * letter);
            let _ = writeln!(text, "<text x=\"{x:.4}\" y=\"{y:.4}\" text-anchor=\"middle\">{}</text>", cam.name);
        }
    }
    let (x, y) = (left + room, top + height - room);
    let _ = writeln!(text, "<text x=\"{x:.3}\" y=\"{y:.3}\">{}</text>", escaped(&words));
    text + "<path stroke=\"#000\" stroke-width=\"0.3\" d=\"M-4 0H4M0 -4V4\"/>\n</svg>\n"
}

/// Directions in which a place for a letter is looked for.
const DIRECTIONS: u32 = 24;

/// The least distance of a letter's middle from any line, and from other letters, as parts of its height.
const CLEAR: [f64; 2] = [0.75, 1.5];

/// The middle of a cam's letter (mm): in or next to its roller, the nearest place to the roller's centre that is clear of all lines
/// of the drawing, or the clearest one.
fn label(cam: &Drawn<'_>, drawn: &[Drawn<'_>], letter: f64, others: &[Point]) -> Point {
    let (roller, radius) = (cam.roller(), cam.cam.roller * MILLIMETRES);
    let lines: Vec<Vec<Point>> = drawn
        .iter()
        .flat_map(|d| d.curves().map(|side| d.points(side).chain(d.points(side).take(1)).collect()))
        .chain(drawn.iter().filter_map(|d| Some(vec![d.pivot()?, d.roller()])))
        .collect();
    let to_segment = |p: Point, a: Point, b: Point| {
        let (along, from) = (b - a, p - a);
        let part = if along.norm_sqr() > 0.0 { (along.conj() * from).re / along.norm_sqr() } else { 0.0 };
        (from - along * part.clamp(0.0, 1.0)).norm()
    };
    let clearance = |p: Point| {
        let to_lines = lines.iter().flat_map(|line| line.windows(2).map(|ends| to_segment(p, ends[0], ends[1])));
        let to_rollers = drawn.iter().map(|d| ((p - d.roller()).norm() - d.cam.roller * MILLIMETRES).abs());
        let to_others = others.iter().map(|other| (p - other).norm() * CLEAR[0] / CLEAR[1]);
        to_lines.chain(to_rollers).chain(to_others).fold(f64::INFINITY, f64::min)
    };
    let rings = (2.0 * (radius + 3.0 * letter) / letter).ceil() as u32;
    let mut best = (roller, 0.0);
    for ring in 1..=rings {
        for direction in 0..DIRECTIONS {
            let place = roller
                + Point::from_polar(0.5 * letter * f64::from(ring), TAU * f64::from(direction) / f64::from(DIRECTIONS));
            let clear = clearance(place);
            if clear > best.1 {
                best = (place, clear);
            }
        }
        if best.1 >= CLEAR[0] * letter {
            break;
        }
    }
    best.0
}

/// A cam as CSV: one line for each of its angles, with the centre of roller or cutter also in polar coordinates r(β) of the cam.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn csv(drawn: &Drawn<'_>) -> Result<String, Fault> {
    let lever = matches!(drawn.cam.follower, Follower::Lever { .. });
    let lift = if drawn.angular { "lift_deg" } else { "lift_mm" };
    let coordinate = if lever { "lever_deg" } else { "height_mm" };
    let flat = drawn.face().is_some();
    let contact = if flat { "contact_x_mm" } else { "pressure_angle_deg" };
    let mut head = format!(
        "phi_deg,{lift},{coordinate},centre_x_mm,centre_y_mm,centre_r_mm,centre_beta_deg,{contact},curvature_1_m"
    );
    for side in drawn.sides {
        head += match side {
            Side::Inner => ",inner_x_mm,inner_y_mm,inner_curvature_1_m",
            _ => ",outer_x_mm,outer_y_mm,outer_curvature_1_m",
        };
    }
    // As in the diagram: positive where a curve bulges away from the cam's axis.
    let bulge = -drawn.cam.sense;
    let row = |at: &At| {
        let mut cells = vec![
            at.phi.to_degrees(),
            if drawn.angular { at.lift.to_degrees() } else { MILLIMETRES * at.lift },
            if lever { at.coordinate.to_degrees() } else { MILLIMETRES * at.coordinate },
            MILLIMETRES * at.centre.re,
            MILLIMETRES * at.centre.im,
            MILLIMETRES * at.centre.norm(),
            at.centre.arg().to_degrees(),
            if flat { MILLIMETRES * at.place.re } else { at.pressure.to_degrees() },
            bulge * at.curvature,
        ];
        for side in drawn.sides {
            let point = side.point(drawn.cam, at) * MILLIMETRES;
            cells.extend([point.re, point.im, bulge * side.curvature(drawn.cam, at)]);
        }
        cells
    };
    text::csv(&head, drawn.mesh.at.iter().map(row))
}
