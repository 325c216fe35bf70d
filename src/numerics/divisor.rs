//! Whole numbers: the greatest common divisor.

/// The greatest common divisor; for 0 and n it is n.
pub fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_several_numbers() {
        let of = |list: &[usize]| list.iter().copied().fold(0, greatest_common_divisor);
        assert_eq!([of(&[]), of(&[7]), of(&[12, 18, 8]), of(&[3, 5])], [0, 7, 2, 1]);
    }
}
