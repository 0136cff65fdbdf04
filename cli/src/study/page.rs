//! Self-contained pages: style, head, tables. They need no network and no script.

use super::chart::{STYLE, escaped};
use std::fmt::Write;

const PAGE: &str = "\
:root{color-scheme:light dark;--ink:#1b1f24;--soft:#59626d;--rule:#d9dde3;--ground:#fff;--panel:#f6f7f9;--link:#005a8c;\
--good:#00664a;--fair:#8a5a00;--bad:#a8321a;--none:#59626d}\
@media (prefers-color-scheme:dark){:root{--ink:#e6e8eb;--soft:#a3abb5;--rule:#343b44;--ground:#15181c;--panel:#1d2126;\
--link:#7cc4f0;--good:#4cd6a8;--fair:#ffc24d;--bad:#ff8f70;--none:#a3abb5}}\
*{box-sizing:border-box}body{margin:0;background:var(--ground);color:var(--ink);font:15px/1.55 system-ui,sans-serif;\
overflow-wrap:break-word}\
main{max-width:70rem;margin:0 auto;padding:2.5rem 1.25rem 4rem}h1{font-size:1.75rem;line-height:1.2;margin:0 0 .5rem}\
h2{font-size:1.2rem;margin:2.5rem 0 .5rem}h3{font-size:1rem;margin:1.5rem 0 .25rem}p{max-width:48rem;margin:.5rem 0}\
.soft{color:var(--soft)}.advice{border-left:3px solid var(--link);padding:.1rem 0 .1rem 1rem;margin:1rem 0}\
figure{margin:1rem 0}figcaption{color:var(--soft);font-size:.9rem}svg.chart{width:100%;height:auto;max-width:60rem}\
.wide{overflow-x:auto}table{border-collapse:collapse;font-size:.875rem;font-variant-numeric:tabular-nums}\
caption{text-align:left;color:var(--soft);padding-bottom:.3rem}th,td{padding:.28rem .6rem;text-align:right;\
border-bottom:1px solid var(--rule);white-space:nowrap}th{font-weight:600;vertical-align:bottom}\
th:first-child,td:first-child,.text{text-align:left}td.text{white-space:normal}tbody tr:hover{background:var(--panel)}\
table.left th,table.left td{text-align:left}table.left td{white-space:normal;vertical-align:top}\
tr.head td,tr.head th{background:var(--panel);font-weight:600}\
code{font:.85em ui-monospace,monospace;overflow-wrap:anywhere}details{margin:.75rem 0}summary{cursor:pointer}\
.pass{color:var(--good)}.degraded{color:var(--fair)}.fails{color:var(--bad)}.refused,.cannot{color:var(--none)}\
td.cell{white-space:normal;text-align:left;min-width:8.5rem;vertical-align:top}td.cell b{display:block}\
td.cell small{color:var(--soft);display:block;line-height:1.35}a{color:var(--link)}\
@media print{details{display:block}}";

/// A page of this title and content.
pub fn page(title: &str, content: &str) -> String {
    let title = escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n\
         <style>{PAGE}{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n{content}</main>\n</body>\n</html>\n"
    )
}

/// Paragraphs of a text, which empty lines part.
pub fn paragraphs(text: &str, class: &str) -> String {
    let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
    let parts = text.split("\n\n").map(str::trim).filter(|part| !part.is_empty());
    parts.map(|part| format!("<p{class}>{}</p>\n", escaped(part))).collect()
}

/// A figure with what it shows beneath.
pub fn figure(svg: &str, caption: &str) -> String {
    format!("<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n", escaped(caption))
}

/// A table of cells, which are HTML already.
#[derive(Debug, Default)]
pub struct Table {
    head: Vec<String>,
    body: String,
    /// Of texts rather than numbers.
    is_left: bool,
}

impl Table {
    /// With these headings.
    pub fn new(head: &[&str]) -> Self {
        Self { head: head.iter().map(|cell| escaped(cell)).collect(), ..Self::default() }
    }

    /// The same for texts: to the left, in several lines.
    #[must_use]
    pub fn of_texts(mut self) -> Self {
        self.is_left = true;
        self
    }

    /// Adds a row; the first cell names it.
    pub fn row(&mut self, cells: &[String]) {
        let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
        let _ = writeln!(self.body, "<tr>{cells}</tr>");
    }

    /// Adds a row that is HTML already.
    pub fn raw(&mut self, row: &str) {
        let _ = writeln!(self.body, "{row}");
    }

    /// Adds a line over the whole width that begins a group of rows.
    pub fn group(&mut self, text: &str) {
        let (span, text) = (self.head.len(), escaped(text));
        let _ = writeln!(self.body, "<tr class=\"head\"><th colspan=\"{span}\" scope=\"rowgroup\">{text}</th></tr>");
    }

    /// The table.
    pub fn html(&self) -> String {
        let head: String = self.head.iter().map(|cell| format!("<th scope=\"col\">{cell}</th>")).collect();
        let class = if self.is_left { " class=\"left\"" } else { "" };
        format!(
            "<div class=\"wide\"><table{class}>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{}</tbody>\n</table></div>\n",
            self.body
        )
    }
}

/// A number in three digits, as people read it; an empty cell for none.
pub fn shown(number: Option<f64>) -> String {
    match number {
        None => String::new(),
        Some(0.0) => "0".into(),
        Some(x) if !x.is_finite() => "not finite".into(),
        Some(x) if x.fract() == 0.0 && x.abs() < 1e5 => format!("{x}"),
        Some(x) if (0.01..1e5).contains(&x.abs()) => {
            let digits = (2 - x.abs().log10().floor() as i32).max(0) as usize;
            format!("{x:.digits$}")
        }
        Some(x) => format!("{x:.2e}"),
    }
}

/// A whole number in groups of three digits.
pub fn counted(number: Option<f64>) -> String {
    let Some(number) = number else { return String::new() };
    let digits = format!("{number:.0}");
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{2009}');
        }
        out.push(c);
    }
    out
}

/// A cell of a table of comma-separated values.
pub fn csv_cell(text: &str) -> String {
    match text.contains([',', '"', '\n']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let numbers = [0.0, 1.5, 0.01234, 123.4, 99_999.0, 1e-5, -2.5, 1.0].map(|x| shown(Some(x)));
        assert_eq!(numbers, ["0", "1.50", "0.0123", "123", "99999", "1.00e-5", "-2.50", "1"]);
        assert_eq!(counted(Some(1_234_567.0)), "1\u{2009}234\u{2009}567");
    }

    #[test]
    fn texts_cannot_break_the_page() {
        assert!(page("a <b>", &paragraphs("x & y\n\nz", "")).contains("<title>a &lt;b&gt;</title>"));
        assert_eq!(csv_cell("a,\"b\""), "\"a,\"\"b\"\"\"");
    }
}
