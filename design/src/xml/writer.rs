//! XML written element by element: escaping and indentation are the library's, the rest is here.

use crate::text::is_unseen;
use quick_xml::Writer;
use quick_xml::escape::partial_escape;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

/// An XML document in the making.
pub struct Xml(Writer<Vec<u8>>);

/// An attribute of an element.
pub type Attribute = (&'static str, String);

impl Xml {
    /// A document that starts with the XML declaration.
    pub fn document() -> Self {
        let mut xml = Xml(Writer::new_with_indent(Vec::new(), b' ', 2));
        xml.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
        xml
    }

    /// A document that browsers read as HTML.
    pub fn html() -> Self {
        // Many cells would make pages mostly of indents.
        let mut xml = Xml(Writer::new_with_indent(Vec::new(), b' ', 0));
        xml.event(Event::DocType(BytesText::from_escaped("html")));
        xml
    }

    /// Elements of a document that is there.
    pub fn part() -> Self {
        Xml(Writer::new_with_indent(Vec::new(), b' ', 0))
    }

    /// An element without content.
    pub fn empty(&mut self, name: &str, attributes: &[Attribute]) {
        self.event(Event::Empty(tag(name, attributes)));
    }

    /// An element around what `content` writes.
    pub fn element(&mut self, name: &str, attributes: &[Attribute], content: impl FnOnce(&mut Self)) {
        self.event(Event::Start(tag(name, attributes)));
        content(self);
        self.event(Event::End(BytesEnd::new(name)));
    }

    /// An element with text; what stands between backticks is code.
    pub fn prose(&mut self, element: &str, text: &str) {
        if !text.contains('`') {
            return self.text(element, &[], text);
        }
        let pieces = text.split('`').enumerate();
        let pieces = pieces.map(|(i, piece)| {
            let piece = legal(piece);
            let escaped = partial_escape(piece.as_str());
            if i % 2 == 0 { escaped.into_owned() } else { format!("<code>{escaped}</code>") }
        });
        let markup: String = pieces.collect();
        self.element(element, &[], |xml| xml.markup(&markup));
    }

    /// An element that holds nothing but text.
    pub fn text(&mut self, name: &str, attributes: &[Attribute], text: &str) {
        self.event(Event::Start(tag(name, attributes)));
        self.event(Event::Text(BytesText::new(&legal(text))));
        self.event(Event::End(BytesEnd::new(name)));
    }

    /// An element whose text keeps its lines.
    pub fn preformatted(&mut self, name: &str, attributes: &[Attribute], text: &str) {
        self.event(Event::Start(tag(name, attributes)));
        for (i, line) in text.lines().enumerate() {
            let separator = if i > 0 { "\n" } else { "" };
            self.event(Event::Text(BytesText::new(&format!("{separator}{}", legal(line)))));
        }
        self.event(Event::End(BytesEnd::new(name)));
    }

    /// Markup that was written elsewhere and is well-formed.
    pub fn markup(&mut self, markup: &str) {
        self.event(Event::Text(BytesText::from_escaped(markup)));
    }

    /// The finished document, with a final line feed.
    pub fn finish(self) -> String {
        let mut bytes = self.0.into_inner();
        bytes.push(b'\n');
        String::from_utf8(bytes).expect("built from strings")
    }

    fn event(&mut self, event: Event) {
        self.0.write_event(event).expect("a vector takes all bytes");
    }
}

fn tag<'a>(name: &'a str, attributes: &[Attribute]) -> BytesStart<'a> {
    let mut tag = BytesStart::new(name);
    for (key, value) in attributes {
        tag.push_attribute((*key, legal(value).as_str()));
    }
    tag
}

/// The text with all white space but the blank at which no line ends, the characters that XML 1.0 forbids and those that nobody
/// sees turned into blanks: attributes
/// are normalised strings anyway, and a scene's text may hold anything.
pub fn legal(text: &str) -> String {
    text.chars()
        .map(|c| {
            if (c.is_whitespace() && c != '\u{a0}') || is_unseen(c) || matches!(c, '\u{fffe}' | '\u{ffff}') {
                ' '
            } else {
                c
            }
        })
        .collect()
}

/// The shortest decimal that reads back as the same number.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markup_in_values_is_escaped_and_control_characters_vanish() {
        let mut xml = Xml::document();
        xml.element("a", &[("b", "x < \"y\" & 'z'\u{202e}\u{1}".to_owned())], |xml| xml.text("c", &[], "1 < 2"));
        assert_eq!(
            xml.finish(),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <a b=\"x &lt; &quot;y&quot; &amp; &apos;z&apos;  \">\n  <c>1 &lt; 2</c>\n</a>\n"
        );
    }

    #[test]
    fn numbers_read_back_bit_by_bit() {
        for value in [0.1, 1e-300, -1.0 / 3.0, 1e22, 5e-324, f64::MAX, 0.0, -0.0, 12.0] {
            assert_eq!(number(value).parse::<f64>().map(f64::to_bits), Ok(value.to_bits()));
        }
    }
}
