//! Reports as one page of HTML that needs no network; it is well-formed XML, too.
//!
//! Without its script the page shows the same; the script sorts tables, reads values at the pointer and by the keyboard. Curves
//! have as many points as the picture shows: what is left out lies within a tenth of a pixel of the line.

use super::table::{Column, Table, Value};
use super::terminal::{cells, seen};
use super::{Block, Figure, Level, Picture, Report, formula};
use crate::drawing::{self, Drawing, Frame, Point, Shape};
use crate::plot::{Axis, Diagram, PAGE, Scale};
use crate::xml::writer::Xml;

/// The style of pages, on screens and on paper.
const STYLE: &str = include_str!("html.css");
/// Stands in the head of every page: by it a command knows a page of its own.
pub const MARK: &str = "<meta name=\"generator\" content=\"camdrive\"";

/// The script of pages: it sorts tables and reads values.
const SCRIPT: &str = include_str!("html.js");

/// The script of pages that compute.
const LIVE: &str = include_str!("live.js");

/// Such a page loads nothing.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline' 'wasm-unsafe-eval'; \
                      worker-src blob:; base-uri 'none'; form-action 'none'";

/// Stands there until the page computes.
const LACKING: &str = "The sliders need JavaScript and WebAssembly. Open this page in a browser that has both.";

/// On the page of a study.
const CLICK: &str = "Click a point of a diagram, or press Enter at it, to open the scene with the values of that run.";

/// Before the sections that do not follow.
const STILL: &str = "The parts below do not follow the sliders. They show the scene in the file.";

/// The largest distance (pixels) of a line from a point that it leaves out.
const TOLERANCE: f64 = 0.1;

/// 96 pixels are an inch.
const MM_OF_PIXEL: f64 = 25.4 / 96.0;

/// One page of reports on the thing of this name.
pub fn page(name: &str, reports: &[Report]) -> String {
    document(name, reports, SCRIPT, None)
}

/// A page of a study, whose points open a page that computes, with their values.
pub fn linked(name: &str, reports: &[Report], live: &str) -> String {
    page(name, reports).replacen("<main>", &format!("<main data-live=\"{live}\">\n<p>{CLICK}</p>"), 1)
}

/// What a page computes with.
pub struct Engine {
    /// The number of the reports, from the first on, that follow the values.
    pub follow: usize,
    /// Sliders and fields, as markup.
    pub form: String,
    /// The module, packed, in letters that need no escapes.
    pub module: String,
    /// Names and texts of the scene and its tables, as JSON.
    pub files: String,
}

/// A page of reports on a scene whose values its reader may change.
pub fn live(name: &str, reports: &[Report], engine: &Engine) -> String {
    document(name, reports, SCRIPT, Some(engine))
}

/// The sections of reports alone, for a page that computes.
pub fn sections(reports: &[Report]) -> String {
    let mut xml = Xml::part();
    parts(&mut xml, reports, (1, true));
    xml.finish()
}

/// The same page as a document that runs nothing.
pub fn page_without_script(name: &str, reports: &[Report]) -> String {
    document(name, reports, "", None)
}

fn document(name: &str, reports: &[Report], script: &str, engine: Option<&Engine>) -> String {
    let mut xml = Xml::html();
    let attribute = |key: &'static str, value: &str| (key, value.to_owned());
    let root = [attribute("xmlns", "http://www.w3.org/1999/xhtml"), attribute("lang", "en")];
    xml.element("html", &root, |xml| {
        xml.element("head", &[], |xml| {
            xml.empty("meta", &[attribute("charset", "utf-8")]);
            xml.empty("meta", &[attribute("name", "generator"), attribute("content", "camdrive")]);
            let content = attribute("content", "width=device-width, initial-scale=1");
            xml.empty("meta", &[attribute("name", "viewport"), content]);
            if engine.is_some() {
                let policy = attribute("http-equiv", "Content-Security-Policy");
                xml.empty("meta", &[policy, attribute("content", POLICY)]);
            }
            xml.text("title", &[], name);
            xml.text("style", &[], STYLE);
        });
        xml.element("body", &[], |xml| {
            xml.element("main", &[], |xml| {
                xml.text("h1", &[], name);
                if reports.len() > 1 {
                    contents(xml, reports);
                }
                let follow = engine.map_or(0, |engine| engine.follow);
                if let Some(engine) = engine {
                    controls(xml, engine);
                    xml.element("div", &[attribute("id", "live")], |xml| parts(xml, &reports[..follow], (1, true)));
                    xml.text("p", &[attribute("class", "still")], STILL);
                }
                parts(xml, &reports[follow..], (follow + 1, !script.is_empty()));
            });
            // Browsers read what is in a script as it stands, XML does not. Comments and indents stay at home.
            let code = |xml: &mut Xml, script: &str| {
                let lines = script.lines().map(str::trim_start).filter(|line| !line.starts_with("//"));
                let lines: String = lines.flat_map(|line| [line, "\n"]).collect();
                xml.element("script", &[], |xml| xml.markup(&format!("//<![CDATA[\n{lines}//]]>")));
            };
            if !script.is_empty() {
                code(xml, script);
            }
            if let Some(engine) = engine {
                let data = |id: &str, kind: &str| [attribute("id", id), attribute("type", kind)];
                xml.element("script", &data("module", "text/plain"), |xml| xml.markup(&engine.module));
                xml.element("script", &data("files", "application/json"), |xml| xml.markup(&engine.files));
                code(xml, LIVE);
            }
        });
    });
    xml.finish()
}

/// The sections of a page, counted from this number on; the script reads them or not.
fn parts(xml: &mut Xml, reports: &[Report], (first, script): (usize, bool)) {
    for (i, report) in reports.iter().enumerate() {
        xml.element("section", &[("id", format!("part{}", first + i))], |xml| section(xml, report, script));
    }
}

/// The values that a reader may change.
fn controls(xml: &mut Xml, engine: &Engine) {
    xml.text("p", &[("id", "state".to_owned()), ("role", "status".to_owned())], LACKING);
    // A page that is loaded again has the values of its scene.
    let form = [("id", "dials"), ("hidden", "hidden"), ("autocomplete", "off")];
    xml.element("form", &form.map(|(name, value)| (name, value.to_owned())), |xml| {
        xml.markup(&engine.form);
        xml.element("p", &[], |xml| {
            xml.text("button", &[("type", "reset".to_owned())], "Reset");
            xml.text("button", &[("type", "button".to_owned()), ("id", "copy".to_owned())], "Copy as scene");
        });
        let area = [("id", "copied"), ("readonly", "readonly"), ("hidden", "hidden"), ("aria-label", "Changed keys")];
        xml.text("textarea", &area.map(|(key, value)| (key, value.to_owned())), "");
    });
}

/// The parts of the page, each with its verdict.
fn contents(xml: &mut Xml, reports: &[Report]) {
    xml.element("nav", &[("aria-label", "Parts".to_owned())], |xml| {
        xml.element("ul", &[], |xml| {
            for (i, report) in reports.iter().enumerate() {
                xml.element("li", &[], |xml| {
                    xml.text("a", &[("href", format!("#part{}", i + 1))], &title(report));
                    if !report.verdict.result.is_empty() {
                        level(xml, report.verdict.level);
                    }
                });
            }
        });
    });
}

/// The name of the study as a heading.
fn title(report: &Report) -> String {
    let mut letters = report.study.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A level by sign, word and colour.
fn level(xml: &mut Xml, level: Level) {
    let (class, text) = match level {
        Level::Good => ("good", "✔ good"),
        Level::Mind => ("mind", "! attention"),
        Level::Bad => ("bad", "✘ fails"),
    };
    xml.text("span", &[("class", format!("level {class}"))], text);
}

/// A report as a part of a page: heading, verdict, figures, tables and sentences; what explains is folded away. What only the
/// script reads is there where there is one.
fn section(xml: &mut Xml, report: &Report, script: bool) {
    xml.text("h2", &[], &title(report));
    if report.verdict.parts().iter().any(|(_, sentences)| !sentences.is_empty()) {
        xml.element("dl", &[("class", "verdict".to_owned())], |xml| {
            for (heading, sentences) in report.verdict.parts().iter().filter(|(_, list)| !list.is_empty()) {
                xml.element("dt", &[], |xml| {
                    xml.text("span", &[], heading);
                    if *heading == "Result" {
                        level(xml, report.verdict.level);
                    }
                });
                sentences.iter().for_each(|sentence| xml.prose("dd", &kept(sentence)));
            }
        });
    }
    // Sentences without a title say what the figures show.
    let lead = usize::from(matches!(report.body.first(), Some(Block::Lines(title, _)) if title.is_empty()));
    let (lead, rest) = report.body.split_at(lead);
    lead.iter().for_each(|part| block(xml, part, script));
    columns(xml, |xml| {
        report.figures.iter().for_each(|figure| picture(xml, figure, script));
        blocks(xml, rest, script);
    });
    if !report.explained.is_empty() {
        // The script opens them for the print.
        let open = Some(("open", "open".to_owned())).filter(|_| !script);
        xml.element("details", &Vec::from_iter(open), |xml| {
            xml.text("summary", &[], "Formulas, sources, how it was computed");
            columns(xml, |xml| blocks(xml, &report.explained, script));
        });
    }
}

/// As many columns as the width has room for.
fn columns(xml: &mut Xml, content: impl FnOnce(&mut Xml)) {
    xml.element("div", &[("class", "columns".to_owned())], content);
}

/// More rows than this may go on in the next column, on paper more rows than that.
const LONG: usize = 14;
const LONG_ON_PAPER: usize = 40;

/// Letters that fit side by side into a column, and those that the edges of a cell take.
const COLUMN: usize = 66;
const COLUMN_ON_PAPER: usize = 74;
const EDGES: usize = 2;

/// A cell of words needs no more letters than this: they wrap.
const WRAPPED: usize = 16;

/// The blocks that say something, each whole in its column; at the end tables that need the width of all.
fn blocks(xml: &mut Xml, blocks: &[Block], script: bool) {
    let class = |part: &Block| match part {
        Block::Table(table) if table.title.is_empty() || table.rows.is_empty() => None,
        Block::Lines(_, lines) if lines.is_empty() => None,
        Block::Table(table) if letters(table) > COLUMN_ON_PAPER => Some("block whole wide"),
        Block::Table(table) if letters(table) > COLUMN => Some("block wide"),
        Block::Table(table) if table.rows.len() > LONG_ON_PAPER => Some("block long paper"),
        Block::Table(table) if table.rows.len() > LONG => Some("block long"),
        _ => Some("block"),
    };
    let mut parts: Vec<_> = blocks.iter().filter_map(|part| Some((class(part)?, part))).collect();
    parts.sort_by_key(|(class, _)| class.ends_with("wide"));
    for (class, part) in parts {
        xml.element("div", &[("class", class.to_owned())], |xml| block(xml, part, script));
    }
}

/// How many letters side by side a table needs.
fn letters(table: &Table) -> usize {
    let (seen, shown) = (seen(table), cells(table));
    let longest = |(i, of): (usize, &usize)| {
        let words = shown.head[i].split(' ').map(|word| word.chars().count());
        let cell = |(row, cells): (&Vec<Value>, &Vec<String>)| match full(&row[*of], &table.columns[*of]) {
            Some(_) => cells[i].chars().count(),
            None => cells[i].chars().count().min(WRAPPED),
        };
        table.rows.iter().zip(&shown.rows).map(cell).chain(words).max().unwrap_or(0) + EDGES
    };
    seen.iter().enumerate().map(longest).sum()
}

fn block(xml: &mut Xml, block: &Block, script: bool) {
    match block {
        Block::Table(content) => {
            xml.text("h3", &[], &content.title);
            table(xml, content, script);
            content.below.iter().for_each(|line| xml.prose("p", &kept(line)));
        }
        Block::Lines(title, lines) if title.is_empty() => lines.iter().for_each(|line| xml.prose("p", &kept(line))),
        Block::Lines(title, lines) => {
            xml.text("h3", &[], title);
            xml.element("ul", &[], |xml| lines.iter().for_each(|line| xml.prose("li", &kept(line))));
        }
        Block::Equations(title, equations) => {
            xml.text("h3", &[], title);
            for equation in equations {
                xml.text("p", &[("class", "of".to_owned())], &equation.title);
                let class = [("class", "formula".to_owned())];
                xml.element("p", &class, |xml| xml.markup(&formula::markup(&equation.text)));
            }
        }
        Block::Code(title, sentence, code) => {
            xml.text("h3", &[], title);
            xml.prose("p", sentence);
            xml.preformatted("pre", &[("tabindex", "0".to_owned())], code);
        }
        Block::File(title, name, place) => {
            xml.text("h3", &[], title);
            xml.element("p", &[], |xml| xml.text("a", &[("href", place.clone())], name));
        }
    }
}

/// Words that stay in the line of the number before them.
const UNITS: &str = " mm mm/rad mm/rad² m/s m/s² rpm rad/s ms µs ns s ns/ms Hz % kg kg·m² N kN N·m N·s N/mm² J W kW ";

/// The text with numbers that keep their units.
fn kept(text: &str) -> String {
    let words = text.split(' ').scan(' ', |last, word| {
        let unit = word.trim_end_matches(['.', ',', ';', ':', ')']);
        let is_unit = last.is_ascii_digit() && !unit.is_empty() && UNITS.contains(&format!(" {unit} "));
        *last = word.chars().last().unwrap_or(' ');
        Some(if is_unit { format!("\u{a0}{word}") } else { format!(" {word}") })
    });
    words.collect::<String>().chars().skip(1).collect()
}

/// A table in a box that scrolls; for the script a cell has all digits besides the shown ones.
fn table(xml: &mut Xml, table: &Table, script: bool) {
    let (seen, shown) = (seen(table), cells(table));
    let has_numbers = |i: usize| table.rows.iter().any(|row| full(&row[i], &table.columns[i]).is_some());
    // A scrolling box takes the keyboard; with the script, its cells do.
    let keys = Some(("tabindex", "0".to_owned())).filter(|_| !script);
    let class = ("class", "table".to_owned());
    xml.element("div", &[class].into_iter().chain(keys).collect::<Vec<_>>(), |xml| {
        xml.element("table", &[("aria-label", table.title.clone())], |xml| {
            xml.element("thead", &[], |xml| {
                xml.element("tr", &[], |xml| {
                    for (column, heading) in seen.iter().map(|i| &table.columns[*i]).zip(&shown.head) {
                        let unit =
                            Some(("data-unit", column.unit.name.to_string())).filter(|(_, unit)| !unit.is_empty());
                        let attributes: Vec<_> = [("scope", "col".to_owned())].into_iter().chain(unit).collect();
                        xml.text("th", &attributes, heading);
                    }
                });
            });
            xml.element("tbody", &[], |xml| {
                for (row, cells) in table.rows.iter().zip(&shown.rows) {
                    xml.element("tr", &[], |xml| {
                        for (i, cell) in seen.iter().zip(cells) {
                            match full(&row[*i], &table.columns[*i]) {
                                Some(full) if script => xml.text("td", &[("data-v", full)], cell),
                                _ if has_numbers(*i) => xml.text("td", &[("class", "beside".to_owned())], cell),
                                _ => xml.prose("td", &kept(cell)),
                            }
                        }
                    });
                }
            });
        });
    });
}

/// All digits of a cell, the number by which it is sorted first; None of a word.
fn full(value: &Value, column: &Column) -> Option<String> {
    let number = |value: f64| match value * column.unit.factor + 0.0 {
        value if value.is_infinite() => "Infinity".to_owned(),
        value => format!("{value:?}").trim_end_matches(".0").to_owned(),
    };
    match value {
        Value::Empty | Value::Text(_) => None,
        Value::Number(value) => Some(number(*value)),
        Value::AtMost(value) => Some(format!("{} at most", number(*value))),
        Value::Range([low, high]) => Some(format!("{} to {}", number(*low), number(*high))),
        Value::At(value, phi) => Some(format!("{} at {:?}°", number(*value), phi.to_degrees())),
    }
}

fn picture(xml: &mut Xml, figure: &Figure, script: bool) {
    match &figure.picture {
        Picture::Diagram(content) => diagram(xml, &figure.key, content, script),
        Picture::Drawing(drawing, label, scale) => {
            let mut drawing = drawing.clone();
            thin(&mut drawing);
            xml.element("figure", &[], |xml| xml.markup(&drawing.svg(label, *scale)));
        }
    }
}

/// A diagram, for the script with the points of its series and the cells of its map.
fn diagram(xml: &mut Xml, key: &str, diagram: &Diagram, script: bool) {
    let mut picture = diagram.picture();
    thin(&mut picture.drawing);
    // Letters of a diagram are as high as the page's.
    let svg = picture.drawing.svg(&diagram.title, PAGE);
    let (frame, shown) = (picture.frame, picture.shown);
    let axis = |axis: &Axis, [first, last]: [f64; 2], [low, high]: [f64; 2]| {
        let scale = if axis.scale == Scale::Logarithmic { "log" } else { "linear" };
        format!("{first} {last} {low:?} {high:?} {scale} {}", axis.label)
    };
    let [x, y] = [(0, &shown.x), (1, &shown.y)].map(|(i, of)| axis(of, frame.ends[i], frame.ranges[i]));
    let z = shown.map.as_ref().map(|map| ("data-z", axis(&map.scale, [0.0, 1.0], map.range())));
    let axes: Vec<_> =
        [("data-key", key.to_owned()), ("data-x", x), ("data-y", y)].into_iter().chain(z).filter(|_| script).collect();
    xml.element("figure", &axes, |xml| {
        xml.markup(&svg);
        let mut data = |name: &str, value: String| {
            xml.text("data", &[("hidden", "hidden".to_owned()), ("value", value)], name);
        };
        for series in shown.series.iter().filter(|_| script) {
            let place = |[x, y]: &Point| Some(frame.at([shown.x.place(*x)?, shown.y.place(*y)?]));
            let lines = series.lines(place);
            let lines: Vec<String> = lines.iter().map(|line| values(line, &frame, [&shown.x, &shown.y])).collect();
            data(&series.name, lines.join(";"));
        }
        for map in shown.map.iter().filter(|_| script) {
            map.read().into_iter().for_each(|(name, cells)| data(name, cells));
        }
    });
}

/// The points of a line in pixels as values, in the digits that the picture has.
fn values(line: &[Point], frame: &Frame, axes: [&Axis; 2]) -> String {
    let value = |i: usize, pixel: f64| {
        let ([first, last], [low, high]) = (frame.ends[i], frame.ranges[i]);
        let place = low + (high - low) * (pixel - first) / (last - first);
        let decimals = (4.0 - (high - low).log10().floor()).clamp(0.0, 300.0) as i32;
        match axes[i].scale {
            Scale::Logarithmic => format!("{:.4e}", 10f64.powf(place)),
            _ if decimals > 15 => format!("{place:.4e}"),
            _ => format!("{:?}", format!("{place:.*}", decimals as usize).parse::<f64>().unwrap_or(place) + 0.0)
                .trim_end_matches(".0")
                .to_owned(),
        }
    };
    let point = |[x, y]: &Point| format!("{},{}", value(0, *x), value(1, *y));
    thinned(line, TOLERANCE).iter().map(point).collect::<Vec<_>>().join(" ")
}

/// Leaves out the points of lines that nobody sees.
fn thin(drawing: &mut Drawing) {
    let tolerance = if drawing.unit == drawing::Unit::Millimetre { TOLERANCE * MM_OF_PIXEL } else { TOLERANCE };
    for shape in &mut drawing.shapes {
        if let Shape::Line { points, .. } | Shape::Area { points, .. } = shape {
            *points = thinned(points, tolerance);
        }
    }
}

/// The points of a line from which none of the others is farther away than the tolerance (Douglas and Peucker).
fn thinned(points: &[Point], tolerance: f64) -> Vec<Point> {
    let mut kept = vec![false; points.len()];
    let mut open = vec![(0, points.len().saturating_sub(1))];
    while let Some((from, to)) = open.pop() {
        for end in [from, to] {
            kept.get_mut(end).into_iter().for_each(|kept| *kept = true);
        }
        let far = (from + 1..to).map(|i| (distance(points[i], points[from], points[to]), i));
        if let Some((_, i)) = far.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|(far, _)| !(*far <= tolerance * tolerance))
        {
            open.extend([(from, i), (i, to)]);
        }
    }
    points.iter().zip(kept).filter_map(|(point, kept)| kept.then_some(*point)).collect()
}

/// The square of the way from a point to the line between two: its root costs a page that computes a fifth of a redraw.
fn distance(point: Point, from: Point, to: Point) -> f64 {
    let [[x, y], [dx, dy]] = [point, to].map(|[x, y]| [x - from[0], y - from[1]]);
    let length = dx * dx + dy * dy;
    let share = if length > 0.0 { ((x * dx + y * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
    (x - share * dx).powi(2) + (y - share * dy).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Rule, Series};
    use crate::report::unit::MM;
    use crate::xml::Element;

    fn report() -> Report {
        let mut report = Report::new("a < b", "stability & \"more\"");
        report.verdict.result(Level::Mind, "It `runs`.").advice("Add damping.");
        let rows = [1.23456789e-3, f64::INFINITY];
        report.table(Table::of("Lifts", &rows).column("lift", "lift", MM, |row| *row).below(["Below.".to_owned()]));
        report.explain("Method", ["By hand.".to_owned()]);
        let sine = (0..=3600).map(|i| f64::from(i) / 10.0).map(|x| [x, x.to_radians().sin()]);
        let axes = [Axis::angular("Angle [°]"), Axis::linear("Lift [m]")];
        report.diagram("lift", Diagram::new("Lift", axes, vec![Series::line("sine", sine)], Vec::<Rule>::new()));
        report
    }

    #[test]
    fn a_page_is_whole_and_asks_nobody() {
        let page = page("a < b", &[report(), report()]);
        let body = page.split_once("<!DOCTYPE html>").unwrap().1;
        assert_eq!(Element::read(body).unwrap().name, "html");
        for part in
            ["<h1>a &lt; b</h1>", "Stability &amp; &quot;more&quot;", "! attention", "<code>runs</code>", "By hand."]
        {
            assert!(page.contains(part) || page.contains(&part.replace("&quot;", "\"")), "{part}");
        }
        assert!(
            page.contains("<td data-v=\"1.23456789\">1.23</td>") && page.contains("<td data-v=\"Infinity\">∞</td>")
        );
        for outside in ["src=", "@import", "url(", "href=\"http"] {
            assert!(!page.contains(outside), "{outside}");
        }
    }

    #[test]
    fn style_and_script_need_no_escapes() {
        assert!(!STYLE.contains(['"', '&', '<', '>']));
        assert!([SCRIPT, LIVE].iter().all(|script| !script.contains("]]>") && !script.contains("</")));
    }

    #[test]
    fn curves_have_the_points_that_are_seen() {
        let sine: Vec<Point> =
            (0..=3600).map(|i| f64::from(i) / 10.0).map(|x| [x, 150.0 * x.to_radians().sin()]).collect();
        let few = thinned(&sine, TOLERANCE);
        assert!(few.len() < 100 && few[0] == sine[0] && few.last() == sine.last());
        let missed =
            |p: &Point| few.windows(2).map(|ends| distance(*p, ends[0], ends[1])).fold(f64::INFINITY, f64::min);
        assert!(sine.iter().map(missed).fold(0.0, f64::max) <= TOLERANCE);
        assert!(thinned(&[], TOLERANCE).is_empty() && thinned(&few[..1], TOLERANCE) == few[..1]);
    }
}
