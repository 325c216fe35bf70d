//! The page of a live scene: one file with all that it computes with.

use super::{BUILD, Dial, dials, dials::element, dials::section};
use crate::export::RuntimeLibrary;
use crate::scene::Resolved;
use camdrive::drives::Fault;
use camdrive_design::report::{Report, html};
use camdrive_design::xml::writer::Xml;
use serde_json::json;

/// Below the folders of runtime libraries.
const FILE: &str = "wasm/camdrive.wasm.lzma";

/// The module of pages, packed, in letters.
pub struct Module(String);

impl Module {
    /// Where to get it.
    pub const MISSING: &str = "there is no module for pages that compute: the wheel or `packaging/build wasm` adds it";

    /// The module at hand; None without one.
    ///
    /// # Errors
    /// A module that cannot be read, or of other sources.
    pub fn at_hand() -> Result<Option<Self>, Fault> {
        let Some(path) = RuntimeLibrary::places(FILE)?.into_iter().find(|path| path.is_file()) else { return Ok(None) };
        let unreadable = |e: std::io::Error| Fault::new(format!("{} cannot be read: {e}", path.display()));
        let bytes = std::fs::read(&path).map_err(unreadable)?;
        // The name of the sources is behind the packed module.
        if !bytes.ends_with(BUILD.as_bytes()) {
            let message = format!("{} is built from other sources than this executable ({BUILD})", path.display());
            return Err(Fault::new(message).hint("rebuild it with `packaging/build wasm`"));
        }
        Ok(Some(Module(letters(&bytes[..bytes.len() - BUILD.len()]))))
    }

    /// The page of a scene: the reports that follow its values, and others, which show it as the file has it.
    pub fn page(&self, scene: &Resolved, others: Vec<Report>) -> String {
        self.page_of(scene, super::reports(scene, |_| ()), others)
    }

    /// The same with the verdict alone, until the page computes the rest when it is opened: in an FMU that is in index.html, too, and
    /// the last digits of numbers would differ with the platform of the export.
    pub fn small_page(&self, scene: &Resolved) -> String {
        let mut reports = super::reports(scene, |_| ());
        reports.truncate(1);
        self.page_of(scene, reports, Vec::new())
    }

    fn page_of(&self, scene: &Resolved, mut reports: Vec<Report>, others: Vec<Report>) -> String {
        let sources = scene.sources();
        let files = sources.iter().map(|(name, content)| (name, String::from_utf8_lossy(content)));
        let engine = html::Engine {
            follow: reports.len(),
            form: form(&dials(&scene.document), scene),
            module: self.0.clone(),
            // Markup ends at this sign.
            files: json!(files.collect::<Vec<_>>()).to_string().replace('<', "\\u003c"),
        };
        reports.extend(others);
        html::live(&scene.name, &reports, &engine)
    }
}

/// Five letters for four bytes, in digits to the base 85: those from `(` on without `<` and `>`, at which markup would end.
fn letters(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(4) * 5);
    for part in bytes.chunks(4) {
        let word = (0..4).fold(0, |word, i| word << 8 | u32::from(*part.get(i).unwrap_or(&0)));
        let letter = |digit: u32| {
            char::from(digit as u8 + [b'(', b')', b'*'][usize::from(digit > 19) + usize::from(digit > 20)])
        };
        text.extend([85 * 85 * 85 * 85, 85 * 85 * 85, 85 * 85, 85, 1].map(|power| letter(word / power % 85)));
    }
    text
}

/// Sliders and fields, grouped as in the scene.
fn form(dials: &[Dial], scene: &Resolved) -> String {
    let mut xml = Xml::part();
    let drive = scene.resource().build();
    // Studies name variables of the FMU, too.
    let variable = |dial: &Dial| {
        let known = drive.as_ref().ok()?.descriptions().iter().find(|of| of.key == dial.key && of.name != dial.key)?;
        Some(("data-variable", known.name.clone()))
    };
    let of = |key: &str, value: &str| -> Vec<(&'static str, String)> {
        vec![("data-key", key.to_owned()), ("value", value.to_owned())]
    };
    let plain = |dial: &Dial| dial.meaning.replace('`', "");
    let group = |dial: &Dial| section(&dial.key).to_owned();
    let mut groups: Vec<String> = dials.iter().map(group).collect();
    groups.dedup();
    let mut seen: Vec<String> = Vec::new();
    groups.retain(|name| {
        !seen.contains(name) && {
            seen.push(name.clone());
            true
        }
    });
    for name in &groups {
        let own: Vec<(usize, &Dial)> = dials.iter().enumerate().filter(|(_, dial)| group(dial) == *name).collect();
        let is_list = own.iter().any(|(_, dial)| element(&dial.key).is_some());
        let fields = |xml: &mut Xml| {
            if !is_list {
                xml.text("legend", &[], name);
            }
            for (i, dial) in &own {
                let (id, told) = (format!("d{i}"), format!("f{i}"));
                let last = dial.key.rsplit('.').next().unwrap_or("");
                let meaning = Some(plain(dial)).filter(|_| !is_list);
                xml.element("div", &[("class", "dial".to_owned())], |xml| {
                    let title = meaning.clone().map(|meaning| ("title", meaning));
                    xml.text("label", &Vec::from_iter([("for", id.clone())].into_iter().chain(title)), last);
                    let field = [("id", id.clone()), ("type", "text".to_owned()), ("aria-describedby", told.clone())];
                    xml.empty(
                        "input",
                        &[field.to_vec(), of(&dial.key, &dial.text), Vec::from_iter(variable(dial))].concat(),
                    );
                    if let Some([low, high]) = dial.ends {
                        let label = [Some(format!("{} (slider)", dial.key)), meaning].into_iter().flatten();
                        let label = Vec::from_iter(label).join(": ");
                        let slider = [("type", "range".to_owned()), ("aria-label", label)];
                        let ends = [("min", low.to_string()), ("max", high.to_string()), ("step", "any".to_owned())];
                        xml.empty(
                            "input",
                            &[slider.to_vec(), ends.to_vec(), of(&dial.key, &dial.value.to_string())].concat(),
                        );
                    }
                    xml.text("span", &[("id", told), ("class", "fault".to_owned()), ("role", "alert".to_owned())], "");
                });
            }
        };
        // A list is folded, lest it hides the others; its numbers have one meaning.
        match is_list {
            true => xml.element("details", &[], |xml| {
                xml.text("summary", &[("title", plain(own[0].1))], name);
                xml.element("fieldset", &[("aria-label", name.clone())], fields);
            }),
            false => xml.element("fieldset", &[], fields),
        }
    }
    xml.finish()
}

#[cfg(test)]
mod tests {
    use super::letters;

    #[test]
    fn four_bytes_are_five_letters_which_end_no_markup() {
        assert_eq!(letters(&[0, 0, 0, 0, 0, 0, 0, 19, 0, 0, 0, 20, 0, 0, 0, 84]), "(((((((((;((((=((((~");
        let all: Vec<u8> = (0..=255).cycle().take(4096).collect();
        assert!(letters(&all).len() == 5120 && !letters(&all).contains(['<', '>', '&']));
    }
}
