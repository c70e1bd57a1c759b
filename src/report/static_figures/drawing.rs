//! The text of a drawing: the same bytes each time, and no characters that XML forbids.

/// How the names of clipping paths begin that the library counts over all figures of a process.
const CLIP: &str = "kuva-clip-";

/// A drawing whose clipping paths are counted from 0: the same tables then give the same bytes, whichever figure is drawn
/// first. Control characters, which a log's names may have, are blanks.
pub(crate) fn finished(svg: &str) -> String {
    let mut known: Vec<&str> = Vec::new();
    let mut pieces = svg.split(CLIP);
    let mut out = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let digits = piece.len() - piece.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (number, rest) = piece.split_at(digits);
        let place = known.iter().position(|n| *n == number).unwrap_or_else(|| {
            known.push(number);
            known.len() - 1
        });
        out.push_str(&format!("{CLIP}{place}{rest}"));
    }
    let forbidden = |c: char| {
        (c.is_control() && !matches!(c, '\n' | '\t')) || matches!(c, '\u{fffe}' | '\u{ffff}')
    };
    if out.contains(forbidden) { out.replace(forbidden, " ") } else { out }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_of_names_do_not_break_the_drawing() {
        let svg = format!("<text>a\u{1}b\u{7f}c\u{ffff}</text>\n<g clip=\"{CLIP}17\"/>");
        assert_eq!(finished(&svg), format!("<text>a b c </text>\n<g clip=\"{CLIP}0\"/>"));
    }
}
