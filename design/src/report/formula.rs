//! Formulas in Unicode, as terminals show them, in HTML that any font can show.

use std::fmt::Write as _;
use std::iter::Peekable;
use std::str::Chars;

/// Markup that shows `formula`: italic letters, indices (`F_K`, `c₁₂`, `m1`) and powers, roots of a symbol; words of several letters
/// are upright, and dots, primes and operators stay as they are.
pub fn markup(formula: &str) -> String {
    let mut rest = formula.chars().peekable();
    let mut text = String::new();
    while let Some(&next) = rest.peek() {
        match next {
            // Wider, since blanks of HTML run together.
            ' ' => text.push(if run(&mut rest, |c| c == ' ').len() > 1 { '\u{2003}' } else { ' ' }),
            _ => text += &symbol(&mut rest),
        }
    }
    text
}

fn is_letter(c: char) -> bool {
    c.is_alphabetic() && !matches!(c, 'Σ' | 'ⁿ') && subscript(c).is_none()
}

fn run(rest: &mut Peekable<Chars<'_>>, belongs: impl Fn(char) -> bool) -> String {
    let mut text = String::new();
    while let Some(c) = rest.next_if(|c| belongs(*c)) {
        text.push(c);
    }
    text
}

/// One symbol with its index, its primes and its power.
fn symbol(rest: &mut Peekable<Chars<'_>>) -> String {
    let Some(first) = rest.next() else { return String::new() };
    let mut markup = match first {
        '√' => return format!("√<span class=\"root\">{}</span>", symbol(rest)),
        c if is_letter(c) => letters(c, rest),
        '<' => "&lt;".to_owned(),
        '>' => "&gt;".to_owned(),
        '&' => "&amp;".to_owned(),
        c => c.to_string(),
    };
    let index = match rest.next_if_eq(&'_') {
        Some(_) => run(rest, |c| c.is_ascii_alphanumeric()),
        None => run(rest, |c| is_letter(first) && (c.is_ascii_digit() || subscript(c).is_some())),
    };
    // Writing to a String cannot fail.
    if !index.is_empty() {
        let index: String = index.chars().map(|c| subscript(c).unwrap_or(c)).collect();
        let _ = write!(markup, "<sub>{index}</sub>");
    }
    markup += &run(rest, |c| "′″‴".contains(c));
    let power: String = run(rest, |c| superscript(c).is_some()).chars().filter_map(superscript).collect();
    if !power.is_empty() {
        let _ = write!(markup, "<sup>{power}</sup>");
    }
    markup
}

/// A word, or a single letter with dots above.
fn letters(first: char, rest: &mut Peekable<Chars<'_>>) -> String {
    let mut word = String::from(first);
    word += &run(rest, |c| matches!(c, '\u{307}' | '\u{308}') || is_letter(c) && c.is_ascii() && first.is_ascii());
    let is_word = word.chars().filter(|c| is_letter(*c)).count() > 1;
    if is_word { word } else { format!("<i>{word}</i>") }
}

fn subscript(c: char) -> Option<char> {
    char::from_digit((c as u32).checked_sub('₀' as u32)?, 10)
}

fn superscript(c: char) -> Option<char> {
    let (_, plain) =
        [('⁺', '+'), ('⁻', '−'), ('²', '2'), ('³', '3'), ('ⁿ', 'n')].into_iter().find(|(high, _)| *high == c)?;
    Some(plain)
}

#[cfg(test)]
mod tests {
    use super::markup;

    #[test]
    fn formulas_become_symbols_indices_powers_and_operators() {
        for (formula, expected) in [
            ("m ẍ", "<i>m</i> <i>ẍ</i>"),
            ("q̇ = −U′²", "<i>q̇</i> = −<i>U</i>′<sup>2</sup>"),
            ("F_K c₁₂ m1", "<i>F</i><sub>K</sub> <i>c</i><sub>12</sub> <i>m</i><sub>1</sub>"),
            ("U_j′(φ)²", "<i>U</i><sub>j</sub>′(<i>φ</i>)<sup>2</sup>"),
            ("(ż⁻)²", "(<i>ż</i><sup>−</sup>)<sup>2</sup>"),
            ("½ √J < 1.5 kφ", "½ √<span class=\"root\"><i>J</i></span> &lt; 1.5 <i>k</i><i>φ</i>"),
            ("sin²φ,  tau", "sin<sup>2</sup><i>φ</i>,\u{2003}tau"),
        ] {
            assert_eq!(markup(formula), expected, "{formula}");
        }
    }
}
