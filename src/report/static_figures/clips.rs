//! Names of clipping paths that are the same each time.

/// How the names of clipping paths begin that the library counts over all figures of a process.
const CLIP: &str = "kuva-clip-";

/// A drawing whose clipping paths are counted from 0: the same tables then give the same bytes, whichever figure is drawn
/// first.
pub fn numbered_anew(svg: &str) -> String {
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
    out
}
