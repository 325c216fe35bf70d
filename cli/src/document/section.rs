//! Typed access to the tables of a scene: every wrong value becomes a fault with its place, and reading continues.
//!
//! A read returns `None` after a reported fault, so a caller reads everything first and combines the values last.

use super::diagnostics::{Diagnostic, Diagnostics, nearest};
use super::keys::{self, Dimension, Usual};
use super::limits::{ANY, LIFT, Limits, POSITIVE, largest, within};
use super::{Document, Span, TomlTable, Value};
use super::{source, units};
use camdrive::drives::parameter::{Parameter, Parameters};
use camdrive::drives::unit::{self, Quantity};
use camdrive_design::overview::Warning;
use camdrive_design::resource::{LONGEST_NAME, Tool, is_name};
use camdrive_design::text::counted;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use toml::Spanned;

/// The most faults of a file that are listed.
const MOST_FAULTS: usize = 100;

/// Notes for users of the FMU on a smoothed table or on a contour.
#[derive(Clone, Debug, PartialEq)]
pub struct TableNote {
    /// Its section, `cam`.
    pub section: String,
    /// Lobes of U″ up to this height (per rad²) are residual noise or ripples of the smoothing.
    pub left: f64,
    /// Noise and largest change, or the misfit of the points, without a full stop.
    pub sentence: String,
    /// Says that the largest change exceeds the noise, or where the law jumps.
    pub warning: Option<Warning>,
}

/// The file and its faults so far.
pub struct Faults<'a> {
    /// Its name.
    pub file: &'a str,
    /// Its content.
    pub document: &'a Document,
    list: RefCell<Vec<(usize, Diagnostic)>>,
    /// The number of faults beyond [`MOST_FAULTS`].
    more: Cell<usize>,
    /// The place of each value that was read.
    read: RefCell<BTreeMap<String, Span>>,
    /// Notes on a scene without faults.
    notes: RefCell<Vec<String>>,
    /// The tools behind mechanisms with a prescribed motion.
    pub tools: RefCell<Vec<Tool>>,
    /// Its smoothed tables.
    pub smoothed: RefCell<Vec<TableNote>>,
    /// The files of its tables.
    pub tables: RefCell<Vec<source::TableFile>>,
    /// The kind of the whole file in messages, "a scene of this kind".
    pub kind: &'static str,
}

impl<'a> Faults<'a> {
    /// A file with this content and without faults so far.
    pub fn new(file: &'a str, document: &'a Document) -> Self {
        Faults {
            file,
            document,
            list: RefCell::default(),
            more: Cell::default(),
            read: RefCell::default(),
            notes: RefCell::default(),
            tools: RefCell::default(),
            smoothed: RefCell::default(),
            tables: RefCell::default(),
            kind: "a scene of this kind",
        }
    }

    /// A fault at these bytes; [`Faults::report`] records it.
    pub fn at(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        let fault = Diagnostic::new(self.file, message);
        // A new value has no place in the file. Counting the lines before a place takes time in proportion to the file.
        let text = self.document.file();
        if span.start <= text.len() && self.list.borrow().len() < MOST_FAULTS { fault.at(text, span) } else { fault }
    }

    /// Records a fault; drops a repetition of the same text at the same place.
    pub fn report(&self, fault: Diagnostic) {
        let order = fault.position.as_ref().filter(|_| fault.file == self.file).map_or(usize::MAX, |p| p.line);
        let mut list = self.list.borrow_mut();
        if list.len() == MOST_FAULTS {
            self.more.set(self.more.get() + 1);
        } else if !list.iter().any(|(_, known)| *known == fault) {
            list.push((order, fault));
        }
    }

    /// Records a remark for the user that is no fault.
    pub fn note(&self, text: String) {
        self.notes.borrow_mut().push(text);
    }

    /// The notes so far.
    pub fn notes(&self) -> Vec<String> {
        self.notes.borrow().clone()
    }

    /// The place of the value with this path, if it was read.
    pub fn place(&self, path: &str) -> Option<Span> {
        self.read.borrow().get(path).cloned()
    }

    /// The path and the place of the value at `path`, or of the value that it was computed from or belongs to; else of a key with
    /// this name in some section.
    pub fn origin(&self, path: &str) -> Option<(String, Span)> {
        let read = self.read.borrow();
        let whole = std::iter::successors(Some(path), |path| path.rfind(['.', '[']).map(|end| &path[..end]));
        let or_ratio = whole.flat_map(|path| {
            let (section, key) = path.rsplit_once('.').unwrap_or_default();
            let ratio = match key {
                "c" => "natural_frequency",
                "b" | "b_T" => "damping_ratio",
                _ => key,
            };
            [path.to_owned(), format!("{section}.{ratio}")]
        });
        let found = or_ratio.into_iter().find_map(|path| read.get_key_value(&path));
        let ending = format!(".{path}");
        let found = found.or_else(|| read.iter().find(|(known, _)| known.ends_with(&ending)));
        found.map(|(path, span)| (path.clone(), span.clone()))
    }

    /// True if the file has syntax errors; they may be the reason for missing values.
    pub fn broken(&self) -> bool {
        !self.document.errors.is_empty()
    }

    /// True if there are no faults so far.
    pub fn is_empty(&self) -> bool {
        self.list.borrow().is_empty()
    }

    /// All faults in the order of the file, followed by the faults of other files.
    pub fn into_diagnostics(self) -> Diagnostics {
        let mut list = self.list.into_inner();
        let file = self.file;
        let column = |d: &Diagnostic| d.position.as_ref().filter(|_| d.file == file).map_or(0, |p| p.column);
        list.sort_by_key(|(line, fault)| (*line, column(fault)));
        let more = self.more.get();
        let verb = if more == 1 { "is" } else { "are" };
        let more = (more > 0).then(|| Diagnostic::new(file, format!("there {verb} {}", counted(more, "more fault"))));
        Diagnostics(list.into_iter().map(|(_, fault)| fault).chain(more).collect())
    }

    /// The text of a value in the file, shortened to fit a message.
    fn excerpt(&self, span: &Span) -> String {
        let text = self.document.text.get(span.clone()).unwrap_or_default();
        let mut short: String = text.lines().next().unwrap_or_default().chars().take(40).collect();
        if short.len() < text.len() {
            short.push('…');
        }
        short
    }
}

/// The values; reads all of them, so that all faults are reported. None if one has a fault.
pub fn all<T>(values: impl Iterator<Item = Option<T>>) -> Option<Vec<T>> {
    values.collect::<Vec<_>>().into_iter().collect()
}

/// A value with its place.
#[derive(Clone)]
pub struct Node<'a> {
    /// For example `cam.a[2]`.
    pub path: String,
    /// The place in the file.
    pub span: Span,
    /// The value.
    pub value: &'a Value,
}

impl<'a> Node<'a> {
    /// The value of a document at its path.
    pub fn new(path: String, value: &'a Spanned<Value>) -> Self {
        Node { path, span: value.span(), value: value.get_ref() }
    }

    /// The values of a list, counted from `first`.
    pub fn items(&self, first: usize) -> Option<Vec<Node<'a>>> {
        let Value::Array(list) = self.value else { return None };
        Some((first..).zip(list).map(|(i, item)| Node::new(format!("{}[{i}]", self.path), item)).collect())
    }
}

/// A table of the scene.
pub struct Section<'a> {
    /// The file and its faults.
    pub faults: &'a Faults<'a>,
    /// Empty for the whole file.
    pub path: String,
    /// The header of the table.
    pub span: Span,
    table: &'a TomlTable,
    /// Its declared keys.
    keys: &'static keys::KeyTable,
    /// The quantity of its law, and the order of its derivative with respect to the angle.
    own: Cell<(&'static Quantity, i32)>,
    /// True if the section describes a rotation.
    turns: Cell<bool>,
    /// The keys that were read; all others are unknown.
    known: RefCell<Vec<&'static str>>,
    /// The unknown keys that were reported already.
    reported: RefCell<Vec<Span>>,
}

impl<'a> Section<'a> {
    /// Reports keys that have no meaning because of another choice.
    pub fn forbid(&self, keys: &[&'static str], because: &str, needed: &str) {
        for &key in keys {
            if self.has(key) {
                let fault = self.fault_of(key, format!(" has no meaning here: {because}"));
                self.faults.report(fault.hint(format!("remove it, or choose {needed}")));
            }
        }
    }

    /// Refuses two keys for one property; false if both exist.
    pub fn either(&self, first: &'static str, second: &'static str) -> bool {
        let both = self.has(first) && self.has(second);
        if both {
            let fault = self.fault_of(second, format!(": `{first}` determines it already"));
            self.faults.report(fault.hint(format!("give `{first}` or `{second}`, not both")));
        }
        !both
    }

    /// The whole file.
    pub fn root(faults: &'a Faults<'a>, table: &'a TomlTable, keys: &'static keys::KeyTable) -> Self {
        let (known, reported) = Default::default();
        let own = Cell::new((&unit::LENGTH, 0));
        Section { faults, path: String::new(), span: 0..0, table, keys, own, turns: Cell::new(false), known, reported }
    }

    fn sub(&self, path: String, span: Span, table: &'a TomlTable, keys: &'static keys::KeyTable) -> Self {
        let (own, turns) = (self.own.clone(), self.turns.clone());
        Section { path, span, keys, own, turns, ..Section::root(self.faults, table, keys) }
    }

    /// Sets the quantity of the section's own numbers and the order of the derivative; returns the former ones.
    pub fn of(&self, quantity: &'static Quantity, order: i32) -> (&'static Quantity, i32) {
        self.own.replace((quantity, order))
    }

    /// Sets whether the section describes a rotation.
    pub fn turning(&self, turns: bool) {
        self.turns.set(turns);
    }

    /// The first result of `find` for the kinds of values of the key.
    fn kind<T>(&self, key: &str, find: impl FnMut(keys::Value) -> Option<T>) -> T {
        let values = self.keys.key(key).values;
        values.into_iter().find_map(find).unwrap_or_else(|| panic!("{} has another kind of {key}", self.keys.title))
    }

    /// The quantity of a number, and the order of its derivative with respect to the angle.
    fn quantity(&self, of: Dimension) -> (&'static Quantity, i32) {
        match of {
            Dimension::Fixed(quantity) => (quantity, 0),
            Dimension::Motion(_, turn) if self.turns.get() => (turn, 0),
            Dimension::Motion(line, _) => (line, 0),
            Dimension::Own(n) => (self.own.get().0, self.own.get().1 + n),
            Dimension::Other => self.own.get(),
        }
    }

    /// The quantity of a number.
    pub fn quantity_of(&self, key: &str) -> &'static Quantity {
        self.declared(key).0
    }

    /// Quantity, order and range of a key for a number.
    fn declared(&self, key: &str) -> (&'static Quantity, i32, Limits) {
        let (of, limits) =
            self.kind(key, |value| if let keys::Value::Real(of, limits) = value { Some((of, limits)) } else { None });
        let (quantity, n) = self.quantity(of);
        let most = largest(quantity);
        (quantity, n, if limits.is(LIFT) { within(-most, most) } else { limits })
    }

    /// The path of a key in this table.
    pub fn path_of(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    /// True if the key exists; marks it as known.
    pub fn has(&self, key: &'static str) -> bool {
        self.node(key).is_some()
    }

    /// The value of a key, if it exists; marks it as known.
    pub fn node(&self, key: &'static str) -> Option<Node<'a>> {
        if !self.known.borrow().contains(&key) {
            self.known.borrow_mut().push(key);
        }
        let node = Node::new(self.path_of(key), self.table.get(key)?);
        self.faults.read.borrow_mut().insert(node.path.clone(), node.span.clone());
        Some(node)
    }

    /// A fault of this table as a whole; `text` follows its name.
    pub fn fault(&self, text: impl Into<String>) -> Diagnostic {
        self.faults.at(self.span.clone(), text).of(&self.path)
    }

    /// A fault of the value of `key`, or of the table without this key; `text` follows the name of the key.
    pub fn fault_of(&self, key: &'static str, text: impl Into<String>) -> Diagnostic {
        self.fault_at(key, text).of(self.path_of(key))
    }

    /// A fault at the same place whose message starts differently.
    pub fn fault_at(&self, key: &'static str, message: impl Into<String>) -> Diagnostic {
        let span = self.node(key).map_or(self.span.clone(), |node| node.span);
        self.faults.at(span, message)
    }

    /// A value; reports the fault if there is none.
    pub fn taken<T>(&self, value: Result<T, Diagnostic>) -> Option<T> {
        value.map_err(|fault| self.faults.report(fault)).ok()
    }

    /// Reports a fault; there is no value then.
    pub fn refuse<T>(&self, fault: Diagnostic) -> Option<T> {
        self.faults.report(fault);
        None
    }

    fn missing<T>(&self, key: &'static str, admissible: Option<String>, hint: String) -> Option<T> {
        if !self.faults.broken() {
            self.faults.report(Diagnostic { admissible, ..self.fault_of(key, " is missing").hint(hint) });
        }
        None
    }

    /// The value of a key similar to `key` that was not read; reports that key.
    fn misspelt(&self, key: &'static str) -> Option<&'a str> {
        let known = self.known.borrow();
        let unread: Vec<&str> =
            self.table.keys().map(|k| k.get_ref().as_str()).filter(|k| !known.contains(k)).collect();
        let wrong = nearest(key, &unread)?;
        let (place, value) = self.table.iter().find(|(k, _)| k.get_ref().as_str() == wrong)?;
        let Value::Text(text) = value.get_ref() else { return None };
        let fault = self.faults.at(place.span(), format!(" is missing; `{wrong}` is not known here"));
        self.faults.report(fault.of(self.path_of(key)).hint(format!("did you mean `{key}`?")));
        self.reported.borrow_mut().push(place.span());
        Some(text)
    }

    /// A fault of a value; `text` follows its path.
    pub fn of_node(&self, node: &Node<'_>, text: String) -> Diagnostic {
        self.faults.at(node.span.clone(), text).of(&node.path)
    }

    fn wrong_type<T>(&self, node: &Node<'_>, expected: &str) -> Option<T> {
        self.refuse(self.type_fault(node, expected))
    }

    fn type_fault(&self, node: &Node<'_>, expected: &str) -> Diagnostic {
        let found = node.value.type_str();
        let found = format!("{} {found}", if found.starts_with(['a', 'i']) { "an" } else { "a" });
        self.of_node(node, format!(": {expected} is expected, {} is {found}", self.faults.excerpt(&node.span)))
    }

    /// An optional number: a plain one is SI, a string has a unit, which may omit the angle of a derivative.
    pub fn optional(&self, key: &'static str) -> Option<Option<f64>> {
        let (quantity, n, limits) = self.declared(key);
        self.node(key).map_or(Some(None), |node| self.per_angle(&node, quantity, n, limits).map(Some))
    }

    /// A required number, or one with a default.
    pub fn real(&self, key: &'static str) -> Option<f64> {
        match self.keys.key(key).usual {
            Usual::Number(default) => self.real_or(key, default),
            _ => {
                let (quantity, n, limits) = self.declared(key);
                self.must(key, if n == 0 { quantity } else { units::per_angle(quantity, n) }, limits)?;
                self.optional(key)?
            }
        }
    }

    /// A number with a default that the declaration describes in words.
    pub fn real_or(&self, key: &'static str, default: f64) -> Option<f64> {
        self.optional(key).map(|value| value.unwrap_or(default))
    }

    /// A required number above zero; the declaration admits zero.
    pub fn positive(&self, key: &'static str) -> Option<f64> {
        let quantity = self.quantity_of(key);
        self.must(key, quantity, POSITIVE)?;
        self.number(&self.node(key)?, quantity, POSITIVE)
    }

    /// Reports a missing number.
    fn must(&self, key: &'static str, quantity: &'static Quantity, limits: Limits) -> Option<()> {
        if self.has(key) {
            return Some(());
        }
        let hint = format!("add for example {key} = {}", units::example(quantity));
        self.missing(key, Some(limits.words(quantity.unit)), hint)
    }

    /// A parameter of a drive.
    fn parameter<P>(&self, parameter: &Parameter<P>) -> Option<f64> {
        let &Parameter { key, quantity, range: [min, max], default, .. } = parameter;
        let limits = within(min, max);
        match (self.node(key), default) {
            (None, Some(default)) => Some(default),
            (None, None) => self.must(key, quantity, limits).and(None),
            (Some(node), _) => self.number(&node, quantity, limits),
        }
    }

    /// A group of parameters. `other` reads a parameter from other keys than its own: from the section, and from the parameters
    /// before it if these are valid.
    pub fn parameters<P: Parameters + Default>(
        &self,
        other: impl Fn(&Parameter<P>, Option<&P>) -> Option<Option<f64>>,
    ) -> Option<P> {
        let (mut group, mut right) = (P::default(), true);
        for parameter in P::TABLE {
            let value = other(parameter, right.then_some(&group)).unwrap_or_else(|| self.parameter(parameter));
            right &= value.is_some();
            value.into_iter().for_each(|value| (parameter.set)(&mut group, value));
        }
        right.then_some(group)
    }

    /// The number in a value.
    fn number(&self, node: &Node<'_>, quantity: &'static Quantity, limits: Limits) -> Option<f64> {
        let value = match node.value {
            Value::Float(number) => Some(*number),
            Value::Integer(number) => number.map(|number| number as f64),
            Value::Text(text) => match units::parse(text, quantity) {
                Ok(value) => Some(value),
                Err(fault) => {
                    let fault = self.of_node(node, format!(": {}", fault.message)).remedy(fault.0.hint);
                    return self.refuse(fault.admissible(limits.words(quantity.unit)));
                }
            },
            _ => {
                let fault = self.type_fault(node, "a number or a string with a unit");
                let fault = fault.admissible(limits.words(quantity.unit));
                return self.refuse(fault.hint(format!("write for example {}", units::example(quantity))));
            }
        };
        match value {
            Some(value) if limits.hold(value) => Some(value),
            _ => {
                let text = self.faults.excerpt(&node.span);
                let what = if value.is_some_and(f64::is_finite) { "out of range" } else { "not a finite number" };
                let fault = self.of_node(node, format!(": {text} is {what}"));
                // The range is in the unit of the file.
                let own = if let Value::Text(text) = node.value { units::written(text, quantity) } else { None };
                let (unit, factor) = own.unwrap_or((quantity.unit, 1.0));
                self.refuse(fault.admissible(limits.over(factor).words(unit)))
            }
        }
    }

    fn per_angle(&self, node: &Node<'_>, quantity: &'static Quantity, n: i32, limits: Limits) -> Option<f64> {
        let without = n == 0 || matches!(node.value, Value::Text(text) if units::parse(text, quantity).is_ok());
        self.number(node, if without { quantity } else { units::per_angle(quantity, n) }, limits)
    }

    /// A list of numbers; empty without the key.
    pub fn reals(&self, key: &'static str) -> Option<Vec<f64>> {
        let (quantity, n) = self.listed(key);
        self.list(key, |_, node| self.per_angle(node, quantity, n, ANY))
    }

    /// The coefficients of a polynomial in an angle; its value is the derivative of the key.
    pub fn polynomial(&self, key: &'static str) -> Option<Vec<f64>> {
        let (quantity, n) = self.listed(key);
        self.list(key, |j, node| self.per_angle(node, quantity, n + j as i32, ANY))
    }

    fn listed(&self, key: &str) -> (&'static Quantity, i32) {
        self.quantity(self.kind(key, |value| if let keys::Value::Reals(of) = value { Some(of) } else { None }))
    }

    /// A list of pairs with their places; empty without the key.
    pub fn pairs(&self, key: &'static str, of: [&'static Quantity; 2]) -> Option<Vec<([f64; 2], Span)>> {
        let pair = |_, node: &Node<'_>| match node.items(1).as_deref() {
            Some([first, second]) => {
                let [first, second] = [(first, of[0]), (second, of[1])].map(|(node, of)| self.number(node, of, ANY));
                Some(([first?, second?], node.span.clone()))
            }
            _ => {
                let [first, second] = of.map(units::example);
                let fault = self.of_node(node, ": a pair of numbers is expected".to_owned());
                self.refuse(fault.hint(format!("write for example [{first}, {second}]")))
            }
        };
        self.list(key, pair)
    }

    fn list<T>(&self, key: &'static str, read: impl Fn(usize, &Node<'_>) -> Option<T>) -> Option<Vec<T>> {
        let Some(node) = self.node(key) else { return Some(Vec::new()) };
        let Some(items) = self.items_from(&node, usize::from(key == "b")) else {
            return self.wrong_type(&node, "a list of numbers");
        };
        all(items.iter().enumerate().map(|(i, node)| read(i, node)))
    }

    /// The values of a list, counted from `first`.
    fn items_from(&self, node: &Node<'a>, first: usize) -> Option<Vec<Node<'a>>> {
        let items = node.items(first)?;
        self.faults.read.borrow_mut().extend(items.iter().map(|item| (item.path.clone(), item.span.clone())));
        Some(items)
    }

    /// A required whole number.
    pub fn count(&self, key: &'static str) -> Option<usize> {
        self.count_to(key, u32::MAX)
    }

    /// A required whole number up to `most`.
    pub fn count_to(&self, key: &'static str, most: u32) -> Option<usize> {
        let (min, max) =
            self.kind(key, |value| if let keys::Value::Count(min, max) = value { Some((min, max)) } else { None });
        let max = max.min(most);
        let admissible = format!("a whole number, {min} to {max}");
        if let (Usual::Number(default), false) = (self.keys.key(key).usual, self.has(key)) {
            return Some(default as usize);
        }
        let Some(node) = self.node(key) else {
            return self.missing(key, Some(admissible), format!("add for example {key} = {}", 16.clamp(min, max)));
        };
        let Value::Integer(value) = node.value else { return self.wrong_type(&node, "a whole number") };
        match value.filter(|v| (i64::from(min)..=i64::from(max)).contains(v)) {
            Some(value) => Some(value as usize),
            None => {
                let text = self.faults.excerpt(&node.span);
                let fault = self.of_node(&node, format!(": {text} is out of range"));
                self.refuse(fault.admissible(admissible))
            }
        }
    }

    /// true or false, the default.
    pub fn flag(&self, key: &'static str) -> Option<bool> {
        match self.node(key) {
            None => Some(false),
            Some(Node { value: Value::Boolean(value), .. }) => Some(*value),
            Some(node) => self.wrong_type(&node, "true or false"),
        }
    }

    /// An optional text.
    pub fn text(&self, key: &'static str) -> Option<Option<&'a str>> {
        match self.node(key) {
            None => Some(None),
            Some(Node { value: Value::Text(text), .. }) => Some(Some(text)),
            Some(node) => self.wrong_type(&node, "a string"),
        }
    }

    /// The values of a list; empty without the key.
    pub fn items(&self, key: &'static str, expected: &str) -> Option<Vec<Node<'a>>> {
        let Some(node) = self.node(key) else { return Some(Vec::new()) };
        node.items(1).or_else(|| self.refuse(self.fault_of(key, format!(": {expected} is expected"))))
    }

    /// A list of texts with their places; empty without the key.
    pub fn texts(&self, key: &'static str) -> Option<Vec<(&'a str, Node<'a>)>> {
        let text = |node: Node<'a>| match node.value {
            Value::Text(text) => Some((text.trim(), node)),
            _ => self.refuse(self.of_node(&node, ": a text is expected".to_owned())),
        };
        all(self.items(key, "a list of texts")?.into_iter().map(text))
    }

    /// A word in the place of a quantity.
    pub fn word(&self, key: &'static str) -> Option<&'a str> {
        match self.node(key)?.value {
            Value::Text(text) if !text.contains(|c: char| c.is_ascii_digit()) => Some(text),
            _ => None,
        }
    }

    /// Reports a word other than the admissible one of a key for numbers.
    pub fn unknown_word(&self, key: &'static str, word: &str, admissible: &str) {
        self.faults.report(self.fault_of(key, format!(": \"{word}\" is neither a number nor \"{admissible}\"")));
    }

    /// A required text.
    pub fn required_text(&self, key: &'static str, admissible: &str, example: &str) -> Option<&'a str> {
        if !self.has(key) {
            let hint = format!("add for example {key} = \"{example}\"");
            return self.missing(key, Some(admissible.to_owned()), hint);
        }
        self.text(key)?
    }

    /// One of the names of the key that `items` lists; aliases count as the usual name.
    pub fn choice<T: Copy>(&self, key: &'static str, items: &[(&'static str, T)]) -> Option<T> {
        let names = self.kind(key, |value| if let keys::Value::Choice(names) = value { Some(names) } else { None });
        let item = |usual: &str| items.iter().find(|(name, _)| *name == usual).map(|(_, item)| *item);
        if let (Usual::Name(usual), false) = (self.keys.key(key).usual, self.has(key)) {
            return item(usual);
        }
        let names: Vec<_> = names.iter().filter(|names| item(names[0]).is_some()).collect();
        let usual: Vec<&str> = names.iter().map(|names| names[0]).collect();
        // A misspelt key counts as the right one, so that everything that depends on the choice is checked.
        let meant = if self.has(key) { None } else { self.misspelt(key) };
        let text = match meant {
            Some(text) => text,
            None => self.required_text(key, &usual.join(", "), usual[0])?,
        };
        if let Some(names) = names.iter().find(|names| names.contains(&text)) {
            return item(names[0]);
        }
        let known: Vec<&str> = names.iter().flat_map(|names| names.iter().copied()).collect();
        let fault = self.fault_of(key, format!(": \"{text}\" is not known"));
        let gone = self.keys.key(key).gone.iter().find(|(name, _)| *name == text);
        let near = nearest(text, &known).filter(|_| gone.is_none());
        let guess = near.and_then(|guess| names.iter().find(|names| names.contains(&guess)));
        let hint =
            guess.map(|names| format!("did you mean `{}`?", names[0])).or(gone.map(|(_, hint)| (*hint).to_owned()));
        self.faults.report(fault.admissible(usual.join(", ")).remedy(hint));
        // Everything that depends on the choice is checked with the suggested name.
        guess.and_then(|names| item(names[0]))
    }

    /// One of several names, with a default that the declaration describes in words.
    pub fn choice_or<T: Copy>(&self, key: &'static str, items: &[(&'static str, T)], default: T) -> Option<T> {
        if self.has(key) { self.choice(key, items) } else { Some(default) }
    }

    /// The optional table under this key.
    pub fn section(&self, key: &'static str) -> Option<Option<Section<'a>>> {
        let keys = self.kind(key, |value| if let keys::Value::Table(keys) = value { Some(keys) } else { None });
        self.section_of(key, keys)
    }

    /// The optional table under this key, with other keys than the usual ones.
    pub fn section_of(&self, key: &'static str, keys: &'static keys::KeyTable) -> Option<Option<Section<'a>>> {
        let Some(node) = self.node(key) else { return Some(None) };
        match node.value {
            Value::Table(table) => Some(Some(self.sub(node.path, node.span, table, keys))),
            _ => self.wrong_type(&node, &format!("a table [{}]", node.path)),
        }
    }

    /// The result of `read` on the optional table under this key.
    pub fn read<T>(&self, key: &'static str, read: impl Fn(&Section<'a>) -> Option<T>) -> Option<Option<T>> {
        self.section(key)?.map_or(Some(None), |section| read(&section).map(Some))
    }

    /// The required table under this key.
    pub fn required_section(&self, key: &'static str) -> Option<Section<'a>> {
        self.section(key)?.or_else(|| self.missing(key, None, format!("add a section [{}]", self.path_of(key))))
    }

    /// The tables `[[key]]`; empty without the key. Their paths count from 1, like the FMU's variables.
    pub fn sections(&self, key: &'static str) -> Option<Vec<Section<'a>>> {
        let keys = self.kind(key, |value| if let keys::Value::Tables(keys) = value { Some(keys) } else { None });
        let Some(node) = self.node(key) else { return Some(Vec::new()) };
        let Some(items) = self.items_from(&node, 1) else {
            return self.wrong_type(&node, &format!("a list of tables [[{}]]", node.path));
        };
        let table = |node: Node<'a>| match node.value {
            Value::Table(table) => Some(self.sub(node.path, node.span, table, keys)),
            _ => self.wrong_type(&node, "a table"),
        };
        items.into_iter().map(table).collect()
    }

    /// The tables [key.NAME] with their names, in the order of the file; empty without the key.
    pub fn named(&self, key: &'static str) -> Option<Vec<(&'a str, Section<'a>)>> {
        let keys = self.kind(key, |value| if let keys::Value::Named(keys) = value { Some(keys) } else { None });
        let Some(node) = self.node(key) else { return Some(Vec::new()) };
        let Value::Table(table) = node.value else {
            return self.wrong_type(&node, &format!("tables [{}.NAME]", node.path));
        };
        let mut list = Vec::new();
        for (name, item) in table {
            let node = Node::new(format!("{}.{}", node.path, name.get_ref()), item);
            self.faults.read.borrow_mut().insert(node.path.clone(), item.span());
            match node.value {
                Value::Table(table) => list.push((&**name.get_ref(), self.sub(node.path, node.span, table, keys))),
                _ => self.wrong_type(&node, &format!("a table [{}]", node.path)).unwrap_or_default(),
            }
        }
        list.sort_by_key(|(_, section)| section.span.start);
        (list.len() == table.len()).then_some(list)
    }

    /// The results of `read` on the tables `[[key]]`.
    pub fn each<T>(&self, key: &'static str, read: impl FnMut(&Section<'a>) -> Option<T>) -> Option<Vec<T>> {
        all(self.sections(key)?.iter().map(read))
    }

    /// The name of the scene or task.
    pub fn name(&self) -> Option<String> {
        let admissible = format!(
            "letters, digits and _, no digit first, at most {LONGEST_NAME} characters; no device of Windows such as CON"
        );
        let name = self.required_text("name", &admissible, "guide_bar")?;
        if is_name(name) {
            return Some(name.to_owned());
        }
        let mut better: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if !better.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
            better.insert(0, '_');
        }
        better.truncate(LONGEST_NAME);
        if !better.contains(|c: char| c.is_ascii_alphanumeric()) {
            better = "guide_bar".to_owned();
        }
        if !is_name(&better) {
            better.push('_');
        }
        let fault = self.fault_at("name", format!(": \"{name}\" cannot name an FMU")).of("name");
        self.refuse(fault.admissible(admissible).hint(format!("write for example \"{better}\"")))
    }

    /// Reports the keys that were not read.
    pub fn finish(&self) {
        if self.faults.broken() {
            return;
        }
        let known = self.known.borrow();
        let unknown = |key: &&Spanned<String>| !known.contains(&key.get_ref().as_str());
        for key in self.table.keys().filter(unknown).filter(|key| !self.reported.borrow().contains(&key.span())) {
            let name = key.get_ref().as_str();
            let place =
                if self.path.is_empty() { format!("in {}", self.faults.kind) } else { format!("in [{}]", self.path) };
            let fault = self.faults.at(key.span(), format!(" is not known {place}")).of(self.path_of(name));
            let meant = self.keys.all().find(|key| key.also.contains(&name) && known.contains(&key.key));
            let meant = meant.map(|meant| meant.key).or_else(|| nearest(name, &known));
            // A key of another choice is no slip.
            let other =
                self.keys.all().find(|key| key.key == name).map(|key| match key.meaning.trim().split_once(": ") {
                    Some((of, _)) if of.starts_with('`') => format!("it belongs to {of}"),
                    _ if !key.models.is_empty() => format!("it belongs to the model {}", key.models.join(", ")),
                    _ => "it belongs to another choice in this section".to_owned(),
                });
            let hint = other.or_else(|| meant.map(|right| format!("did you mean `{right}`?")));
            self.faults.report(fault.admissible(known.join(", ")).remedy(hint));
        }
    }
}
