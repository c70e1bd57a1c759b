//! Panels, lines and words of a drawing. Letters are large, so that they can be read at half the width.

use std::fmt::Write as _;

pub const WIDTH: f64 = 720.0;
pub const DARK: &str = "#222222";
pub const GREY: &str = "#767676";
pub const PALE: &str = "#dddddd";
pub const BLUE: &str = "#1f5fa8";
pub const PALE_BLUE: &str = "#c5d8ee";
pub const ORANGE: &str = "#c2540a";
pub const PALE_ORANGE: &str = "#f6d5bb";
pub const GREEN: &str = "#2f7d4f";

/// Size of letters, px.
const LETTERS: f64 = 20.0;

#[derive(Clone, Copy, PartialEq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A drawing of the width of a page.
pub struct Sheet {
    height: f64,
    body: String,
}

impl Sheet {
    pub fn new(height: f64) -> Self {
        Sheet { height, body: String::new() }
    }

    pub fn text(&mut self, at: [f64; 2], anchor: Anchor, colour: &str, words: &str) {
        self.letters(at, anchor, colour, "normal", words);
    }

    fn letters(&mut self, at: [f64; 2], anchor: Anchor, colour: &str, weight: &str, words: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let words = words.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(
            self.body,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\" fill=\"{colour}\" font-weight=\"{weight}\">{words}</text>",
            at[0], at[1]
        );
    }

    /// A numbered heading, and what is done in a line below.
    pub fn step(&mut self, top: f64, number: &str, title: &str, line: &str) {
        self.disc([16.0, top + 13.0], 15.0, BLUE);
        self.letters([16.0, top + 20.0], Anchor::Middle, "#ffffff", "bold", number);
        self.letters([42.0, top + 20.0], Anchor::Start, DARK, "bold", title);
        self.text([42.0, top + 46.0], Anchor::Start, GREY, line);
    }

    pub fn line(&mut self, points: &[[f64; 2]], colour: &str, width: f64) {
        let mut path = String::new();
        let mut pen_down = false;
        for [x, y] in points {
            if !(x.is_finite() && y.is_finite()) {
                pen_down = false;
                continue;
            }
            let _ = write!(path, "{}{x:.1},{y:.1} ", if pen_down { 'L' } else { 'M' });
            pen_down = true;
        }
        let path = path.trim_end();
        let _ = writeln!(
            self.body,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"/>"
        );
    }

    pub fn dashed(&mut self, from: [f64; 2], to: [f64; 2], colour: &str) {
        let _ = writeln!(
            self.body,
            "<path d=\"M{:.1},{:.1} L{:.1},{:.1}\" stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"6 5\"/>",
            from[0], from[1], to[0], to[1]
        );
    }

    pub fn area(&mut self, points: &[[f64; 2]], colour: &str) {
        let list: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let list = list.join(" ");
        let _ = writeln!(self.body, "<polygon points=\"{list}\" fill=\"{colour}\"/>");
    }

    pub fn disc(&mut self, at: [f64; 2], radius: f64, colour: &str) {
        let [x, y] = at;
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\" fill=\"{colour}\"/>"
        );
    }

    pub fn ring(&mut self, at: [f64; 2], radius: f64, colour: &str, width: f64) {
        let [x, y] = at;
        let _ = writeln!(
            self.body,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>"
        );
    }

    /// Half-transparent dots of one colour.
    pub fn dots(&mut self, points: &[[f64; 2]], radius: f64, colour: &str) {
        let _ = writeln!(self.body, "<g fill=\"{colour}\" fill-opacity=\"0.45\">");
        for [x, y] in points {
            let _ = writeln!(self.body, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>");
        }
        self.body.push_str("</g>\n");
    }

    pub fn bar(&mut self, left: f64, right: f64, top: f64, height: f64, colour: &str) {
        self.area(
            &[[left, top], [right, top], [right, top + height], [left, top + height]],
            colour,
        );
    }

    pub fn arrow(&mut self, from: [f64; 2], to: [f64; 2], colour: &str) {
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let length = dx.hypot(dy).max(1e-6);
        let (ux, uy) = (dx / length, dy / length);
        let base = [to[0] - 13.0 * ux, to[1] - 13.0 * uy];
        self.line(&[from, base], colour, 3.5);
        let side = |s: f64| [base[0] - s * 6.5 * uy, base[1] + s * 6.5 * ux];
        self.area(&[to, side(1.0), side(-1.0)], colour);
    }

    /// The finished file; `title` is what a screen reader says.
    pub fn finish(self, title: &str) -> String {
        let Sheet { height, body } = self;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
             font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\" font-size=\"{LETTERS}\" role=\"img\">\n\
             <title>{title}</title>\n<rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#ffffff\"/>\n{body}</svg>\n"
        )
    }
}

/// A rectangle of a sheet with axes.
#[derive(Clone, Copy)]
pub struct Panel {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
    pub x: [f64; 2],
    pub y: [f64; 2],
}

impl Panel {
    pub fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let along = (x - self.x[0]) / (self.x[1] - self.x[0]);
        let up = (y - self.y[0]) / (self.y[1] - self.y[0]);
        [self.left + along * self.width, self.top + (1.0 - up) * self.height]
    }

    pub fn points(&self, x: &[f64], y: &[f64]) -> Vec<[f64; 2]> {
        x.iter().zip(y).map(|(x, y)| self.at(*x, *y)).collect()
    }

    /// Points that lie within the axes.
    pub fn inside(&self, x: &[f64], y: &[f64]) -> Vec<[f64; 2]> {
        let within =
            |v: f64, range: [f64; 2]| v >= range[0].min(range[1]) && v <= range[0].max(range[1]);
        let pairs = x.iter().zip(y).filter(|(x, y)| within(**x, self.x) && within(**y, self.y));
        pairs.map(|(x, y)| self.at(*x, *y)).collect()
    }

    pub fn curve(&self, sheet: &mut Sheet, x: &[f64], y: &[f64], colour: &str, width: f64) {
        sheet.line(&self.points(x, y), colour, width);
    }

    /// The area between two curves, where both are known.
    pub fn band(&self, sheet: &mut Sheet, x: &[f64], low: &[f64], high: &[f64], colour: &str) {
        let known: Vec<usize> =
            (0..x.len()).filter(|i| low[*i].is_finite() && high[*i].is_finite()).collect();
        let mut points: Vec<[f64; 2]> = known.iter().map(|i| self.at(x[*i], low[*i])).collect();
        points.extend(known.iter().rev().map(|i| self.at(x[*i], high[*i])));
        sheet.area(&points, colour);
    }

    /// Frame, grid and labels: `y` stands above the axis, `x` below it at the right.
    pub fn axes(
        &self,
        sheet: &mut Sheet,
        x_ticks: &[(f64, &str)],
        y_ticks: &[(f64, &str)],
        x: &str,
    ) {
        let bottom = self.top + self.height;
        for (value, label) in y_ticks {
            let y = self.at(self.x[0], *value)[1];
            sheet.line(&[[self.left, y], [self.left + self.width, y]], PALE, 1.0);
            sheet.text([self.left - 8.0, y + 7.0], Anchor::End, GREY, label);
        }
        for (value, label) in x_ticks {
            let at = self.at(*value, self.y[0])[0];
            sheet.line(&[[at, bottom], [at, bottom + 6.0]], GREY, 1.5);
            sheet.text([at, bottom + 26.0], Anchor::Middle, GREY, label);
        }
        sheet.line(
            &[[self.left, self.top], [self.left, bottom], [self.left + self.width, bottom]],
            GREY,
            1.5,
        );
        if !x.is_empty() {
            let below = if x_ticks.is_empty() { 24.0 } else { 50.0 };
            sheet.text([self.left + self.width, bottom + below], Anchor::End, GREY, x);
        }
    }
}
