//! Diagrams of points and lines as SVG: legible in print without colour, since series differ in marker and dashes.
//!
//! All diagrams of the tool come from here, so that they look alike.

mod area;
mod legend;
mod look;
pub mod map;
mod rule;
mod suited;
pub mod ticks;

use crate::drawing::{Anchor, BLACK, Drawing, Frame, Ink, Point, Shape, Unit, WHITE};
use crate::text;
use look::{DASHED, Look, RULED, look, marked};
use map::{BAR, Map};
use ticks::{angular_step, decimal, decimal_step, logarithmic_ticks};

/// The division of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences.
    Linear,
    /// Equal ratios; values must be positive.
    Logarithmic,
    /// Equal differences of angles in degrees, with ticks at parts of the turn.
    Angular,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and coherent SI unit, for example "Communication step (s)"; the diagram shows a unit that suits the values.
    pub label: String,
    /// The scale.
    pub scale: Scale,
    /// Its ends; None where they follow from the data.
    pub ends: Option<[f64; 2]>,
}

/// Points that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// For the legend.
    pub name: String,
    /// (x, y); a point that is not finite has no marker and interrupts the line.
    pub points: Vec<[f64; 2]>,
    /// True if a line joins the points.
    pub joined: bool,
}

impl Series {
    /// Points joined by a line.
    pub fn line(name: impl Into<String>, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Series { name: name.into(), points: points.into_iter().collect(), joined: true }
    }

    /// Points alone.
    pub fn dots(name: impl Into<String>, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Series { joined: false, ..Series::line(name, points) }
    }

    /// The lines between points that have no place, or each point for itself.
    pub fn lines(&self, place: impl Fn(&Point) -> Option<Point>) -> Vec<Vec<Point>> {
        let of = |part: &[Point]| part.iter().filter_map(&place).collect::<Vec<_>>();
        if self.joined {
            self.points.split(|point| place(point).is_none()).filter(|part| !part.is_empty()).map(of).collect()
        } else {
            of(&self.points).into_iter().map(|point| vec![point]).collect()
        }
    }
}

/// Background of the data: a straight line across the diagram, or an area.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// A line at this x, its name above the plot where that has room.
    Vertical(f64, String),
    /// A line at this y; where the data would be squeezed by it, its name and value at the end of the axis.
    Horizontal(f64, String),
    /// A grey area within this outline, as far as the axes show it; the axes do not stretch for it.
    Area(Vec<[f64; 2]>, Shade),
    /// A line along these points of this thickness in pixels, as far as the axes show it; they do not stretch for it.
    Border(Vec<[f64; 2]>, f64),
    /// A dashed line along these points likewise; the legend has its name, unless that is empty.
    Dashed(Vec<[f64; 2]>, String),
    /// A word above this point.
    Word([f64; 2], String),
    /// Meaning of a shade, or without one of lines that have no name, for the legend.
    Key(Option<Shade>, String),
}

/// The grey of an area.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shade {
    /// Next to white.
    Pale,
    /// Clearly darker, and still lighter than any line.
    Dark,
}

impl Shade {
    fn ink(self) -> Ink {
        Ink([if self == Shade::Pale { 0xec } else { 0xc4 }; 3])
    }
}

/// A diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram {
    /// Its title.
    pub title: String,
    /// The abscissa.
    pub x: Axis,
    /// The ordinate.
    pub y: Axis,
    /// The data, at most as many as there are `look::MARKERS` to distinguish them.
    pub series: Vec<Series>,
    /// Borders and limits.
    pub rules: Vec<Rule>,
    /// Behind all of them.
    pub map: Option<Map>,
}

/// A diagram as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Its shapes.
    pub drawing: Drawing,
    /// The plot in pixels, and what its axes span: values in the units of `shown`, powers of ten on a logarithmic axis.
    pub frame: Frame,
    /// The diagram in the units that the picture has.
    pub shown: Diagram,
}

/// Width of a diagram, and its height with the legend within the axes, below the title.
const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 300.0;
/// Room for the numbers and the name of an axis: left of the plot and below it; right of it and above, for what reaches beyond.
const LEFT: f64 = 84.0;
const BELOW: f64 = 52.0;
const RIGHT: f64 = 24.0;
const ABOVE: f64 = 14.0;
/// The widths of letters differ; this is the mean of a sans-serif font, per height. The middle of a capital is at this height.
pub const LETTER: f64 = 0.54;
const MIDDLE: f64 = 0.36;
/// Height of letters.
pub const TEXT: f64 = 10.5;
const TITLE: f64 = 13.0;
/// That of a page of text, a browser's default, of a diagram's letters.
pub const PAGE: f64 = 16.0 / TEXT;
const LINE: f64 = 20.0;
/// Length of the marks of an axis.
const TICK: f64 = 5.0;
const GRID: Ink = Ink([0xdd; 3]);
/// The grid at zero.
const ZERO: Ink = Ink([0x99; 3]);
/// A level rule or a border stretches the axis to this times what the data need, at most.
const STRETCHED: f64 = 3.0;

impl Axis {
    /// A logarithmic axis.
    pub fn logarithmic(label: &str) -> Self {
        Axis { label: label.to_owned(), scale: Scale::Logarithmic, ends: None }
    }

    /// A linear axis.
    pub fn linear(label: &str) -> Self {
        Axis { label: label.to_owned(), scale: Scale::Linear, ends: None }
    }

    /// A linear axis of angles in degrees.
    pub fn angular(label: &str) -> Self {
        Axis { label: label.to_owned(), scale: Scale::Angular, ends: None }
    }

    /// The axis from `low` to `high`, whatever the data are.
    pub fn between(self, low: f64, high: f64) -> Self {
        Axis { ends: Some([low, high]), ..self }
    }

    /// The unit of its label as it follows a number.
    fn unit(&self) -> String {
        match self.label.strip_suffix(']').and_then(|label| label.rsplit_once('[')) {
            Some((_, "°")) => "°".to_owned(),
            Some((_, unit)) if unit != "1" => format!(" {unit}"),
            _ => String::new(),
        }
    }

    /// The place of a value on the axis; None off the scale.
    pub fn place(&self, value: f64) -> Option<f64> {
        match self.scale {
            Scale::Linear | Scale::Angular => value.is_finite().then_some(value),
            Scale::Logarithmic => (value > 0.0 && value.is_finite()).then(|| value.log10()),
        }
    }

    /// The ends of the axis for these places of data, and for those of rules as far as they stretch it no more than so many times.
    fn span(&self, data: impl Iterator<Item = f64>, rules: impl Iterator<Item = f64>, most: f64) -> [f64; 2] {
        if let Some([Some(low), Some(high)]) = self.ends.map(|ends| ends.map(|end| self.place(end))) {
            return [low, high];
        }
        let wide = |[low, high]: [f64; 2], place: f64| [low.min(place), high.max(place)];
        let own = data.fold([f64::INFINITY, f64::NEG_INFINITY], wide);
        let most = if own[0] < own[1] { most * (own[1] - own[0]) } else { f64::INFINITY };
        let [low, high] = rules
            .map(|place| wide(own, place))
            .filter(|[low, high]| high - low <= most)
            .fold(own, |ends, stretched| stretched.into_iter().fold(ends, wide));
        if low > high {
            return [0.0, 1.0];
        }
        let least = if self.scale == Scale::Logarithmic { 0.5 } else { 1e-9 + 1e-3 * low.abs() };
        if self.scale == Scale::Angular && high - low > least {
            return [low, high];
        }
        // Room for the markers, and for a constant.
        let room = 0.06 * (high - low).max(least) + 0.5 * (least - (high - low)).max(0.0);
        [low - room, high + room]
    }

    /// Places and labels of the ticks.
    fn ticks(&self, [low, high]: [f64; 2]) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear | Scale::Angular => {
                let parts = self.scale == Scale::Angular;
                let step = if parts { angular_step(high - low) } else { decimal_step(high - low) };
                // A millionth of a step makes up for the rounding of the ends.
                let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
                (first..=last).map(|i| i as f64 * step).map(|v| (v, decimal(v, step))).collect()
            }
            Scale::Logarithmic => logarithmic_ticks(low, high),
        }
    }
}

impl Diagram {
    /// A diagram of these data over two axes.
    pub fn new(title: impl Into<String>, [x, y]: [Axis; 2], series: Vec<Series>, rules: Vec<Rule>) -> Self {
        Diagram { title: title.into(), x, y, series, rules, map: None }
    }

    /// The diagram as an SVG document.
    pub fn svg(&self) -> String {
        self.picture().drawing.svg(&self.title, 1.0)
    }

    /// The entries of the legend beside those of the data; without shade that of a line of this look.
    fn keys(&self) -> impl Iterator<Item = (Option<Shade>, Look, &String)> {
        self.rules.iter().filter_map(|rule| match rule {
            Rule::Key(shade, name) => Some((*shade, RULED, name)),
            Rule::Dashed(_, name) if !name.is_empty() => Some((None, DASHED, name)),
            _ => None,
        })
    }

    /// Title, plot and legend: within the axes where the data leave room, else in columns below the plot.
    pub fn picture(&self) -> Picture {
        let shown = self.suited();
        let title = text::wrapped(&self.title, ((WIDTH - 24.0) / (LETTER * TITLE)) as usize);
        let top = if title.is_empty() { 0.0 } else { LINE * title.lines().count() as f64 + 8.0 };
        let line = |(i, line): (usize, &str)| {
            Shape::text([12.0, 24.0 + LINE * i as f64], TITLE, Anchor::Start, line.trim_start())
        };
        let mut shapes: Vec<Shape> = title.lines().enumerate().map(line).collect();
        let right = WIDTH - RIGHT - self.map.as_ref().map_or(0.0, |_| BAR);
        let ends = [[LEFT, right], [top + HEIGHT - BELOW, top + ABOVE]];
        let (frame, [grid, data]) = shown.plot(ends);
        shown.draw_names(&mut shapes, ends);
        shapes.extend(shown.map.iter().flat_map(|map| map.bar(ends)));
        let mut size = [WIDTH, top + HEIGHT];
        let names = self.series.iter().map(|series| &series.name).chain(self.keys().map(|(.., name)| name));
        let names: Vec<&String> = names.collect();
        let longest = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        // Curves without a name need no legend, nor does a single one that the title names.
        let is_told = names.len() == 1 && self.title.to_lowercase().contains(&names[0].to_lowercase());
        let entries = if longest > 0 && !is_told { names.len() } else { 0 };
        let wide = 64.0 + (LETTER * TEXT * longest as f64).floor();
        let own = [wide, LINE * entries as f64 + 8.0];
        let within = legend::free_place(own, ends, &data).filter(|_| entries > 0);
        shapes.extend(grid.into_iter().chain(data));
        if let Some([x, y]) = within {
            let [w, h] = own;
            shapes.push(Shape::Area { points: vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]], ink: WHITE });
            shown.draw_legend(&mut shapes, [x, y], entries, wide);
        } else if entries > 0 {
            let columns = ((WIDTH / wide) as usize).max(1);
            let rows = entries.div_ceil(columns);
            shown.draw_legend(&mut shapes, [6.0, size[1]], rows, wide);
            size = [size[0].max(wide), size[1] + LINE * rows as f64 + 12.0];
        }
        shapes.push(framed(ends));
        Picture { drawing: Drawing { size, unit: Unit::Pixel, shapes }, frame, shown }
    }

    /// Grid with numbers, and rules with data, between these left and right, bottom and top ends, in the units of the diagram.
    pub fn plot(&self, ends: [[f64; 2]; 2]) -> (Frame, [Vec<Shape>; 2]) {
        let place = |[x, y]: &Point| Some([self.x.place(*x)?, self.y.place(*y)?]);
        let places: Vec<Point> = self.series.iter().flat_map(|series| series.points.iter().filter_map(place)).collect();
        let rule = |rule: &Rule| match rule {
            Rule::Vertical(x, _) => [self.x.place(*x), None],
            Rule::Horizontal(y, _) => [None, self.y.place(*y)],
            _ => [None, None],
        };
        let ruled: Vec<rule::Place> = self.rules.iter().map(rule).collect();
        let axes = [&self.x, &self.y];
        let borders =
            self.rules.iter().flat_map(|rule| if let Rule::Border(points, _) = rule { &points[..] } else { &[] });
        let across: Vec<f64> = ruled.iter().filter_map(|r| r[0]).collect();
        let up = borders.filter_map(|point| self.y.place(point[1])).chain(ruled.iter().filter_map(|r| r[1])).collect();
        let [x, y] = [(0, across, f64::INFINITY), (1, up, STRETCHED)]
            .map(|(i, rules, most)| axes[i].span(places.iter().map(|p| p[i]), rules.into_iter(), most));
        let ranges = [x, y];
        let frame = Frame { ends, ranges };
        let mut shapes = self.map.as_ref().map_or(Vec::new(), |map| map.shapes(axes, &frame));
        let parts = |points: &[Point]| {
            let line: Vec<Point> = points.iter().filter_map(place).collect();
            area::seen(&line, ranges).into_iter().map(|part| all(&part, &frame)).collect::<Vec<_>>()
        };
        for rule in &self.rules {
            match rule {
                Rule::Border(points, width) => {
                    shapes.extend(parts(points).into_iter().map(|part| Shape::line(part, *width, BLACK)));
                }
                Rule::Dashed(points, _) => shapes.extend(parts(points).into_iter().map(|part| DASHED.line(part))),
                Rule::Word(at, word) => shapes.extend(place(at).map(|at| {
                    let [x, y] = frame.at(at);
                    Shape::text([x, y - 4.0], TEXT - 1.0, Anchor::Middle, word)
                })),
                Rule::Area(outline, shade) => {
                    let outline: Vec<Point> = outline.iter().filter_map(place).collect();
                    let points = all(&area::within(&outline, ranges), &frame);
                    shapes.push(Shape::Area { points, ink: shade.ink() });
                }
                Rule::Vertical(..) | Rule::Horizontal(..) | Rule::Key(..) => (),
            }
        }
        let rules: Vec<(&Rule, rule::Place)> = self.rules.iter().zip(ruled).collect();
        let lines: Vec<Vec<Vec<Point>>> =
            self.series.iter().map(|series| series.lines(|point| place(point).map(|at| frame.at(at)))).collect();
        rule::draw_rules(&mut shapes, &rules, (&frame, &self.y.unit()), lines.concat());
        for (i, (series, lines)) in self.series.iter().zip(lines).enumerate() {
            let markers = marked(&lines.concat(), series.joined, i, self.series.len() == 1);
            let joined = lines.into_iter().filter(|line| series.joined && line.len() > 1);
            shapes.extend(joined.map(|line| look(i).line(line)));
            shapes.extend(markers.into_iter().flat_map(|point| look(i).marker(point)));
        }
        (frame, [self.grid(&frame), shapes])
    }

    /// Grid and numbers of the axes.
    fn grid(&self, frame: &Frame) -> Vec<Shape> {
        let mut shapes = Vec::new();
        let [[left, right], [bottom, top]] = frame.ends;
        for (place, text) in self.x.ticks(frame.ranges[0]) {
            let [x, _] = frame.at([place; 2]);
            shapes.push(Shape::line(vec![[x, bottom], [x, top]], 1.0, GRID));
            shapes.push(Shape::line(vec![[x, bottom], [x, bottom + TICK]], 1.0, BLACK));
            shapes.push(Shape::text([x, bottom + TICK + TEXT], TEXT, Anchor::Middle, text));
        }
        for (place, text) in self.y.ticks(frame.ranges[1]) {
            let [_, y] = frame.at([place; 2]);
            let ink = if place == 0.0 && self.y.scale == Scale::Linear { ZERO } else { GRID };
            shapes.push(Shape::line(vec![[left, y], [right, y]], 1.0, ink));
            shapes.push(Shape::line(vec![[left - TICK, y], [left, y]], 1.0, BLACK));
            shapes.push(Shape::text([left - TICK - 4.0, y + MIDDLE * TEXT], TEXT, Anchor::End, text));
        }
        shapes
    }

    /// Names of the axes.
    fn draw_names(&self, shapes: &mut Vec<Shape>, ends: [[f64; 2]; 2]) {
        let x = 0.5 * (ends[0][0] + ends[0][1]);
        shapes.push(Shape::text([x, ends[1][0] + 42.0], TEXT + 1.0, Anchor::Middle, &self.x.label));
        shapes.extend(upright(&self.y.label, 26.0, ends[1]));
    }

    /// Draws the legend in rows and columns of this width, with this corner on its upper left.
    fn draw_legend(&self, shapes: &mut Vec<Shape>, corner: Point, rows: usize, wide: f64) {
        let series = self.series.iter().map(|series| (&series.name, Some(series), None, RULED));
        let entries = series.chain(self.keys().map(|(shade, look, name)| (name, None, shade, look)));
        for (i, (name, series, shade, ruled)) in entries.enumerate() {
            let (left, top) = (corner[0] + wide * (i / rows) as f64, corner[1] + LINE * (i % rows) as f64);
            let ([from, to], height) = ([left + 6.0, left + 42.0], top + 14.0);
            let line = vec![[from, height], [to, height]];
            match (series, shade) {
                (Some(series), _) => {
                    shapes.extend(series.joined.then(|| look(i).line(line)));
                    let has_marker = !marked(&series.points, series.joined, i, self.series.len() == 1).is_empty();
                    shapes.extend(look(i).marker([left + 24.0, height]).into_iter().filter(|_| has_marker));
                }
                (None, Some(shade)) => {
                    let (low, high) = (height - 6.0, height + 6.0);
                    let points = vec![[from, low], [to, low], [to, high], [from, high]];
                    shapes.push(Shape::Area { points, ink: shade.ink() });
                    shapes.push(framed([[from, to], [low, high]]));
                }
                (None, None) => shapes.push(ruled.line(line)),
            }
            shapes.push(Shape::text([left + 50.0, height + MIDDLE * TEXT], TEXT, Anchor::Start, name));
        }
    }
}

/// The name of an upright axis between these ends: one that is longer than its axis has more lines, lest it reaches the title.
fn upright(name: &str, x: f64, [bottom, top]: [f64; 2]) -> Vec<Shape> {
    let (size, anchor) = (TEXT + 1.0, Anchor::Middle);
    let lines = text::wrapped(name, ((bottom - top) / (LETTER * size)) as usize);
    let line = |(i, line): (usize, &str)| {
        let (at, text) = ([x - 14.0 * i as f64, 0.5 * (bottom + top)], line.trim_start().to_owned());
        Shape::Text { at, size, anchor, text, upright: true }
    };
    lines.lines().rev().enumerate().map(line).collect()
}

fn all(points: &[Point], frame: &Frame) -> Vec<Point> {
    points.iter().map(|point| frame.at(*point)).collect()
}

/// The outline of a rectangle.
fn framed([[left, right], [bottom, top]]: [[f64; 2]; 2]) -> Shape {
    Shape::line(vec![[left, top], [right, top], [right, bottom], [left, bottom], [left, top]], 1.0, BLACK)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_data_give_a_well_formed_picture() {
        let data = [
            vec![],
            vec![[1.0, 1.0]],
            vec![[0.0, -1.0], [f64::NAN, 1.0], [f64::INFINITY, 2.0]],
            vec![[1e-300, 1e300], [1e300, 1e-300]],
        ];
        for points in data {
            for axis in [Axis::linear("x [m]"), Axis::logarithmic("x [m]"), Axis::angular("x [deg]")] {
                let diagram = Diagram {
                    title: "\"<&".to_owned(),
                    x: axis.clone(),
                    y: axis,
                    series: vec![Series::line("a < b & c", points.clone()); 12],
                    rules: vec![
                        Rule::Vertical(0.0, "zero".into()),
                        Rule::Horizontal(1.0, "one".into()),
                        Rule::Area(vec![[1e-300, 1.0], [1e300, 1.0], [f64::NAN, 1.0], [1.0, 1e300]], Shade::Dark),
                        Rule::Area(Vec::new(), Shade::Pale),
                        Rule::Border(vec![[1.0, 1.0], [f64::NAN, 2.0], [3.0, 1e3]], 1.0),
                        Rule::Word([-1.0, f64::INFINITY], "<j>".into()),
                        Rule::Key(Some(Shade::Pale), "k & l".into()),
                        Rule::Key(None, "m < n".into()),
                        Rule::Dashed(vec![[1.0, 1.0], [f64::NAN, 2.0], [3.0, 1e3]], "o & p".into()),
                    ],
                    map: None,
                };
                let svg = diagram.svg();
                let mut reader = quick_xml::Reader::from_str(&svg);
                while !matches!(reader.read_event().unwrap(), quick_xml::events::Event::Eof) {}
                assert!(svg.contains("a &lt; b &amp; c") && svg.contains("aria-label"));
            }
        }
    }

    #[test]
    fn on_a_page_letters_have_the_height_of_its_text() {
        let name = "a setting of the solver whose name is so long that the legend is wider than the plot is, by far";
        let series = vec![Series::line(name, [[0.0, 1.0], [1.0, 2.0]]); 30];
        let diagram = Diagram::new("", ["x", "y"].map(Axis::linear), series, Vec::new());
        let svg = diagram.picture().drawing.svg("", PAGE);
        let number = |name: &str| -> Vec<f64> {
            let value = svg.split_once(&format!(" {name}=\"")).unwrap().1.split('"').next().unwrap();
            value.split(' ').map(|part| part.parse().unwrap()).collect()
        };
        let (width, height, coordinates) = (number("width")[0], number("height")[0], number("viewBox"));
        assert!((width / coordinates[2] - PAGE).abs() < 0.005);
        assert!((height / coordinates[3] - width / coordinates[2]).abs() < 1e-4);
        // 60 em less the margins of the page; the legend has room below the plot.
        assert!(width < 928.0 && height > 16.0 / 13.0 * (HEIGHT + 30.0 * LINE), "{width} × {height}");
        assert_eq!(svg.matches(name).count(), 30);
    }

    #[test]
    fn curves_fill_their_axes() {
        let picture = |x: Axis, points: [[f64; 2]; 2], rules: Vec<Rule>| {
            Diagram::new("", [x, Axis::linear("y")], vec![Series::line("", points)], rules).picture()
        };
        let rules = |y: f64| vec![Rule::Horizontal(y, "limit".to_owned())];
        let turn = [[0.0, 8.0], [360.0, 8.1]];
        // A turn from its first to its last angle; a limit within three times the data stretches the axis, one beyond does not.
        for (limit, low, high) in [(8.2, 7.988, 8.212), (40.0, 7.994, 8.106)] {
            let [x, y] = picture(Axis::angular("Angle"), turn, rules(limit)).frame.ranges;
            assert!(x == [0.0, 360.0] && (y[0] - low).abs() < 1e-9 && (y[1] - high).abs() < 1e-9, "{limit}: {y:?}");
        }
        // The layout places a point where the curve has it, in the units that are shown.
        let Picture { drawing, frame, shown } =
            picture(Axis::linear("x [m]"), [[0.001, 1.0], [0.003, 2.0]], Vec::new());
        assert_eq!((shown.x.label.as_str(), shown.series[0].points[1]), ("x [mm]", [3.0, 2.0]));
        let at = shown.series[0].points.iter().map(|point| frame.at(*point)).collect::<Vec<_>>();
        assert!(drawing.shapes.iter().any(|shape| matches!(shape, Shape::Line { points, .. } if *points == at)));
    }

    #[test]
    fn a_picture_is_drawn_finer_than_it_is_shown() {
        let curve = (0..=1000).map(|i| 1e-3 * f64::from(i)).map(|x| [x, x * x]);
        let diagram = Diagram::new("", ["x", "y"].map(Axis::linear), vec![Series::line("x²", curve)], Vec::new());
        let svg = diagram.svg();
        // On whole pixels, a thousand points could not lie on a rising curve.
        let line = svg.split("<polyline").find(|part| part.matches(',').count() > 900).unwrap();
        let points = line.split_once("points=\"").unwrap().1.split('"').next().unwrap();
        let heights: Vec<f64> =
            points.split_whitespace().map(|p| p.split_once(',').unwrap().1.parse().unwrap()).collect();
        let different = heights.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(different > 950, "{different}");
    }
}
