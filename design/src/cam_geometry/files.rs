//! Files for the workshop: contours as CSV, DXF and SVG, in mm, in the frame of the cam, which is the machine's at φ = 0.

use super::{Cam, CamPosition, Follower, Mesh, Point, Side};
use crate::drawing::{Anchor, BLACK, Drawing, Ink, Shape, Unit, WHITE, arc};
use crate::plot::LETTER;
use crate::text;
use camdrive::drives::Fault;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write as _;

/// The unit of lengths in files for workshops.
const MILLIMETRES: f64 = 1e3;

/// A cam of the drawing.
pub struct CamDrawing<'a> {
    /// "F" and "P" of a conjugate pair, empty for a single cam.
    pub name: &'static str,
    /// The cam.
    pub cam: &'a Cam,
    /// Its angles.
    pub mesh: &'a Mesh,
    /// Its contours.
    pub sides: &'static [Side],
    /// True if its law is an angle.
    pub angular: bool,
    /// The radius of shaft and hub (m); 0 if the scene has none.
    pub hub: f64,
}

impl CamDrawing<'_> {
    /// The path of the centre of roller or cutter, if any, and the contours.
    fn curves(&self) -> impl Iterator<Item = Side> {
        (self.cam.roller > 0.0).then_some(Side::Path).into_iter().chain(self.sides.iter().copied())
    }

    /// A flat face at φ = 0, as wide as necessary (mm).
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

    /// The least and the largest distance of the contours from the cam's centre (mm).
    fn radii(&self) -> [f64; 2] {
        let radii = self.sides.iter().flat_map(|side| self.points(*side)).map(Point::norm);
        radii.fold([f64::INFINITY, 0.0], |[least, most], r| [least.min(r), most.max(r)])
    }

    /// The radius of the roller (mm), 0 without a roller.
    fn roller_radius(&self) -> f64 {
        if self.face().is_some() { 0.0 } else { self.cam.roller * MILLIMETRES }
    }

    /// The direction from the cam's centre to the mark of φ (rad): it points at the roller of the first cam when the cam has
    /// turned by φ.
    fn mark(&self, phi: f64) -> Point {
        let start = self.roller();
        Point::from_polar(1.0, start.arg() - self.cam.sense * phi)
    }

    /// The principal dimensions (mm).
    fn dimensions(&self) -> String {
        let [least, most] = self.radii();
        let roller = match self.cam.follower {
            Follower::Flat { .. } => "flat face".to_owned(),
            _ => format!("roller Ø {}", hundredths(2.0 * self.cam.roller * MILLIMETRES)),
        };
        let place = match self.cam.follower {
            Follower::Lever { pivot, length, .. } => {
                let [pivot, length] = [pivot, length].map(|x| hundredths(x.abs() * MILLIMETRES));
                format!(", centre distance {pivot}, arm {length}")
            }
            Follower::Translating { eccentricity: e, .. } => format!(", offset {}", hundredths(e * MILLIMETRES)),
            Follower::Flat { .. } => String::new(),
        };
        let lifts = || self.mesh.at.iter().map(|at| at.lift);
        let stroke = lifts().fold(f64::NEG_INFINITY, f64::max) - lifts().fold(f64::INFINITY, f64::min);
        let stroke = if self.angular {
            format!("{}°", hundredths(stroke.to_degrees()))
        } else {
            hundredths(stroke * MILLIMETRES)
        };
        let hub = if self.hub > 0.0 {
            format!(", hub Ø {}", hundredths(2.0 * self.hub * MILLIMETRES))
        } else {
            String::new()
        };
        let name = if self.name.is_empty() { String::new() } else { format!("{}: ", self.name) };
        let [least, most] = [2.0 * least, most].map(hundredths);
        format!("{name}base circle Ø {least}, largest radius {most}, {roller}{place}, stroke of the law {stroke}{hub}")
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

/// A number to hundredths at most.
fn hundredths(value: f64) -> String {
    ((100.0 * value).round() / 100.0 + 0.0).to_string()
}

/// A length (mm) to a tenth of a nanometre; a zero has no sign.
fn decimal(length: f64) -> String {
    let text = format!("{length:.7}");
    if text.trim_start_matches(['-', '0', '.']).is_empty() { "0.0".to_owned() } else { text }
}

/// The layers as an ASCII DXF (AutoCAD R12, which every CAD program reads), in mm: contours and roller paths as closed
/// polylines, the rollers at φ = 0, base circles and hub as circles, the cam's centre and the lever's pivot as points, marks of φ.
pub fn dxf(title: &str, drawn: &[CamDrawing<'_>]) -> String {
    // Group codes: 999 comment, 0 entity, 2 name, 8 layer, 66 vertices follow, 70 flags (1: closed), 10/20/30 coordinates,
    // 11/21/31 second end, 40 radius or height of letters, 1 text; $INSUNITS 4 and $MEASUREMENT 1 are millimetres and metric.
    let mut text = format!("999\n{}: camdrive, lengths in mm\n", title.replace(['\n', '\r'], " "));
    text += "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n4\n9\n$MEASUREMENT\n70\n1\n0\nENDSEC\n";
    let mut layers: Vec<String> = Vec::new();
    let mut entities = String::new();
    let mut entity = |kind: &str, layer: &str, groups: &[(u8, String)]| {
        if !layers.iter().any(|known| known == layer) {
            layers.push(layer.to_owned());
        }
        let groups: String = groups.iter().map(|(code, value)| format!("{code}\n{value}\n")).collect();
        let _ = write!(entities, "0\n{kind}\n8\n{layer}\n{groups}");
    };
    let at = |p: Point| [(10, decimal(p.re)), (20, decimal(p.im)), (30, "0.0".to_owned())];
    let to = |p: Point| [(11, decimal(p.re)), (21, decimal(p.im)), (31, "0.0".to_owned())];
    let size = |length: f64| [(40, decimal(length))];
    let origin = Point::from(0.0);
    for cam in drawn {
        for side in cam.curves() {
            let layer = cam.layer(cam.layer_of(side));
            let flags = [(66, "1".to_owned()), (70, "1".to_owned())];
            entity("POLYLINE", &layer, &[&flags[..], &at(origin)].concat());
            cam.points(side).for_each(|p| entity("VERTEX", &layer, &at(p)));
            entity("SEQEND", &layer, &[]);
        }
        match cam.face() {
            Some([a, b]) => entity("LINE", &cam.layer("FACE"), &[at(a), to(b)].concat()),
            None => {
                let radius = size(cam.cam.roller * MILLIMETRES);
                entity("CIRCLE", &cam.layer("ROLLER"), &[&at(cam.roller())[..], &radius].concat());
            }
        }
        entity("CIRCLE", &cam.layer("BASE_CIRCLE"), &[&at(origin)[..], &size(cam.radii()[0])].concat());
    }
    if let Some(first) = drawn.first() {
        entity("POINT", "CENTRE", &at(origin));
        first.pivot().into_iter().for_each(|pivot| entity("POINT", "PIVOT", &at(pivot)));
        if first.hub > 0.0 {
            entity("CIRCLE", "HUB", &[&at(origin)[..], &size(first.hub * MILLIMETRES)].concat());
        }
        let radius = drawn.iter().flat_map(|cam| cam.curves().flat_map(|side| cam.points(side))).map(Point::norm);
        let radius = radius.fold(0.0, f64::max);
        for degrees in (0..360_u16).step_by(30) {
            let mark = first.mark(f64::from(degrees).to_radians());
            entity("LINE", "ANGLES", &[at(mark * radius), to(mark * 1.05 * radius)].concat());
            let text = [(40, decimal(0.03 * radius)), (1, degrees.to_string())];
            entity("TEXT", "ANGLES", &[&at(mark * 1.07 * radius)[..], &text].concat());
        }
    }
    let _ = write!(text, "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n{}\n", layers.len());
    for layer in layers {
        // Colour 7, black or white; the layers distinguish the contours.
        let _ = write!(text, "0\nLAYER\n2\n{layer}\n70\n0\n62\n7\n6\nCONTINUOUS\n");
    }
    text + "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" + &entities + "0\nENDSEC\n0\nEOF\n"
}

/// Room around the drawing (mm).
const ROOM: f64 = 5.0;

/// The height of letters: at least (mm), and of the largest radius.
const LETTERS: [f64; 2] = [3.0, 0.045];

/// Lines that are no edges of the part, and the dashes of centre lines, hidden edges and the base circle.
const GREY: Ink = Ink([0x55; 3]);
const CENTRE: &[f64] = &[4.0, 1.0, 0.5, 1.0];
const HIDDEN: &[f64] = &[6.0, 1.5];
const BASE: &[f64] = &[1.0, 1.0];

/// Parts of the drawing in the frame of the cam (mm), y up.
struct Sheet {
    shapes: Vec<Shape>,
    /// The height of letters.
    letter: f64,
}

impl Sheet {
    fn line(&mut self, points: impl IntoIterator<Item = Point>, width: f64, ink: Ink, dash: &'static [f64]) {
        self.shapes.push(Shape::Line { points: points.into_iter().map(down).collect(), width, ink, dash });
    }

    fn circle(&mut self, middle: Point, radius: f64, dash: &'static [f64]) {
        self.shapes.push(Shape::Line { points: arc(down(middle), radius, [0.0, TAU]), width: 0.35, ink: GREY, dash });
    }

    /// Words about a place, on white where lines may run.
    fn words(&mut self, at: Point, text: &str) {
        let (high, long) = (0.6 * self.letter, 0.5 * LETTER * self.letter * text.chars().count() as f64);
        let corners = [(-long, -high), (long, -high), (long, high), (-long, high)];
        let points = corners.map(|(x, y)| down(at + Point::new(x, y))).into();
        self.shapes.push(Shape::Area { points, ink: WHITE });
        let at = down(at - Point::new(0.0, 0.36 * self.letter));
        self.shapes.push(Shape::text(at, self.letter, Anchor::Middle, text));
    }

    /// The head of an arrow with its tip at `tip`.
    fn head(&mut self, tip: Point, direction: Point) {
        let back = direction / direction.norm() * self.letter;
        let ends = [tip, tip - back * Point::new(1.0, 0.25), tip - back * Point::new(1.0, -0.25)];
        self.shapes.push(Shape::Area { points: ends.map(down).into(), ink: BLACK });
    }

    /// Contours, roller, lever and largest radius of the cam with this number.
    fn cam(&mut self, number: usize, cam: &CamDrawing<'_>) {
        let origin = Point::from(0.0);
        for side in cam.curves() {
            let closed = cam.points(side).chain(cam.points(side).take(1));
            match side {
                Side::Path => self.line(closed, 0.3, GREY, CENTRE),
                _ => self.line(closed, 0.7, BLACK, if number == 0 { &[] } else { HIDDEN }),
            }
        }
        let [least, most] = cam.radii();
        self.circle(origin, least, BASE);
        match cam.face() {
            Some(face) => self.line(face, 0.35, GREY, &[]),
            None => self.circle(cam.roller(), cam.roller_radius(), &[]),
        }
        if let Some(pivot) = cam.pivot() {
            self.line([origin, pivot], 0.25, GREY, CENTRE);
            self.line([pivot, cam.roller()], 0.35, GREY, &[]);
            self.circle(pivot, 1.5, &[]);
        }
        let named = |what: String| if cam.name.is_empty() { what } else { format!("{} {what}", cam.name) };
        let far = cam.sides.iter().flat_map(|side| cam.points(*side)).max_by(|a, b| a.norm().total_cmp(&b.norm()));
        if let Some(far) = far {
            self.line([origin, far], 0.25, BLACK, &[]);
            self.head(far, far);
            self.words(far * 0.75, &named(format!("R {}", hundredths(most))));
        }
        // Away from the rollers and from the largest radius, the second one next to the first.
        let away = cam.mark(0.0).arg() + 0.5 * TAU + 0.6 * number as f64;
        let is_beside = far.is_some_and(|far| (far / Point::from_polar(1.0, away)).arg().abs() < 0.6);
        let below = Point::from_polar(least, if is_beside { away + 1.2 } else { away });
        self.words(below, &named(format!("Ø {}", hundredths(2.0 * least))));
        if !cam.name.is_empty() {
            self.words(cam.roller(), cam.name);
        }
    }

    /// The angles φ on a ring of this radius.
    fn scale(&mut self, cam: &CamDrawing<'_>, ring: f64) {
        let letter = self.letter;
        for degrees in (0..360_u16).step_by(10) {
            let mark = cam.mark(f64::from(degrees).to_radians());
            let is_named = degrees.is_multiple_of(30);
            let long = if is_named { 1.0 } else { 0.5 } * letter;
            self.line([mark * ring, mark * (ring + long)], 0.3, BLACK, &[]);
            if is_named {
                self.words(mark * (ring + 2.2 * letter), &format!("{degrees}°"));
            }
        }
    }

    /// Hub and sense of rotation, an arrow between the hub and the least radius.
    fn rotation(&mut self, cam: &CamDrawing<'_>, least: f64) {
        let hub = cam.hub * MILLIMETRES;
        if hub > 0.0 {
            self.circle(Point::from(0.0), hub, &[]);
        }
        let radius = hub + 0.5 * (least - hub);
        let sense = cam.cam.sense;
        let ends = [0.5, 1.3].map(|way| cam.mark(0.0).arg() + sense * (FRAC_PI_2 + way - 0.9));
        let (points, tip) = (arc([0.0; 2], radius, ends), Point::from_polar(radius, ends[1]));
        self.shapes.push(Shape::line(points, 0.5, BLACK));
        self.head(tip, Point::new(0.0, sense) * tip);
    }

    /// The drawing between two corners, with notes below.
    fn framed(mut self, notes: &[String], low: Point, high: Point) -> Drawing {
        let letter = self.letter;
        let across = ((high.re - low.re - 2.0 * ROOM) / (LETTER * letter)) as usize;
        let lines: Vec<String> = notes
            .iter()
            .flat_map(|note| text::wrapped(note, across).lines().map(str::to_owned).collect::<Vec<_>>())
            .collect();
        let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
        let width = (high.re - low.re).max(LETTER * letter * longest as f64 + 2.0 * ROOM);
        let height = high.im - low.im + 1.5 * letter * lines.len() as f64 + 2.0 * ROOM;
        for (i, line) in lines.into_iter().enumerate() {
            let at = Point::new(low.re + ROOM, low.im - 1.5 * letter * (i + 1) as f64);
            self.shapes.push(Shape::text(down(at), letter, Anchor::Start, line));
        }
        let shapes = self.shapes.into_iter().map(|shape| shape.moved([-low.re, high.im])).collect();
        Drawing { size: [width, height], unit: Unit::Millimetre, shapes }
    }
}

fn down(p: Point) -> [f64; 2] {
    [p.re, -p.im]
}

/// The cam as a drawing in its true size, readable without colours: contours thick (the second cam's dashed); path of the
/// roller's centre, base circle, hub and centre lines thin; roller and lever at φ = 0, largest radius, sense of rotation.
/// Around it the angles φ at which a mark points at the first roller.
pub fn drawing(title: &str, drawn: &[CamDrawing<'_>]) -> Drawing {
    let curves = || drawn.iter().flat_map(|cam| cam.curves().flat_map(|side| cam.points(side)));
    let largest = curves().map(Point::norm).fold(0.0, f64::max);
    let mut sheet = Sheet { shapes: Vec::new(), letter: LETTERS[0].max(LETTERS[1] * largest) };
    // The marks lie beyond the rollers.
    let ring = largest + drawn.iter().map(CamDrawing::roller_radius).fold(0.0, f64::max) + 0.5 * sheet.letter;
    for (x, y) in [(ring, 0.0), (0.0, ring)] {
        sheet.line([Point::new(-x, -y), Point::new(x, y)], 0.25, GREY, CENTRE);
    }
    for (i, cam) in drawn.iter().enumerate() {
        sheet.cam(i, cam);
    }
    let mut notes = vec![format!("Cam of {title}")];
    if let Some(first) = drawn.first() {
        sheet.scale(first, ring);
        let least = drawn.iter().map(|cam| cam.radii()[0]).fold(f64::INFINITY, f64::min);
        sheet.rotation(first, least);
        let turns = if first.cam.sense > 0.0 { "counter-clockwise" } else { "clockwise" };
        notes.push(format!("Drawn at φ = 0, the cam turns {turns}; lengths in mm"));
    }
    notes.extend(drawn.iter().map(CamDrawing::dimensions));
    let (mut low, mut high) = (Point::new(-ring, -ring), Point::new(ring, ring));
    low -= Point::new(4.0, 4.0) * sheet.letter;
    high += Point::new(4.0, 4.0) * sheet.letter;
    let far = drawn.iter().flat_map(|cam| cam.pivot().into_iter().chain(cam.face().into_iter().flatten()));
    for p in far {
        low = Point::new(low.re.min(p.re - ROOM), low.im.min(p.im));
        high = Point::new(high.re.max(p.re + ROOM), high.im.max(p.im));
    }
    sheet.framed(&notes, low, high)
}

/// A cam as CSV: one line for each of its angles, with the centre of roller or cutter also in polar coordinates r(β) of the cam.
///
/// # Errors
/// None in practice: the writer fills memory.
pub fn csv(drawn: &CamDrawing<'_>) -> Result<String, Fault> {
    let lever = matches!(drawn.cam.follower, Follower::Lever { .. });
    let lift = if drawn.angular { "lift_deg" } else { "lift_mm" };
    let coordinate = if lever { "lever_deg" } else { "height_mm" };
    let flat = drawn.face().is_some();
    let contact = if flat { "contact_x_mm" } else { "pressure_angle_deg" };
    let mut head = format!(
        "phi_deg,{lift},{coordinate},centre_x_mm,centre_y_mm,centre_r_mm,centre_beta_deg,{contact},curvature_1_per_mm"
    );
    for side in drawn.sides {
        head += match side {
            Side::Inner => ",inner_x_mm,inner_y_mm,inner_curvature_1_per_mm",
            _ => ",outer_x_mm,outer_y_mm,outer_curvature_1_per_mm",
        };
    }
    // As in the diagram: positive where a curve bulges away from the cam's axis.
    let bulge = -drawn.cam.sense;
    let row = |at: &CamPosition| -> Vec<String> {
        let mut cells = vec![
            at.phi.to_degrees(),
            if drawn.angular { at.lift.to_degrees() } else { MILLIMETRES * at.lift },
            if lever { at.coordinate.to_degrees() } else { MILLIMETRES * at.coordinate },
            MILLIMETRES * at.centre.re,
            MILLIMETRES * at.centre.im,
            MILLIMETRES * at.centre.norm(),
            at.centre.arg().to_degrees(),
            if flat { MILLIMETRES * at.place.re } else { at.pressure.to_degrees() },
            bulge * at.curvature / MILLIMETRES,
        ];
        for side in drawn.sides {
            let point = side.point(drawn.cam, at) * MILLIMETRES;
            cells.extend([point.re, point.im, bulge * side.curvature(drawn.cam, at) / MILLIMETRES]);
        }
        // Values of rounding size are 0: these are mm, ° and 1/mm, and 1e-12 is below the last digit of a cam of 1 m.
        cells.into_iter().map(|cell: f64| format!("{:?}", if cell.abs() < 1e-12 { 0.0 } else { cell })).collect()
    };
    let head = head.split(',').map(str::to_owned).collect();
    text::csv(std::iter::once(head).chain(drawn.mesh.at.iter().map(row)))
}
