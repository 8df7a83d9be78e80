//! Numbers with few digits, as figures and tables show them.

/// Significant digits of a short number.
const DIGITS: usize = 6;

/// A number in its shortest form with at most six significant digits and a true minus sign: 0.78, not 0.7799999999999999; powers
/// of ten where plain digits would be long: 1.5×10⁻⁷. A number that is not finite is a dash.
pub fn short(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let scientific = format!("{:.*e}", DIGITS - 1, value.abs());
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if value < 0.0 { "−" } else { "" };
    if (-4..=6).contains(&exponent) {
        // Rounded already, so that the shortest form has no more digits.
        let rounded: f64 = scientific.parse().unwrap_or(value.abs());
        return format!("{sign}{rounded}");
    }
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
    if mantissa == "1" {
        return format!("{sign}{}", power_of_ten(exponent));
    }
    format!("{sign}{mantissa}×{}", power_of_ten(exponent))
}

/// A short number that shows by a point that it need not be whole: 1.0.
pub fn short_decimal(value: f64) -> String {
    let text = short(value);
    let is_whole = text.bytes().all(|byte| byte.is_ascii_digit());
    if is_whole { format!("{text}.0") } else { text }
}

/// 10ⁿ in Unicode superscripts; 1 for n = 0.
pub fn power_of_ten(n: i32) -> String {
    if n == 0 {
        return "1".to_owned();
    }
    let mut text = String::from("10");
    text.extend(n.to_string().chars().map(superscript));
    text
}

/// The digits and the minus sign that stand above the line, in order of 0 to 9.
const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

fn superscript(c: char) -> char {
    let digit = c.to_digit(10).and_then(|digit| SUPERSCRIPTS.get(digit as usize));
    digit.copied().unwrap_or('⁻')
}

/// What a raised character stands for; none for a character on the line.
pub fn lowered(c: char) -> Option<char> {
    if c == '⁻' {
        return Some('-');
    }
    let digit = SUPERSCRIPTS.iter().position(|raised| *raised == c)?;
    char::from_digit(digit as u32, 10)
}
