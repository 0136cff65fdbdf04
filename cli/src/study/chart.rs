//! Diagrams of logarithmic axes as SVG.
//!
//! Written here rather than with a plotting crate: the figures take their colours from style sheets, so that
//! they follow light and dark mode, and their marks have titles, which browsers show and screen readers tell.
//! Series differ in colour, in the form of their marks and in the dashes of their lines.

use super::outcome::EXACT;
use std::fmt::Write;

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 470.0;
/// Margins: left, right (with the legend), top, bottom.
const LEFT: f64 = 78.0;
const RIGHT: f64 = 236.0;
const TOP: f64 = 16.0;
const BOTTOM: f64 = 58.0;

/// Colours and forms before they are used again.
pub const STYLES: usize = 8;

/// Style of all figures; colours are those of Okabe and Ito, which the colour-blind tell apart, darker on a
/// white ground and lighter on a dark one.
pub const STYLE: &str = "\
.chart{--ink:#1b1f24;--soft:#6b7280;--rule:#d5d9df;--c0:#0072b2;--c1:#d55e00;--c2:#007f5c;--c3:#a8447e;\
--c4:#a87100;--c5:#3787bd;--c6:#3b3f46;--c7:#7a7000;font:13px system-ui,sans-serif;fill:var(--ink)}\
@media (prefers-color-scheme:dark){.chart{--ink:#e6e8eb;--soft:#9aa3ad;--rule:#3a414a;--c0:#5ab4e5;--c1:#ff8a3d;\
--c2:#3dd6a6;--c3:#f0a3cc;--c4:#ffc24d;--c5:#9ad3f5;--c6:#d3d7dc;--c7:#e5db5a}}\
.chart .rule{stroke:var(--rule);stroke-width:1}.chart .minor{stroke-opacity:.45}.chart .soft{fill:var(--soft)}\
.chart .guide{stroke:var(--soft);stroke-width:1.2;stroke-dasharray:2 4;fill:none}\
.chart .front{stroke:var(--ink);stroke-width:9;stroke-opacity:.13;fill:none;stroke-linejoin:round;stroke-linecap:round}\
.chart .line{fill:none;stroke-width:1.8}.chart .mark{stroke-width:1.6;fill-opacity:.22}\
.chart .mark:hover,.chart .mark:focus{fill-opacity:1}.chart .whisker{stroke-width:1.2}\
.chart .s0{stroke:var(--c0);fill:var(--c0)}.chart .s1{stroke:var(--c1);fill:var(--c1)}\
.chart .s2{stroke:var(--c2);fill:var(--c2)}.chart .s3{stroke:var(--c3);fill:var(--c3)}\
.chart .s4{stroke:var(--c4);fill:var(--c4)}.chart .s5{stroke:var(--c5);fill:var(--c5)}\
.chart .s6{stroke:var(--c6);fill:var(--c6)}.chart .s7{stroke:var(--c7);fill:var(--c7)}.chart .line{fill:none}";

/// A place in a diagram.
#[derive(Debug, Clone)]
pub struct Mark {
    /// Both above 0.
    pub x: f64,
    /// Both above 0.
    pub y: f64,
    /// Smallest and largest x, if it was measured several times.
    pub range: Option<(f64, f64)>,
    /// What is told of it.
    pub tip: String,
}

/// Marks that belong together.
#[derive(Debug, Clone)]
pub struct Series {
    /// Its name.
    pub label: String,
    /// In the order in which they are joined.
    pub marks: Vec<Mark>,
}

/// A diagram of two logarithmic axes.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    /// What it shows, for those who do not see it.
    pub title: String,
    /// What x is.
    pub x: String,
    /// What y is.
    pub y: String,
    /// What is shown.
    pub series: Vec<Series>,
    /// Slopes y ~ xᵖ that are shown as lines.
    pub slopes: Vec<f64>,
    /// Places joined by a broad line behind the marks, by rising x.
    pub front: Vec<(f64, f64)>,
}

/// A logarithmic axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    /// Decimal logarithms at its ends.
    low: f64,
    high: f64,
    /// Coordinates of its ends in the figure.
    from: f64,
    to: f64,
}

impl Axis {
    fn of(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Option<Self> {
        let logs: Vec<f64> = values.map(f64::log10).filter(|log| log.is_finite()).collect();
        let low = logs.iter().copied().fold(f64::INFINITY, f64::min);
        let high = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if low > high {
            return None;
        }
        let room = (0.06 * (high - low)).max(0.1);
        Some(Self { low: low - room, high: high + room, from, to })
    }

    fn at(&self, value: f64) -> f64 {
        let log = value.log10().clamp(self.low, self.high);
        self.from + (log - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Places of rules: value, and whether it has a label.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let decades = self.high - self.low;
        let every = (decades / 8.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for exponent in self.low.floor() as i32..=self.high.ceil() as i32 {
            let power = 10.0_f64.powi(exponent);
            ticks.push((power, exponent.rem_euclid(every) == 0));
            if decades < 4.0 {
                ticks.extend((2..10).map(|k| (f64::from(k) * power, decades < 1.7 && [2, 5].contains(&k))));
            }
        }
        ticks.retain(|(value, _)| (self.low..=self.high).contains(&value.log10()));
        ticks
    }
}

impl Chart {
    /// The figure, or a line where there is nothing to be shown. It takes its colours from [`STYLE`], which
    /// is part of it if it `stands_alone`.
    pub fn svg(&self, stands_alone: bool) -> String {
        let marks = || self.series.iter().flat_map(|series| &series.marks);
        let x = Axis::of(
            marks().flat_map(|mark| [mark.x, mark.range.map_or(mark.x, |r| r.0), mark.range.map_or(mark.x, |r| r.1)]),
            LEFT,
            WIDTH - RIGHT,
        );
        // What is exact but for round-off stands at the lower edge: it shall not press the others together.
        let inexact = |y: &f64| *y >= EXACT;
        let y = Axis::of(marks().map(|mark| mark.y).filter(inexact), HEIGHT - BOTTOM, TOP)
            .or_else(|| Axis::of(marks().map(|mark| mark.y), HEIGHT - BOTTOM, TOP));
        let (Some(x), Some(y)) = (x, y) else {
            return "<p>Nothing to be shown: no run gave a number above 0.</p>".into();
        };
        let mut out = String::new();
        let title = escaped(&self.title);
        let _ = write!(
            out,
            "<svg class=\"chart\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" \
             aria-label=\"{title}\">"
        );
        if stands_alone {
            let ground = "svg{background:#fff}@media (prefers-color-scheme:dark){svg{background:#15181c}}";
            let _ = write!(out, "<style>{STYLE}{ground}</style>");
        }
        self.axes(&x, &y, &mut out);
        self.guides(&x, &y, &mut out);
        if self.front.len() > 1 {
            let places: Vec<String> =
                self.front.iter().map(|(a, b)| format!("{:.1},{:.1}", x.at(*a), y.at(*b))).collect();
            let _ = write!(out, "<polyline class=\"front\" points=\"{}\"/>", places.join(" "));
        }
        for (index, series) in self.series.iter().enumerate() {
            draw_series(series, index, &x, &y, &mut out);
        }
        self.legend(&mut out);
        out + "</svg>\n"
    }

    fn axes(&self, x: &Axis, y: &Axis, out: &mut String) {
        let (bottom, right) = (HEIGHT - BOTTOM, WIDTH - RIGHT);
        for (value, labelled) in x.ticks() {
            let at = x.at(value);
            let class = if labelled { "rule" } else { "rule minor" };
            let _ = write!(out, "<line class=\"{class}\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{TOP}\" y2=\"{bottom}\"/>");
            if labelled {
                let low = bottom + 20.0;
                let _ = write!(out, "<text x=\"{at:.1}\" y=\"{low}\" text-anchor=\"middle\">{}</text>", tick(value));
            }
        }
        for (value, labelled) in y.ticks() {
            let at = y.at(value);
            let class = if labelled { "rule" } else { "rule minor" };
            let _ = write!(out, "<line class=\"{class}\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>");
            if labelled {
                let (left, low) = (LEFT - 8.0, at + 4.5);
                let _ = write!(out, "<text x=\"{left}\" y=\"{low:.1}\" text-anchor=\"end\">{}</text>", tick(value));
            }
        }
        let (middle, low) = (0.5 * (LEFT + right), HEIGHT - 12.0);
        let _ = write!(out, "<text x=\"{middle}\" y=\"{low}\" text-anchor=\"middle\">{}</text>", escaped(&self.x));
        let height = 0.5 * (TOP + bottom);
        let _ = write!(
            out,
            "<text transform=\"translate(18 {height}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escaped(&self.y)
        );
    }

    /// Lines of the slopes, through the lower right corner of the marks.
    fn guides(&self, x: &Axis, y: &Axis, out: &mut String) {
        for slope in &self.slopes {
            // From the middle of the lower edge to the right or to the top, whichever comes first.
            let (a, b) = (x.low + 0.45 * (x.high - x.low), y.low + 0.04 * (y.high - y.low));
            let end = x.high.min(a + (y.high - b) / slope);
            let place = |log: f64| (x.at(10.0_f64.powf(log)), y.at(10.0_f64.powf(b + slope * (log - a))));
            let ((x0, y0), (x1, y1)) = (place(a), place(end));
            let _ = write!(out, "<line class=\"guide\" x1=\"{x0:.1}\" y1=\"{y0:.1}\" x2=\"{x1:.1}\" y2=\"{y1:.1}\"/>");
            let (tx, ty) = (x1 - 8.0, y1 - 4.0);
            let _ = write!(
                out,
                "<text class=\"soft\" x=\"{tx:.1}\" y=\"{ty:.1}\" text-anchor=\"end\">order {slope}</text>"
            );
        }
    }

    fn legend(&self, out: &mut String) {
        let x = WIDTH - RIGHT + 22.0;
        let shown = self.series.iter().enumerate().filter(|(_, series)| !series.marks.is_empty());
        for (row, (index, series)) in shown.enumerate() {
            let y = TOP + 10.0 + 21.0 * row as f64;
            let (class, dashes) = style(index);
            let _ = write!(
                out,
                "<line class=\"line {class}\"{dashes} x1=\"{x}\" x2=\"{:.1}\" y1=\"{y}\" y2=\"{y}\"/>",
                x + 26.0
            );
            let _ = write!(out, "<path class=\"mark {class}\" d=\"{}\"/>", form(index, x + 13.0, y));
            let (text, low) = (x + 34.0, y + 4.5);
            let _ = write!(out, "<text x=\"{text}\" y=\"{low}\">{}</text>", escaped(&shortened(&series.label, 26)));
        }
        if self.front.len() > 1 {
            let y = TOP + 14.0 + 21.0 * self.series.iter().filter(|s| !s.marks.is_empty()).count() as f64;
            let (end, text, low) = (x + 26.0, x + 34.0, y + 4.5);
            let _ = write!(out, "<line class=\"front\" x1=\"{x}\" x2=\"{end}\" y1=\"{y}\" y2=\"{y}\"/>");
            let _ = write!(out, "<text class=\"soft\" x=\"{text}\" y=\"{low}\">nothing is better (Pareto)</text>");
        }
    }
}

fn draw_series(series: &Series, index: usize, x: &Axis, y: &Axis, out: &mut String) {
    let (class, dashes) = style(index);
    let places: Vec<(f64, f64)> = series.marks.iter().map(|mark| (x.at(mark.x), y.at(mark.y))).collect();
    let line: Vec<String> = places.iter().map(|(a, b)| format!("{a:.1},{b:.1}")).collect();
    let _ = write!(out, "<g><polyline class=\"line {class}\"{dashes} points=\"{}\"/>", line.join(" "));
    for (mark, (a, b)) in series.marks.iter().zip(places) {
        if let Some((low, high)) = mark.range {
            let (low, high) = (x.at(low), x.at(high));
            let _ = write!(
                out,
                "<line class=\"whisker {class}\" x1=\"{low:.1}\" x2=\"{high:.1}\" y1=\"{b:.1}\" y2=\"{b:.1}\"/>"
            );
        }
        let tip = escaped(&mark.tip);
        let _ = write!(
            out,
            "<path class=\"mark {class}\" tabindex=\"0\" d=\"{}\"><title>{tip}</title></path>",
            form(index, a, b)
        );
    }
    *out += "</g>";
}

/// Class and dashes of a series.
fn style(index: usize) -> (String, &'static str) {
    const DASHES: [&str; 3] = ["", " stroke-dasharray=\"7 3\"", " stroke-dasharray=\"2 3\""];
    (format!("s{}", index % STYLES), DASHES[index / STYLES % DASHES.len()])
}

/// Outline of a mark around a place.
fn form(index: usize, x: f64, y: f64) -> String {
    // Where colours are used again, forms are not the same.
    let index = index + 3 * (index / STYLES);
    let outline = |corners: &[(f64, f64)]| {
        let places: Vec<String> = corners.iter().map(|(a, b)| format!("{:.1} {:.1}", x + a, y + b)).collect();
        format!("M{}Z", places.join("L"))
    };
    match index % STYLES {
        1 => outline(&[(-4.4, -4.4), (4.4, -4.4), (4.4, 4.4), (-4.4, 4.4)]),
        2 => outline(&[(0.0, -5.8), (5.4, 4.0), (-5.4, 4.0)]),
        3 => outline(&[(0.0, -6.2), (6.2, 0.0), (0.0, 6.2), (-6.2, 0.0)]),
        4 => outline(&[(0.0, 5.8), (5.4, -4.0), (-5.4, -4.0)]),
        5 => outline(&[(-5.4, 0.0), (-2.7, -4.7), (2.7, -4.7), (5.4, 0.0), (2.7, 4.7), (-2.7, 4.7)]),
        6 => outline(&[
            (-1.8, -5.4),
            (1.8, -5.4),
            (1.8, -1.8),
            (5.4, -1.8),
            (5.4, 1.8),
            (1.8, 1.8),
            (1.8, 5.4),
            (-1.8, 5.4),
            (-1.8, 1.8),
            (-5.4, 1.8),
            (-5.4, -1.8),
            (-1.8, -1.8),
        ]),
        7 => outline(&[
            (0.0, -6.0),
            (1.8, -1.8),
            (6.0, 0.0),
            (1.8, 1.8),
            (0.0, 6.0),
            (-1.8, 1.8),
            (-6.0, 0.0),
            (-1.8, -1.8),
        ]),
        _ => format!("M{:.1} {y:.1}a4.8 4.8 0 1 0 9.6 0a4.8 4.8 0 1 0 -9.6 0Z", x - 4.8),
    }
}

/// A power of ten with its exponent raised, or a small multiple of one.
fn tick(value: f64) -> String {
    let exponent = value.log10().floor() as i32;
    let digit = (value / 10.0_f64.powi(exponent)).round() as i32;
    if (-2..=3).contains(&exponent) {
        return format!("{}", f64::from(digit) * 10.0_f64.powi(exponent)).chars().take(6).collect();
    }
    let raised: String = exponent.to_string().chars().map(raise).collect();
    if digit == 1 { format!("10{raised}") } else { format!("{digit}·10{raised}") }
}

fn raise(c: char) -> char {
    match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        _ => '⁹',
    }
}

fn shortened(text: &str, most: usize) -> String {
    match text.chars().count() > most {
        true => text.chars().take(most - 1).collect::<String>() + "…",
        false => text.into(),
    }
}

/// Text for HTML and SVG.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark(x: f64, y: f64) -> Mark {
        Mark { x, y, range: None, tip: "a < b".into() }
    }

    #[test]
    fn marks_stand_where_their_logarithms_are() {
        let marks = vec![mark(0.01, 1e-4), mark(0.1, 1e-3), mark(1.0, 1e-2)];
        let chart =
            Chart { series: vec![Series { label: "A & B".into(), marks }], slopes: vec![1.0], ..Chart::default() };
        let svg = chart.svg(true);
        let axis = Axis::of([0.01, 0.1, 1.0].into_iter(), 0.0, 100.0).unwrap();
        assert!((axis.at(0.1) - 50.0).abs() < 1e-9, "halfway between its neighbours");
        assert!(svg.contains("<title>a &lt; b</title>") && svg.contains("A &amp; B") && svg.contains("order 1"));
        assert_eq!(svg.matches("tabindex").count(), 3);
    }

    #[test]
    fn nothing_makes_no_axes() {
        let nothing =
            Chart { series: vec![Series { label: "A".into(), marks: vec![mark(0.0, -1.0)] }], ..Chart::default() };
        assert!(nothing.svg(false).starts_with("<p>") && Chart::default().svg(false).starts_with("<p>"));
    }

    #[test]
    fn ticks_are_powers_of_ten() {
        assert_eq!([1e-6, 0.1, 100.0, 1e5].map(tick), ["10⁻⁶", "0.1", "100", "10⁵"]);
        let axis = Axis::of([1.0, 1e12].into_iter(), 0.0, 1.0).unwrap();
        assert!(axis.ticks().iter().filter(|(_, labelled)| *labelled).count() <= 9);
    }
}
