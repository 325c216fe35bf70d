//! Formulas in Unicode, as terminals show them, in MathML.

use std::fmt::Write as _;
use std::iter::Peekable;
use std::str::Chars;

/// Letters with the dots of time derivatives that Unicode has as one character.
const DOTTED: [(char, char, usize); 8] = [
    ('ẋ', 'x', 1),
    ('ẍ', 'x', 2),
    ('ẏ', 'y', 1),
    ('ÿ', 'y', 2),
    ('ż', 'z', 1),
    ('Ü', 'U', 2),
    ('Ṁ', 'M', 1),
    ('ẇ', 'w', 1),
];

/// The content of a `math` element that shows `formula`: letters with dots, primes, indices (`F_K`, `c₁₂`, `m1`) and powers,
/// numbers, roots of a symbol, operators; words of several letters are upright.
pub fn of(formula: &str) -> String {
    let mut rest = formula.chars().peekable();
    let mut markup = String::new();
    // A blank between two operands is a small space, one beside an operator is the operator's own.
    let mut after_operand = false;
    while let Some(&next) = rest.peek() {
        if next == ' ' {
            let blanks = run(&mut rest, |c| c == ' ').len();
            let before_operand = rest.peek().is_some_and(|c| c.is_alphanumeric() || "√½".contains(*c));
            if blanks > 1 {
                markup.push_str("<mspace width=\"1em\"/>");
            } else if after_operand && before_operand {
                markup.push_str("<mspace width=\"0.25em\"/>");
            }
            continue;
        }
        after_operand = is_letter(next) || next.is_ascii_digit() || ")]".contains(next) || next == '½';
        let symbol = symbol(&mut rest);
        markup.push_str(&symbol);
    }
    format!("<mrow>{markup}</mrow>")
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

/// One symbol with its index and its power.
fn symbol(rest: &mut Peekable<Chars<'_>>) -> String {
    let Some(first) = rest.next() else { return String::new() };
    let base = match first {
        '√' => return format!("<msqrt>{}</msqrt>", symbol(rest)),
        '½' => return "<mfrac><mn>1</mn><mn>2</mn></mfrac>".to_owned(),
        c if c.is_ascii_digit() => format!("<mn>{c}{}</mn>", run(rest, |c| c.is_ascii_digit() || c == '.')),
        c if is_letter(c) => letters(c, rest),
        '<' => "<mo>&lt;</mo>".to_owned(),
        '>' => "<mo>&gt;</mo>".to_owned(),
        '&' => "<mo>&amp;</mo>".to_owned(),
        c => return powered(&format!("<mo>{c}</mo>"), "", rest),
    };
    let index = if rest.next_if_eq(&'_').is_some() {
        format!("<mi>{}</mi>", run(rest, |c| c.is_ascii_alphanumeric()))
    } else {
        let digits = run(rest, |c| is_letter(first) && (c.is_ascii_digit() || subscript(c).is_some()));
        let digits: String = digits.chars().map(|c| subscript(c).unwrap_or(c)).collect();
        if digits.is_empty() { digits } else { format!("<mn>{digits}</mn>") }
    };
    powered(&base, &index, rest)
}

/// Letters of one alphabet, or a single one with dots above.
fn letters(first: char, rest: &mut Peekable<Chars<'_>>) -> String {
    let dotted = DOTTED.iter().find(|(letter, ..)| *letter == first);
    let (letter, dots) = dotted.map_or((first, 0), |(_, letter, dots)| (*letter, *dots));
    let dots = match rest.next_if(|c| matches!(c, '\u{307}' | '\u{308}')) {
        Some('\u{307}') => 1,
        Some(_) => 2,
        None => dots,
    };
    if dots > 0 {
        return format!("<mover><mi>{letter}</mi><mo>{}</mo></mover>", ["˙", "¨"][dots - 1]);
    }
    let mut word = String::from(first);
    word += &run(rest, |c| is_letter(c) && c.is_ascii() && first.is_ascii());
    format!("<mi>{word}</mi>")
}

fn subscript(c: char) -> Option<char> {
    char::from_digit((c as u32).checked_sub('₀' as u32)?, 10)
}

/// The primes, signs and powers that follow.
fn powered(base: &str, index: &str, rest: &mut Peekable<Chars<'_>>) -> String {
    let mut power = String::new();
    while let Some(&c) = rest.peek() {
        let _ = match c {
            '′' | '″' | '‴' => write!(power, "<mo>{c}</mo>"),
            '⁺' => write!(power, "<mo>+</mo>"),
            '⁻' => write!(power, "<mo>−</mo>"),
            '²' => write!(power, "<mn>2</mn>"),
            '³' => write!(power, "<mn>3</mn>"),
            'ⁿ' => write!(power, "<mi>n</mi>"),
            _ => break,
        };
        rest.next();
    }
    match (index.is_empty(), power.is_empty()) {
        (true, true) => base.to_owned(),
        (false, true) => format!("<msub>{base}{index}</msub>"),
        (true, false) => format!("<msup>{base}<mrow>{power}</mrow></msup>"),
        (false, false) => format!("<msubsup>{base}{index}<mrow>{power}</mrow></msubsup>"),
    }
}

#[cfg(test)]
mod tests {
    use super::of;

    #[test]
    fn formulas_become_symbols_indices_powers_and_operators() {
        for (formula, markup) in [
            ("m ẍ", "<mi>m</mi><mspace width=\"0.25em\"/><mover><mi>x</mi><mo>¨</mo></mover>"),
            (
                "q̇ = −U′²",
                "<mover><mi>q</mi><mo>˙</mo></mover><mo>=</mo><mo>−</mo><msup><mi>U</mi><mrow><mo>′</mo><mn>2</mn></mrow></msup>",
            ),
            (
                "F_K c₁₂ m1",
                "<msub><mi>F</mi><mi>K</mi></msub><mspace width=\"0.25em\"/><msub><mi>c</mi><mn>12</mn></msub><mspace width=\"0.25em\"/><msub><mi>m</mi><mn>1</mn></msub>",
            ),
            (
                "U_j′(φ)²",
                "<msubsup><mi>U</mi><mi>j</mi><mrow><mo>′</mo></mrow></msubsup><mo>(</mo><mi>φ</mi><msup><mo>)</mo><mrow><mn>2</mn></mrow></msup>",
            ),
            (
                "(ż⁻)²",
                "<mo>(</mo><msup><mover><mi>z</mi><mo>˙</mo></mover><mrow><mo>−</mo></mrow></msup><msup><mo>)</mo><mrow><mn>2</mn></mrow></msup>",
            ),
            (
                "½ √J < 1.5 kφ",
                "<mfrac><mn>1</mn><mn>2</mn></mfrac><mspace width=\"0.25em\"/><msqrt><mi>J</mi></msqrt><mo>&lt;</mo><mn>1.5</mn><mspace width=\"0.25em\"/><mi>k</mi><mi>φ</mi>",
            ),
            (
                "sin²φ,  tau",
                "<msup><mi>sin</mi><mrow><mn>2</mn></mrow></msup><mi>φ</mi><mo>,</mo><mspace width=\"1em\"/><mi>tau</mi>",
            ),
        ] {
            assert_eq!(of(formula), format!("<mrow>{markup}</mrow>"), "{formula}");
        }
    }
}
