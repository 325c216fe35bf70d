//! An XML document as a tree of elements, as far as attributes say it: model descriptions, structures of systems.

pub mod writer;

use camdrive::drives::Fault;
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::str::FromStr;

/// Elements lie no deeper in a document of FMI.
const DEEPEST: usize = 100;

/// An element with its attributes; text between the elements is left out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Element {
    /// Without the prefix of its name space.
    pub name: String,
    /// Names with prefix, and values.
    pub attributes: Vec<(String, String)>,
    /// In their order.
    pub children: Vec<Element>,
}

impl Element {
    /// The root of a document.
    ///
    /// # Errors
    /// Text that is no XML, or XML that is not whole; with the place.
    pub fn read(text: &str) -> Result<Self, Fault> {
        let mut reader = Reader::from_str(text);
        // The element that is open around the others comes last; the first one holds the root.
        let mut open = vec![Element::default()];
        loop {
            let event = reader.read_event().map_err(|e| e.to_string());
            let place = reader.error_position().max(reader.buffer_position()) as usize;
            // Lines are counted for faults alone: at every event the time would grow with the square of the length.
            let wrong = |what: String| {
                let line = 1 + text.as_bytes()[..place.min(text.len())].iter().filter(|byte| **byte == b'\n').count();
                Fault::new(format!("line {line}: {what}"))
            };
            let (element, is_empty) = match event.map_err(wrong)? {
                Event::Start(start) => (Element::of(&start).map_err(wrong)?, false),
                Event::Empty(start) => (Element::of(&start).map_err(wrong)?, true),
                Event::End(_) => (open.pop().unwrap_or_default(), true),
                Event::Eof if open.len() == 1 && open[0].children.len() == 1 => {
                    return Ok(open.remove(0).children.remove(0));
                }
                Event::Eof => return Err(wrong("the document is not whole".to_owned())),
                _ => continue,
            };
            if !is_empty {
                open.push(element);
            } else if let Some(around) = open.last_mut() {
                around.children.push(element);
            }
            if open.len() > DEEPEST {
                return Err(wrong(format!("elements lie deeper than {DEEPEST}")));
            }
        }
    }

    fn of(start: &BytesStart<'_>) -> Result<Self, String> {
        let attribute = |attribute: Result<quick_xml::events::attributes::Attribute<'_>, _>| {
            let attribute = attribute.map_err(|e: quick_xml::events::attributes::AttrError| e.to_string())?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0).map_err(|e| e.to_string())?;
            Ok((attribute.key.as_ref().to_owned(), value.into_owned()))
        };
        let attributes = start.attributes().map(attribute).collect::<Result<_, String>>()?;
        Ok(Element { name: start.local_name().as_ref().to_owned(), attributes, children: Vec::new() })
    }

    /// The value of an attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    /// The value of an attribute that must be there.
    ///
    /// # Errors
    /// It is not.
    pub fn needed(&self, name: &str) -> Result<&str, Fault> {
        self.get(name).ok_or_else(|| Fault::new(format!("<{}> has no attribute `{name}`", self.name)))
    }

    /// The number, or true or false, that an attribute has.
    ///
    /// # Errors
    /// It is none.
    pub fn number<T: FromStr>(&self, name: &str) -> Result<Option<T>, Fault> {
        let parsed = |text: &str| {
            text.trim().parse().map_err(|_| Fault::new(format!("<{}>: {name}=\"{text}\" cannot be read", self.name)))
        };
        self.get(name).map(parsed).transpose()
    }

    /// True if an attribute is true, which xs:boolean writes in two ways.
    pub fn is(&self, name: &str) -> bool {
        matches!(self.get(name), Some("true" | "1"))
    }

    /// The children of this name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |child| child.name == name)
    }

    /// The first child of this name.
    pub fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|child| child.name == name)
    }

    /// The children of the child of this name; none where there is no such child.
    pub fn list(&self, name: &str) -> &[Element] {
        self.child(name).map_or(&[], |child| &child.children)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_have_attributes_and_children() {
        let text = "<?xml version=\"1.0\"?><!-- x --><a:r n=\"&lt;1\" y=\"true\"><b i=\"3\"/> t <c><b i=\"x\"></b></c><b/></a:r>";
        let root = Element::read(text).unwrap();
        assert_eq!(
            (root.name.as_str(), root.needed("n").unwrap(), root.is("y"), root.is("n")),
            ("r", "<1", true, false)
        );
        assert_eq!(root.children.iter().map(|child| child.name.as_str()).collect::<Vec<_>>(), ["b", "c", "b"]);
        assert_eq!(root.child("b").unwrap().number::<u32>("i"), Ok(Some(3)));
        assert_eq!(root.child("b").unwrap().number::<u32>("j"), Ok(None));
        assert!(root.list("c")[0].number::<u32>("i").unwrap_err().message.contains("<b>: i=\"x\""));
        assert_eq!((root.list("d").len(), root.all("b").count()), (0, 2));
    }

    #[test]
    fn what_is_no_document_is_refused_with_its_line() {
        for (text, part) in [
            ("", "line 1: the document is not whole"),
            ("<a>\n<b></a>", "line 2"),
            ("<a>\n\n", "line 3"),
            ("<a x=\"1\" x=\"2\"/>", "line 1"),
            ("<a x=\"&unknown;\"/>", "line 1"),
            ("<a/><b/>", "not whole"),
            (&"<a>".repeat(1000), "deeper than 100"),
        ] {
            let fault = Element::read(text).unwrap_err();
            assert!(fault.message.contains(part), "{text:.30}: {fault}");
        }
    }
}
