//! Measures and wraps the texts of drawings.

use super::layers::Size;

/// Widths of the characters from space to tilde in Helvetica, in thousandths of the font size, from
/// the font metrics that Adobe published. Arial and Liberation Sans have the same widths.
#[rustfmt::skip]
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
    1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
    333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
    556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];

/// Width of a bold text in proportion to the normal one, rounded up.
const BOLD: f64 = 1.1;

/// Distance between two lines, in proportion to the font size.
pub(super) const LINE: f64 = 1.2;

/// Separators after which a line is broken rather than at another space.
const SEPARATORS: [&str; 3] = [",", "&", "|"];

/// Estimates the width of a text in SVG units, without margins.
pub(super) fn width(text: &str, font: f64, is_bold: bool) -> f64 {
    let of_character = |c: char| match c {
        ' '..='~' => WIDTHS[c as usize - ' ' as usize],
        // Letters with accents, Greek and Cyrillic.
        '\u{0}'..='\u{1fff}' => 722,
        _ => 1000,
    };
    let thousandths: f64 = text.chars().map(of_character).map(f64::from).sum();
    thousandths / 1000.0 * font * if is_bold { BOLD } else { 1.0 }
}

/// Cuts a text off where it becomes too wide for a room in SVG units, in a font size and weight.
pub(super) fn fitting(content: &str, room: f64, (font, is_bold): (f64, bool)) -> String {
    let width = |text: &str| width(text, font, is_bold);
    if width(content) <= room {
        return content.to_owned();
    }
    let mut cut = content.to_owned();
    while cut.pop().is_some() {
        let shown = format!("{cut}...");
        if width(&shown) <= room {
            return shown;
        }
    }
    String::new()
}

/// Estimates the size of a text with these lines, including a margin. If it has a heading, that is
/// its first line, which is bold.
pub(super) fn size(lines: &[String], font: f64, has_heading: bool) -> Size {
    let widths = lines.iter().enumerate();
    let widths = widths.map(|(index, line)| width(line, font, has_heading && index == 0));
    Size {
        width: widths.fold(font, f64::max) + 16.0,
        height: lines.len() as f64 * LINE * font + 12.0,
    }
}

/// Breaks lines that have more characters than the limit: after a separator if there is one, else
/// at a space. A word that is longer than twice the limit is broken anywhere.
pub(super) fn wrap(lines: &[String], limit: usize) -> Vec<String> {
    lines.iter().flat_map(|line| broken(line, limit)).collect()
}

fn broken(line: &str, limit: usize) -> Vec<String> {
    let length = |text: &str| text.chars().count();
    if length(line) <= limit {
        return vec![line.to_owned()];
    }
    // Parts that end with a separator; those that are too long are replaced by their words.
    let mut parts: Vec<String> = Vec::new();
    let mut part = String::new();
    for word in line.split_whitespace() {
        if !part.is_empty() {
            part.push(' ');
        }
        part.push_str(word);
        if length(&part) > 1 && SEPARATORS.iter().any(|end| word.ends_with(end)) {
            parts.push(std::mem::take(&mut part));
        }
    }
    parts.push(part);
    let pieces = parts.iter().flat_map(|part| {
        if length(part) <= limit {
            vec![part.clone()]
        } else {
            let words = part.split_whitespace();
            words.flat_map(|word| cut(word, 2 * limit)).collect()
        }
    });
    let mut result: Vec<String> = Vec::new();
    for piece in pieces.filter(|piece| !piece.is_empty()) {
        match result.last_mut() {
            Some(last) if length(last) + 1 + length(&piece) <= limit => {
                last.push(' ');
                last.push_str(&piece);
            }
            _ => result.push(piece),
        }
    }
    result
}

/// Cuts a word into pieces with a maximum number of characters.
fn cut(word: &str, limit: usize) -> Vec<String> {
    let characters: Vec<char> = word.chars().collect();
    characters.chunks(limit).map(String::from_iter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn narrow_letters_take_less_room_than_wide_ones() {
        assert!(width("illi", 10.0, false) < width("WMWM", 10.0, false) / 3.0);
        assert!((width("n = 3", 10.0, false) - 22.52).abs() < 1e-9);
        assert!(width("S1", 10.0, true) > width("S1", 10.0, false));
    }

    #[test]
    fn lines_break_after_separators_first() {
        let lines = ["command != move & tx = 0 & ty != 0".to_owned()];
        assert_eq!(wrap(&lines, 24), ["command != move &", "tx = 0 & ty != 0"]);
        assert_eq!(wrap(&lines, 40), lines);
        let alternative = ["| command = move & grip".to_owned()];
        assert_eq!(wrap(&alternative, 18), ["| command = move &", "grip"]);
    }

    #[test]
    fn a_long_word_is_cut() {
        let lines = wrap(&["x".repeat(100)], 20);
        assert_eq!(lines.len(), 3);
        assert_eq!(lines.concat().len(), 100);
    }
}
