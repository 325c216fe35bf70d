//! Diagrams of points and lines as SVG: legible in print without colour, since series differ in marker and dashes.
//!
//! All diagrams of the tool come from here, so that they look alike.

mod area;
mod look;
mod places;
mod rule;
mod suited;
mod ticks;

use camdrive::drives::Fault;
use look::{RULED, draw_line, draw_marker, look, marked};
use places::Places;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{IntoFont, TextStyle};
use ticks::{angular_step, decimal, decimal_step, logarithmic_ticks};

/// How an axis divides its length.
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
    /// Whether a line joins the points.
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

    /// The lines in pixels between points that have no place, or each point for itself.
    fn lines(
        &self,
        place: &dyn Fn(&[f64; 2]) -> Option<(f64, f64)>,
        pixel: &dyn Fn(&(f64, f64)) -> (i32, i32),
    ) -> Vec<Vec<(i32, i32)>> {
        let of = |part: &[[f64; 2]]| part.iter().filter_map(place).map(|point| pixel(&point)).collect::<Vec<_>>();
        if self.joined {
            self.points.split(|point| place(point).is_none()).filter(|part| !part.is_empty()).map(of).collect()
        } else {
            of(&self.points).into_iter().map(|point| vec![point]).collect()
        }
    }
}

/// What lies behind the data: a straight line across the diagram, or an area.
#[derive(Clone, Debug, PartialEq)]
pub enum Rule {
    /// A line at this x.
    Vertical(f64, String),
    /// A line at this y.
    Horizontal(f64, String),
    /// A grey area within this outline, as far as the axes show it; the axes do not stretch for it.
    Area(Vec<[f64; 2]>, Shade),
    /// A line along these points of this thickness in pixels, as far as the axes show it; they do not stretch for it.
    Border(Vec<[f64; 2]>, u32),
    /// A word above this point.
    Word([f64; 2], String),
    /// What areas of this shade are, or without a shade lines that have no name, for the legend.
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
    fn grey(self) -> RGBColor {
        if self == Shade::Pale { PALE_AREA } else { DARK_AREA }
    }
}

/// A diagram.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagram {
    /// What it shows.
    pub title: String,
    /// The abscissa.
    pub x: Axis,
    /// The ordinate.
    pub y: Axis,
    /// The data, at most as many as there are [`look::MARKERS`] to tell them apart well.
    pub series: Vec<Series>,
    /// Borders and limits.
    pub rules: Vec<Rule>,
}

/// The drawing library knows whole coordinates only: so many of them make a pixel, so that curves are smooth at any
/// enlargement. Lengths of this file are in pixels; [`fine`] makes them coordinates.
const FINE: i32 = 20;

fn fine(pixels: i32) -> i32 {
    pixels * FINE
}

const PLOT_WIDTH: u32 = 540;
const HEIGHT: u32 = 400;
/// The widths of letters differ; this is the mean of a sans-serif font, per height.
const LETTER: f64 = 0.54;
const TEXT: f64 = 13.0;
const TITLE: f64 = 16.0;
/// That of a page of text, a browser's default.
const PAGE_TEXT: f64 = 16.0;
const LINE: i32 = 20;
const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
const PALE: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);
const PALE_AREA: RGBColor = RGBColor(0xec, 0xec, 0xec);
const DARK_AREA: RGBColor = RGBColor(0xc4, 0xc4, 0xc4);
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

    /// The same from `low` to `high`, whatever the data are.
    pub fn between(self, low: f64, high: f64) -> Self {
        Axis { ends: Some([low, high]), ..self }
    }

    /// Where a value lies on the axis; None off the scale.
    fn place(&self, value: f64) -> Option<f64> {
        match self.scale {
            Scale::Linear | Scale::Angular => value.is_finite().then_some(value),
            Scale::Logarithmic => (value > 0.0 && value.is_finite()).then(|| value.log10()),
        }
    }

    /// The ends of the axis for these places.
    fn span(&self, places: impl Iterator<Item = f64>) -> [f64; 2] {
        if let Some([Some(low), Some(high)]) = self.ends.map(|ends| ends.map(|end| self.place(end))) {
            return [low, high];
        }
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        if low > high {
            return [0.0, 1.0];
        }
        let least = if self.scale == Scale::Logarithmic { 0.5 } else { 1e-9 + 1e-3 * low.abs() };
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
                let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
                (first..=last).map(|i| i as f64 * step).map(|v| (v, decimal(v, step))).collect()
            }
            Scale::Logarithmic => logarithmic_ticks(low, high),
        }
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// A line of this colour and thickness in pixels.
fn thick(colour: RGBColor, pixels: u32) -> ShapeStyle {
    ShapeStyle::from(colour).stroke_width(pixels * FINE as u32)
}

/// Text of this height in pixels.
fn style(size: f64) -> TextStyle<'static> {
    ("sans-serif", size * f64::from(FINE)).into_font().color(&INK)
}

impl Diagram {
    /// A diagram of these data over two axes.
    pub fn new(title: impl Into<String>, [x, y]: [Axis; 2], series: Vec<Series>, rules: Vec<Rule>) -> Self {
        Diagram { title: title.into(), x, y, series, rules }
    }

    /// The diagram as an SVG document.
    ///
    /// # Errors
    /// What the drawing library reports; nothing for memory.
    pub fn svg(&self) -> Result<String, Fault> {
        let legend = if self.entries() == 0 { 10 } else { self.legend_width() };
        let size = [PLOT_WIDTH + legend, HEIGHT.max(20 + self.legend_height())];
        self.document(size, 1.0, |root| root.split_horizontally(fine(PLOT_WIDTH as i32)))
    }

    /// The same for a page of text: the legend below, so that the picture need not be shrunk to the width of a page, and
    /// letters of the height of the page's.
    ///
    /// # Errors
    /// What the drawing library reports; nothing for memory.
    pub fn svg_for_page(&self) -> Result<String, Fault> {
        let size = [PLOT_WIDTH.max(self.legend_width()), HEIGHT + self.legend_height()];
        self.document(size, PAGE_TEXT / TEXT, |root| {
            let (plot, legend) = root.split_vertically(fine(HEIGHT as i32));
            (plot.shrink((0, 0), (fine(PLOT_WIDTH as i32) as u32, fine(HEIGHT as i32) as u32)), legend)
        })
    }

    fn entries(&self) -> usize {
        self.series.len() + self.keys().count()
    }

    fn legend_width(&self) -> u32 {
        let names = self.series.iter().map(|series| &series.name).chain(self.keys().map(|(_, name)| name));
        let longest = names.map(|name| name.chars().count()).max().unwrap_or(0);
        64 + (LETTER * TEXT * longest as f64) as u32
    }

    fn legend_height(&self) -> u32 {
        20 + LINE as u32 * self.entries() as u32
    }

    /// The title in lines that a picture of this width has room for.
    fn title_lines(&self, width: u32) -> Vec<String> {
        let room = (f64::from(width - 24) / (LETTER * TITLE)) as usize;
        let mut lines: Vec<String> = Vec::new();
        for word in self.title.split_whitespace() {
            match lines.last_mut() {
                Some(line) if line.chars().count() + word.chars().count() < room => *line += &format!(" {word}"),
                _ => lines.push(word.to_owned()),
            }
        }
        lines
    }

    /// The document of this size in pixels without the title, shown `scale` times as large; `split` makes the areas of plot and legend.
    fn document(
        &self,
        size: [u32; 2],
        scale: f64,
        split: impl for<'a> Fn(&Area<'a>) -> (Area<'a>, Area<'a>),
    ) -> Result<String, Fault> {
        let diagram = self.suited();
        let title = self.title_lines(size[0]);
        let above = if title.is_empty() { 0 } else { LINE * title.len() as i32 + 8 };
        let size = [size[0], size[1] + above as u32];
        let mut text = String::new();
        {
            let coordinates = size.map(|pixels| pixels * FINE as u32);
            let root = SVGBackend::with_string(&mut text, coordinates.into()).into_drawing_area();
            let failed = |e: &dyn std::fmt::Display| Fault(format!("the diagram cannot be drawn: {e}"));
            root.fill(&WHITE).map_err(|e| failed(&e))?;
            for (i, line) in title.iter().enumerate() {
                let at = (fine(12), fine(10 + LINE * i as i32));
                root.draw(&Text::new(line.clone(), at, style(TITLE))).map_err(|e| failed(&e))?;
            }
            let (plot, legend) = split(&root.split_vertically(fine(above)).1);
            diagram.draw(&plot, &legend).map_err(|e| failed(&e))?;
            root.present().map_err(|e| failed(&e))?;
        }
        let label = self.title.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
        let head = |[width, height]: [u32; 2]| format!("<svg width=\"{width}\" height=\"{height}\" ");
        // The view box still has the coordinates.
        let shown = head(size.map(|pixels| (scale * f64::from(pixels)).round() as u32));
        let drawn = head(size.map(|pixels| pixels * FINE as u32));
        Ok(text.replacen(&drawn, &format!("{shown}role=\"img\" aria-label=\"{label}\" "), 1))
    }

    /// The entries of the legend beside those of the data; without shade that of a line.
    fn keys(&self) -> impl Iterator<Item = (Option<Shade>, &String)> {
        self.rules.iter().filter_map(|rule| match rule {
            Rule::Key(shade, name) => Some((*shade, name)),
            _ => None,
        })
    }

    fn draw(&self, plot: &Area<'_>, legend: &Area<'_>) -> Result<(), Box<dyn std::error::Error>> {
        let place = |[x, y]: &[f64; 2]| Some((self.x.place(*x)?, self.y.place(*y)?));
        let places: Vec<Vec<(f64, f64)>> =
            self.series.iter().map(|series| series.points.iter().filter_map(place).collect()).collect();
        let rule = |rule: &Rule| match rule {
            Rule::Vertical(x, _) => (self.x.place(*x), None),
            Rule::Horizontal(y, _) => (None, self.y.place(*y)),
            Rule::Area(..) | Rule::Border(..) | Rule::Word(..) | Rule::Key(..) => (None, None),
        };
        let rules: Vec<(Option<f64>, Option<f64>)> = self.rules.iter().map(rule).collect();
        let x = self.x.span(places.iter().flatten().map(|p| p.0).chain(rules.iter().filter_map(|r| r.0)));
        let y = self.y.span(places.iter().flatten().map(|p| p.1).chain(rules.iter().filter_map(|r| r.1)));
        let (x_places, y_places) =
            (Places { ends: x, ticks: self.x.ticks(x) }, Places { ends: y, ticks: self.y.ticks(y) });
        let counts = (x_places.ticks.len().max(1), y_places.ticks.len().max(1));
        let mut chart = ChartBuilder::on(plot)
            .margin_top(fine(14))
            .margin_right(fine(14))
            .margin_left(fine(12))
            .margin_bottom(fine(4))
            .x_label_area_size(fine(54))
            .y_label_area_size(fine(84))
            .build_cartesian_2d(x_places, y_places)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(thick(PALE, 1))
            .axis_style(thick(INK, 1))
            .set_all_tick_mark_size(fine(5))
            .label_style(style(TEXT))
            .axis_desc_style(style(TEXT + 1.0))
            .x_desc(self.x.label.as_str())
            .y_desc(self.y.label.as_str())
            .x_labels(counts.0)
            .y_labels(counts.1)
            .draw()?;
        let area = chart.plotting_area().strip_coord_spec();
        let pixel = |point: &(f64, f64)| {
            let (px, py) = chart.backend_coord(point);
            let (left, top) = area.get_base_pixel();
            (px - left, py - top)
        };
        for rule in &self.rules {
            if let Rule::Border(points, width) = rule {
                let line: Vec<(f64, f64)> = points.iter().filter_map(place).collect();
                for part in area::seen(&line, x, y) {
                    let part: Vec<(i32, i32)> = part.iter().map(pixel).collect();
                    area.draw(&PathElement::new(part, thick(INK, *width)))?;
                }
            }
            if let Rule::Word(at, word) = rule
                && let Some(at) = place(at)
            {
                let text = style(TEXT - 1.0).pos(Pos::new(HPos::Center, VPos::Bottom));
                let (px, py) = pixel(&at);
                area.draw(&Text::new(word.clone(), (px, py - fine(2)), text))?;
            }
            if let Rule::Area(outline, shade) = rule {
                let outline: Vec<(f64, f64)> = outline.iter().filter_map(place).collect();
                let seen: Vec<(i32, i32)> = area::within(&outline, x, y).iter().map(pixel).collect();
                area.draw(&Polygon::new(seen, ShapeStyle::from(shade.grey()).filled()))?;
            }
        }
        area.draw(&frame([(0, 0), pixel(&(x[1], y[0]))]))?;
        let is_seen =
            |place: Option<f64>, [low, high]: [f64; 2]| place.is_none_or(|place| (low..=high).contains(&place));
        let seen = self.rules.iter().zip(&rules).filter(|(_, at)| is_seen(at.0, x) && is_seen(at.1, y));
        let pixels_of =
            |at: &(Option<f64>, Option<f64>)| (at.0.map(|x| pixel(&(x, y[0])).0), at.1.map(|y| pixel(&(x[0], y)).1));
        let seen: Vec<(&Rule, rule::Place)> = seen.map(|(rule, at)| (rule, pixels_of(at))).collect();
        let lines: Vec<Vec<Vec<(i32, i32)>>> = self.series.iter().map(|series| series.lines(&place, &pixel)).collect();
        let corners = [pixel(&(x[0], y[0])), pixel(&(x[1], y[1]))];
        rule::draw_rules(&area, &seen, corners, lines.concat())?;
        for (i, (series, places)) in self.series.iter().zip(&places).enumerate() {
            let points: Vec<(i32, i32)> = places.iter().map(pixel).collect();
            if series.joined {
                for line in lines[i].iter().filter(|line| line.len() > 1) {
                    draw_line(&area, line, look(i))?;
                }
            }
            for point in marked(&points, series.joined, i) {
                draw_marker(&area, point, look(i))?;
            }
        }
        for (i, series) in self.series.iter().enumerate() {
            let height = fine(24 + LINE * i as i32);
            if series.joined {
                draw_line(legend, &[(fine(6), height), (fine(42), height)], look(i))?;
            }
            draw_marker(legend, (fine(24), height), look(i))?;
            let text = style(TEXT).pos(Pos::new(HPos::Left, VPos::Center));
            legend.draw(&Text::new(series.name.clone(), (fine(50), height), text))?;
        }
        for (i, (shade, name)) in self.keys().enumerate() {
            let height = fine(24 + LINE * (self.series.len() + i) as i32);
            let (box_of, text) = (
                [(fine(6), height - fine(6)), (fine(42), height + fine(6))],
                style(TEXT).pos(Pos::new(HPos::Left, VPos::Center)),
            );
            match shade {
                Some(shade) => {
                    legend.draw(&Rectangle::new(box_of, ShapeStyle::from(shade.grey()).filled()))?;
                    legend.draw(&frame(box_of))?;
                }
                None => draw_line(legend, &[(box_of[0].0, height), (box_of[1].0, height)], RULED)?,
            }
            legend.draw(&Text::new(name.clone(), (fine(50), height), text))?;
        }
        Ok(())
    }
}

/// The outline of a rectangle; the library draws those of its own in the thickness of a coordinate.
fn frame([(left, top), (right, bottom)]: [(i32, i32); 2]) -> PathElement<(i32, i32)> {
    PathElement::new(vec![(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], thick(INK, 1))
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
                        Rule::Border(vec![[1.0, 1.0], [f64::NAN, 2.0], [3.0, 1e3]], 1),
                        Rule::Word([-1.0, f64::INFINITY], "<j>".into()),
                        Rule::Key(Some(Shade::Pale), "k & l".into()),
                        Rule::Key(None, "m < n".into()),
                    ],
                };
                let svg = diagram.svg().unwrap();
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
        let svg = diagram.svg_for_page().unwrap();
        let number = |name: &str| -> Vec<f64> {
            let value = svg.split_once(&format!(" {name}=\"")).unwrap().1.split('"').next().unwrap();
            value.split(' ').map(|part| part.parse().unwrap()).collect()
        };
        let (width, height, coordinates) = (number("width")[0], number("height")[0], number("viewBox"));
        assert!((width / coordinates[2] * TEXT * f64::from(FINE) - PAGE_TEXT).abs() < 0.05);
        assert!((height / coordinates[3] - width / coordinates[2]).abs() < 1e-4);
        // 60 em less the margins of the page; the legend has room below the plot.
        assert!(width < 928.0 && height > 16.0 / 13.0 * f64::from(HEIGHT + 30 * LINE as u32), "{width} × {height}");
        assert_eq!(svg.matches(name).count(), 30);
    }

    #[test]
    fn a_picture_is_drawn_finer_than_it_is_shown() {
        let curve = (0..=1000).map(|i| 1e-3 * f64::from(i)).map(|x| [x, x * x]);
        let diagram = Diagram::new("", ["x", "y"].map(Axis::linear), vec![Series::line("x²", curve)], Vec::new());
        let svg = diagram.svg().unwrap();
        let number = |name: &str| -> Vec<f64> {
            let value = svg.split_once(&format!(" {name}=\"")).unwrap().1.split('"').next().unwrap();
            value.split(' ').map(|part| part.parse().unwrap()).collect()
        };
        let shown = [number("width")[0], number("height")[0]];
        assert_eq!(shown[1], f64::from(HEIGHT));
        assert_eq!(number("viewBox"), [0.0, 0.0, shown[0] * f64::from(FINE), shown[1] * f64::from(FINE)]);
        // On whole pixels, a thousand points could not lie on a rising curve.
        let line = svg.split("<polyline").find(|part| part.matches(',').count() > 900).unwrap();
        let points = line.split_once("points=\"").unwrap().1.split('"').next().unwrap();
        let heights: Vec<f64> =
            points.split_whitespace().map(|p| p.split_once(',').unwrap().1.parse().unwrap()).collect();
        let different = heights.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(different > 950, "{different}");
    }
}
