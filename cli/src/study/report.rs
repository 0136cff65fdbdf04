//! The report of a study: a page, a table for spreadsheets, and all of it as JSON.

use super::chart::{Chart, Mark, Series, escaped};
use super::machine::in_words;
use super::outcome::{Outcome, Spread, orders, pareto};
use super::page::{Table, counted, csv_cell, figure, page, paragraphs, shown};
use super::plan::{Entry, Study, Variant};
use serde_json::{Value, json};
use std::fmt::Write;

/// A study with what its runs left.
pub struct Report<'a> {
    study: &'a Study,
    machine: Value,
    /// Of each variant, what each entry left.
    outcomes: Vec<Vec<Outcome>>,
}

/// A row of the tables.
struct Row<'a> {
    variant: &'a Variant,
    entry: &'a Entry,
    outcome: &'a Outcome,
    error: Option<f64>,
    order: Option<f64>,
}

impl<'a> Report<'a> {
    /// With the outcomes by variant.
    pub fn new(study: &'a Study, machine: Value, outcomes: Vec<Vec<Outcome>>) -> Self {
        Self { study, machine, outcomes }
    }

    fn error(&self, outcome: &Outcome) -> Option<f64> {
        if outcome.is_done() { self.study.error.value(outcome) } else { None }
    }

    fn rows(&self) -> Vec<Row<'_>> {
        let mut rows = Vec::new();
        for (variant, outcomes) in self.study.variants.iter().zip(&self.outcomes) {
            let errors: Vec<(Option<f64>, Option<f64>)> = variant
                .entries
                .iter()
                .zip(outcomes)
                .map(|(entry, outcome)| (entry.size, self.error(outcome)))
                .collect();
            let orders = orders(&errors);
            for (index, (entry, outcome)) in variant.entries.iter().zip(outcomes).enumerate() {
                rows.push(Row { variant, entry, outcome, error: errors[index].1, order: orders[index] });
            }
        }
        rows
    }

    /// The places (CPU time, error) of all runs that have both, with their rows.
    fn places<'b>(&self, rows: &'b [Row<'b>]) -> Vec<(f64, f64, &'b Row<'b>)> {
        let place = |row: &'b Row<'b>| Some((row.outcome.cpu()?.median, row.error?, row));
        rows.iter().filter_map(place).filter(|(cpu, error, _)| *cpu > 0.0 && error.is_finite()).collect()
    }

    /// Log of the error over the log of the CPU time.
    pub fn work_precision(&self) -> Chart {
        let rows = self.rows();
        let places = self.places(&rows);
        let best = pareto(&places.iter().map(|(cpu, error, _)| (*cpu, *error)).collect::<Vec<_>>());
        let front = best.into_iter().map(|index| (places[index].0, places[index].1));
        Chart {
            title: format!("{}: error over CPU time", self.study.title),
            x: "CPU time of the steps [s]".into(),
            y: self.study.error_name.clone(),
            series: self
                .series(&rows, |row| row.outcome.cpu().map(|cpu| (cpu.median, Some((cpu.smallest, cpu.largest))))),
            slopes: Vec::new(),
            front: front.filter(|(cpu, error)| *cpu > 0.0 && *error > 0.0).collect(),
        }
    }

    /// Log of the error over the log of the size.
    pub fn convergence(&self) -> Chart {
        let rows = self.rows();
        Chart {
            title: format!("{}: error over {}", self.study.title, self.study.size_name),
            x: self.study.size_name.clone(),
            y: self.study.error_name.clone(),
            series: self.series(&rows, |row| row.entry.size.map(|size| (size, None))),
            slopes: self.study.slopes.clone(),
            front: Vec::new(),
        }
    }

    fn series(&self, rows: &[Row], x: impl Fn(&Row) -> Option<(f64, Option<(f64, f64)>)>) -> Vec<Series> {
        let of = |variant: &Variant| {
            let own = rows.iter().filter(|row| std::ptr::eq(row.variant, variant));
            let mark = |row: &Row| {
                let ((x, range), y) = (x(row)?, row.error?);
                (x > 0.0 && y > 0.0).then(|| Mark { x, y, range, tip: tip(row) })
            };
            Series { label: variant.label.clone(), marks: own.filter_map(mark).collect() }
        };
        self.study.variants.iter().map(of).collect()
    }

    /// The page.
    pub fn html(&self) -> String {
        let rows = self.rows();
        let mut out = paragraphs(&self.study.text, "");
        if !self.study.advice.is_empty() {
            let _ = write!(out, "<div class=\"advice\">\n{}</div>\n", paragraphs(&self.study.advice, ""));
        }
        out += "<h2>Error against run time</h2>\n";
        out += &figure(
            &self.work_precision().svg(false),
            "Left and low is better. Each mark is a run, its time the median of its repetitions, the bar through it \
             their spread; the broad line joins the runs that no other beats in both. Errors below 1e-12 are round-off, \
             and stand at the lower edge.",
        );
        out += &self.cheapest(&rows);
        if rows.iter().any(|row| row.entry.size.is_some()) {
            out += "<h2>Convergence</h2>\n";
            out += &figure(&self.convergence().svg(false), "Dotted lines have the slopes of whole orders.");
        }
        out += "<h2>All runs</h2>\n";
        out += &self.table(&rows);
        out += &troubles(&rows);
        out += &self.commands(&rows);
        page(&self.study.title, &out)
    }

    /// The cheapest run for each wanted error, and the Pareto front.
    fn cheapest(&self, rows: &[Row]) -> String {
        let places = self.places(rows);
        let mut out = String::new();
        if !self.study.wanted.is_empty() {
            let mut table = Table::new(&["wanted error", "cheapest", "error", "CPU [s]", "next", "error", "CPU [s]"]);
            for wanted in &self.study.wanted {
                let mut cells = vec![shown(Some(*wanted))];
                // The cheapest run of each variant that is good enough, the two cheapest variants.
                let mut best: Vec<&(f64, f64, &Row)> = Vec::new();
                for variant in &self.study.variants {
                    let own =
                        places.iter().filter(|(_, error, row)| std::ptr::eq(row.variant, variant) && error <= wanted);
                    best.extend(own.min_by(|a, b| a.0.total_cmp(&b.0)));
                }
                best.sort_by(|a, b| a.0.total_cmp(&b.0));
                for (cpu, error, row) in best.into_iter().take(2) {
                    let name = escaped(&row.entry.case.name);
                    cells.extend([name, shown(Some(*error)), shown(Some(*cpu))]);
                }
                cells.resize(7, "none".into());
                table.row(&cells);
            }
            out += &table.html();
        }
        let best = pareto(&places.iter().map(|(cpu, error, _)| (*cpu, *error)).collect::<Vec<_>>());
        let names: Vec<String> = best.iter().map(|index| escaped(&places[*index].2.entry.case.name)).collect();
        if !names.is_empty() {
            let _ = writeln!(out, "<p>Beaten by none in both error and time: {}.</p>", names.join("; "));
        }
        out
    }

    fn table(&self, rows: &[Row]) -> String {
        let size = self.study.size_name.as_str();
        let mut table = Table::new(&[
            "run",
            size,
            "step [s]",
            "cells",
            "points",
            "unknowns",
            "steps",
            "error",
            "order",
            "CPU [s]",
            "spread",
            "wall [s]",
            "memory [MB]",
            "point-steps/s",
        ]);
        for variant in &self.study.variants {
            table.group(&match variant.text.as_str() {
                "" => variant.label.clone(),
                text => format!("{}: {text}", variant.label),
            });
            for row in rows.iter().filter(|row| std::ptr::eq(row.variant, variant)) {
                table.raw(&html_row(row));
            }
        }
        table.html()
    }

    fn commands(&self, rows: &[Row]) -> String {
        let mut out = format!(
            "<h2>How it was measured</h2>\n<p>{}.</p>\n<p>Each run was a process of its own, repeated {} times; CPU \
             time is that of the loop over time steps, of all threads, and its spread the difference of the largest \
             and smallest over the median. Memory is the largest that was resident.</p>\n<details><summary>Commands of \
             all runs</summary>\n",
            escaped(&in_words(&self.machine)),
            self.study.repetitions
        );
        for row in rows {
            let (name, command) = (escaped(&row.entry.case.name), escaped(&row.entry.case.command()));
            let _ = writeln!(out, "<p>{name}<br><code>{command}</code></p>");
        }
        out + "</details>\n"
    }

    /// A table for spreadsheets.
    pub fn csv(&self) -> String {
        let mut out = String::from(
            "variant,label,h,time_step_s,cells,points,unknowns,steps,error,order,cpu_s,cpu_smallest_s,cpu_largest_s,\
             wall_s,memory_mb,point_steps_per_s,end,reason\n",
        );
        for row in self.rows() {
            let of = |pointer: &str| row.outcome.number(pointer);
            let cpu = row.outcome.cpu();
            let numbers = [
                row.entry.size,
                of("/time_step/mean"),
                of("/cells"),
                of("/points"),
                of("/unknowns"),
                of("/steps"),
                row.error,
                row.order,
                cpu.map(|cpu| cpu.median),
                cpu.map(|cpu| cpu.smallest),
                cpu.map(|cpu| cpu.largest),
                row.outcome.spread("/wall_s").map(|wall| wall.median),
                row.outcome.spread("/peak_memory_mb").map(|memory| memory.median),
                row.outcome.rate(),
            ];
            let numbers = numbers.map(|number| number.map_or(String::new(), |number| format!("{number:?}")));
            let (variant, label) = (csv_cell(&row.variant.label), csv_cell(&row.entry.label));
            let (end, reason) = (row.outcome.end(), csv_cell(row.outcome.reason()));
            let _ = writeln!(out, "{variant},{label},{},{end},{reason}", numbers.join(","));
        }
        out
    }

    /// All of it for programs.
    pub fn json(&self) -> Value {
        let run = |row: &Row| {
            json!({
                "variant": row.variant.label, "label": row.entry.label, "h": row.entry.size, "error": row.error,
                "order": row.order, "cpu_s": spread(row.outcome.cpu()), "wall_s": spread(row.outcome.spread("/wall_s")),
                "end": row.outcome.end(), "reason": row.outcome.reason(), "repeatable": !row.outcome.differs(),
                "command": row.entry.case.command(), "summary": row.outcome.summary(),
            })
        };
        let rows = self.rows();
        let places = self.places(&rows);
        let best = pareto(&places.iter().map(|(cpu, error, _)| (*cpu, *error)).collect::<Vec<_>>());
        json!({
            "title": self.study.title, "error": self.study.error.pointer, "machine": self.machine,
            "runs": rows.iter().map(run).collect::<Vec<_>>(),
            "pareto": best.iter().map(|index| places[*index].2.entry.case.name.as_str()).collect::<Vec<_>>(),
        })
    }
}

fn spread(of: Option<Spread>) -> Value {
    of.map_or(Value::Null, |of| json!({"median": of.median, "smallest": of.smallest, "largest": of.largest}))
}

/// What is told of a mark.
fn tip(row: &Row) -> String {
    let cpu = shown(row.outcome.cpu().map(|cpu| cpu.median));
    let points = counted(row.outcome.number("/points"));
    let steps = counted(row.outcome.number("/steps"));
    format!("{}\nerror {}\nCPU {cpu} s\n{points} points, {steps} steps", row.entry.case.name, shown(row.error))
}

fn html_row(row: &Row) -> String {
    let of = |pointer: &str| row.outcome.number(pointer);
    let label = escaped(&row.entry.label);
    let head = [format!("<td>{label}</td>"), format!("<td>{}</td>", shown(row.entry.size))].concat();
    if !row.outcome.is_done() {
        let (end, reason) = (in_word(row.outcome.end()), escaped(row.outcome.reason()));
        return format!("<tr>{head}<td class=\"text\" colspan=\"12\"><b class=\"fails\">{end}</b>: {reason}</td></tr>");
    }
    let cpu = row.outcome.cpu();
    let spread = cpu.map(|cpu| format!("{:.0} %", 100.0 * (cpu.largest - cpu.smallest) / cpu.median));
    let cells = [
        shown(of("/time_step/mean")),
        counted(of("/cells")),
        counted(of("/points")),
        counted(of("/unknowns")),
        counted(of("/steps")),
        row.error.map_or("not there".into(), |error| shown(Some(error))),
        row.order.map_or(String::new(), |order| format!("{order:.2}")),
        shown(cpu.map(|cpu| cpu.median)),
        spread.unwrap_or_default(),
        shown(row.outcome.spread("/wall_s").map(|wall| wall.median)),
        shown(row.outcome.spread("/peak_memory_mb").map(|memory| memory.median)),
        shown(row.outcome.rate()),
    ];
    let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
    format!("<tr>{head}{cells}</tr>")
}

/// How an end is called.
pub fn in_word(end: &str) -> &str {
    match end {
        "failed" => "failed",
        "input" => "refused",
        "timed_out" => "out of time",
        "stopped" => "stopped",
        "crashed" => "crashed",
        other => other,
    }
}

/// What a reader must know of runs that went wrong or differ.
fn troubles(rows: &[Row]) -> String {
    let differing: Vec<String> =
        rows.iter().filter(|row| row.outcome.differs()).map(|row| escaped(&row.entry.case.name)).collect();
    let loose: Vec<String> = rows
        .iter()
        .filter(|row| row.outcome.number("/steps_not_converged").is_some_and(|count| count > 0.0))
        .map(|row| escaped(&row.entry.case.name))
        .collect();
    let mut out = String::new();
    if !differing.is_empty() {
        let _ = writeln!(out, "<p class=\"fails\">Repetitions gave other results: {}.</p>", differing.join("; "));
    }
    if !loose.is_empty() {
        let _ = writeln!(out, "<p class=\"fails\">Steps did not converge: {}.</p>", loose.join("; "));
    }
    out
}
