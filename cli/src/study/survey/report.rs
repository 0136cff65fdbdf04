//! The report of a survey: the matrix, each scene's runs with their numbers, and what scenes did without.

use super::criterion::{Criterion, Finding, Verdict};
use super::plan::{Method, Run, Scene, Survey};
use super::used::{fullest, used};
use crate::study::chart::escaped;
use crate::study::machine::in_words;
use crate::study::outcome::Outcome;
use crate::study::page::{Table, counted, csv_cell, page, paragraphs, shown};
use crate::study::report::in_word;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::fmt::Write;

/// A survey with what its runs left.
pub struct Report<'a> {
    survey: &'a Survey,
    machine: Value,
    outcomes: HashMap<&'a str, Outcome>,
}

/// How a cell of the matrix came out.
struct Cell {
    verdict: Verdict,
    /// Why, in one line.
    reason: String,
    findings: Vec<Finding>,
}

impl<'a> Report<'a> {
    /// With the outcomes by the names of the cases.
    pub fn new(survey: &'a Survey, machine: Value, outcomes: HashMap<&'a str, Outcome>) -> Self {
        Self { survey, machine, outcomes }
    }

    fn outcome(&self, run: &'a Run) -> Option<&Outcome> {
        match run {
            Run::Cannot(_) => None,
            Run::Wanted(wanted) => self.outcomes.get(wanted.case.name.as_str()),
            Run::Measured(measured) => Some(&measured.outcome),
        }
    }

    fn judge(&self, run: &'a Run) -> Cell {
        let bare = |verdict: Verdict, reason: String| Cell { verdict, reason, findings: Vec::new() };
        let criteria = match run {
            Run::Cannot(reason) => return bare(Verdict::Cannot, reason.clone()),
            Run::Wanted(wanted) => &wanted.criteria,
            Run::Measured(measured) => &measured.criteria,
        };
        let Some(outcome) = self.outcome(run) else { return bare(Verdict::Fails, "was not run".into()) };
        let trouble = criteria.iter().any(Criterion::expects_trouble);
        if !outcome.is_done() && !trouble {
            let verdict = if outcome.end() == "input" { Verdict::Refused } else { Verdict::Fails };
            return bare(verdict, format!("{}: {}", in_word(outcome.end()), outcome.reason()));
        }
        let findings: Vec<Finding> = match run {
            Run::Measured(measured) => measured.findings(),
            _ => criteria.iter().map(|criterion| criterion.look(outcome)).collect(),
        };
        let verdict = findings.iter().map(|finding| finding.verdict).max().unwrap_or(Verdict::Fails);
        let worst = findings.iter().find(|finding| finding.verdict == verdict);
        let reason = match worst {
            Some(finding) if verdict == Verdict::Pass && finding.number.is_none() => {
                format!("stops as it should: {}", outcome.reason())
            }
            Some(finding) => in_line(finding),
            None => String::new(),
        };
        Cell { verdict, reason, findings }
    }

    /// The page.
    pub fn html(&self) -> String {
        let mut out = paragraphs(&self.survey.text, "");
        if !self.survey.advice.is_empty() {
            let _ = write!(out, "<div class=\"advice\">\n{}</div>\n", paragraphs(&self.survey.advice, ""));
        }
        out += &self.counts();
        out += "<h2>Scenes and methods</h2>\n";
        out += &self.matrix();
        out += "<h2>Methods</h2>\n";
        for method in self.own_methods() {
            let _ = writeln!(out, "<p><b>{}</b> {}</p>", escaped(&method.label), escaped(&method.text));
        }
        out += "<h2>Each scene</h2>\n";
        for scene in &self.survey.scenes {
            out += &self.scene(scene);
        }
        let _ = writeln!(out, "<h2>How it was measured</h2>\n<p>{}.</p>", escaped(&in_words(&self.machine)));
        out +=
            "<p>Each run was a process of its own; CPU time is that of the loop over time steps, of all threads.</p>\n";
        out += &self.survey.programs.iter().map(|program| paragraphs(&program.text, "")).collect::<String>();
        out += &self.commands();
        page(&self.survey.title, &out)
    }

    /// The survey's own methods, without what stands beside them.
    fn own_methods(&self) -> &[Method] {
        let beside: usize = self.survey.programs.iter().map(|program| program.columns.len()).sum();
        &self.survey.methods[..self.survey.methods.len() - beside]
    }

    fn counts(&self) -> String {
        let own = self.own_methods().len();
        let runs = || self.survey.scenes.iter().flat_map(|scene| scene.runs.iter().take(own).flatten());
        let all: Vec<Verdict> = runs().map(|run| self.judge(run).verdict).collect();
        let is_must = |run: &&Run| matches!(run, Run::Wanted(wanted) if wanted.must);
        let must = runs().filter(is_must).count();
        let kept = runs().filter(is_must).filter(|run| self.judge(run).verdict == Verdict::Pass).count();
        let mut out = format!(
            "<p>{} scenes, {} cells: {}. Of the {must} that must pass by theory, {kept} do.</p>\n",
            self.survey.scenes.len(),
            all.len(),
            tally(&all)
        );
        out += &self.told();
        for program in &self.survey.programs {
            let mut verdicts = [Vec::new(), Vec::new()];
            for scene in &self.survey.scenes {
                for (theirs, ours) in &program.columns {
                    let Some(run) = &scene.runs[*theirs] else { continue };
                    verdicts[0].push(self.judge(run).verdict);
                    verdicts[1].extend(scene.runs[*ours].as_ref().map(|run| self.judge(run).verdict));
                }
            }
            let [theirs, ours] = verdicts.each_ref().map(|list| tally(list));
            let (name, cells) = (escaped(&program.name), verdicts[0].len());
            let _ = writeln!(out, "<p>Beside them {name} on {cells} of these cells: {theirs}; Bia there: {ours}.</p>");
        }
        out
    }

    /// How those that fail say so: a result that is wrong without a word is the worst of all.
    fn told(&self) -> String {
        let own = self.own_methods().len();
        let (mut stopped, mut warned, mut silent) = (0, 0, Vec::new());
        for scene in &self.survey.scenes {
            for (method, run) in self.own_methods().iter().zip(scene.runs.iter().take(own)) {
                let Some(run) = run.as_ref().filter(|run| self.judge(run).verdict == Verdict::Fails) else { continue };
                match self.outcome(run) {
                    Some(outcome) if outcome.is_done() && outcome.warnings().is_empty() => {
                        silent.push(format!(
                            "<a href=\"#{0}\">{0}</a> by {1}",
                            escaped(&scene.id),
                            escaped(&method.label)
                        ));
                    }
                    Some(outcome) if outcome.is_done() => warned += 1,
                    _ => stopped += 1,
                }
            }
        }
        let list = if silent.is_empty() { String::new() } else { format!(": {}", silent.join(", ")) };
        let count = silent.len();
        format!(
            "<p>Of those that fail, {stopped} stop and say why, {warned} go on to the end with a warning, and {count} \
             end with nothing but the wrong number that the criteria find{list}.</p>\n"
        )
    }

    fn matrix(&self) -> String {
        let mut head = vec!["scene"];
        head.extend(self.survey.methods.iter().map(|method| method.label.as_str()));
        let mut table = Table::new(&head).of_texts();
        for scene in &self.survey.scenes {
            let (id, title) = (escaped(&scene.id), escaped(&scene.title));
            let mut row = format!(
                "<tr><td class=\"text\"><a href=\"#{id}\">{id}</a><br><small class=\"soft\">{title}</small></td>"
            );
            for run in &scene.runs {
                row += &match run {
                    Some(run) => self.cell(run),
                    None => "<td></td>".into(),
                };
            }
            table.raw(&(row + "</tr>"));
        }
        table.html()
    }

    fn cell(&self, run: &Run) -> String {
        let cell = self.judge(run);
        let (class, sign, reason) = (cell.verdict.name(), cell.verdict.sign(), escaped(&cell.reason));
        let short = escaped(&cell.reason.chars().take(90).collect::<String>());
        let cost = self
            .outcome(run)
            .and_then(Outcome::cpu)
            .map_or(String::new(), |cpu| format!("<small>{} s</small>", shown(Some(cpu.median))));
        format!(
            "<td class=\"cell\" title=\"{reason}\"><b class=\"{class}\">{sign} {class}</b><small>{short}</small>{cost}</td>"
        )
    }

    fn scene(&self, scene: &'a Scene) -> String {
        let (id, title) = (escaped(&scene.id), escaped(&scene.title));
        let mut out = format!("<h3 id=\"{id}\">{id}: {title}</h3>\n{}", paragraphs(&scene.text, ""));
        let mut table =
            Table::new(&["method", "result", "criterion", "found", "wanted", "steps", "CPU [s]"]).of_texts();
        let mut notes = String::new();
        for (Method { label, .. }, run) in self.survey.methods.iter().zip(&scene.runs) {
            let Some(run) = run else { continue };
            let (cell, outcome) = (self.judge(run), self.outcome(run));
            let verdict = format!("<b class=\"{0}\">{1} {0}</b>", cell.verdict.name(), cell.verdict.sign());
            let steps = counted(outcome.and_then(|outcome| outcome.number("/steps")));
            let cpu = shown(outcome.and_then(Outcome::cpu).map(|cpu| cpu.median));
            if cell.findings.is_empty() {
                let reason = escaped(&cell.reason);
                table.row(&[escaped(label), verdict, reason, String::new(), String::new(), steps, cpu]);
            } else {
                for (index, finding) in cell.findings.iter().enumerate() {
                    let first = |text: &str| if index == 0 { text.to_string() } else { String::new() };
                    let found = finding.number.map_or_else(|| missing(finding), |number| shown(Some(number)));
                    let class = finding.verdict.name();
                    table.row(&[
                        first(&escaped(label)),
                        first(&verdict),
                        escaped(&finding.what),
                        format!("<span class=\"{class}\">{found}</span>"),
                        escaped(&finding.wanted),
                        first(&steps),
                        first(&cpu),
                    ]);
                }
            }
            for warning in outcome.map_or(Vec::new(), Outcome::warnings) {
                let _ = writeln!(notes, "<p class=\"soft\">{} warns: {}</p>", escaped(label), escaped(warning));
            }
            if let Run::Wanted(wanted) = run
                && !wanted.text.is_empty()
            {
                let _ = writeln!(notes, "<p class=\"soft\">{}: {}</p>", escaped(label), escaped(&wanted.text));
            }
        }
        out += &table.html();
        out += &notes;
        out + &self.left_out(scene)
    }

    /// What each run of a scene used, and did without, beside the fullest one.
    fn left_out(&self, scene: &'a Scene) -> String {
        let labelled = self.survey.methods.iter().zip(&scene.runs);
        let runs = labelled.filter_map(|(method, run)| Some((method.label.as_str(), self.outcome(run.as_ref()?)?)));
        let all = self.survey.wanted().map(|wanted| wanted.case.name.as_str());
        used(runs, fullest(all.filter_map(|name| Some((name, self.outcomes.get(name)?)))))
    }

    fn commands(&self) -> String {
        let mut out = String::from("<details><summary>Commands of all runs</summary>\n");
        for wanted in self.survey.wanted() {
            let (name, command) = (escaped(&wanted.case.name), escaped(&wanted.case.command()));
            let _ = writeln!(out, "<p>{name}<br><code>{command}</code></p>");
        }
        out + "</details>\n"
    }

    /// A row for each criterion of each cell.
    pub fn csv(&self) -> String {
        let mut out = String::from("scene,method,result,must,criterion,found,wanted,steps,cpu_s,reason\n");
        self.visit(|scene, method, run, cell| {
            let (must, outcome) = (matches!(run, Run::Wanted(wanted) if wanted.must), self.outcome(run));
            let number = |number: Option<f64>| number.map_or(String::new(), |number| format!("{number:?}"));
            let head = format!("{},{},{},{must}", csv_cell(&scene.id), csv_cell(method), cell.verdict.name());
            let steps = number(outcome.and_then(|outcome| outcome.number("/steps")));
            let tail = format!(
                "{steps},{},{}",
                number(outcome.and_then(Outcome::cpu).map(|cpu| cpu.median)),
                csv_cell(&cell.reason)
            );
            if cell.findings.is_empty() {
                let _ = writeln!(out, "{head},,,,{tail}");
            }
            for finding in &cell.findings {
                let (what, wanted) = (csv_cell(&finding.what), csv_cell(&finding.wanted));
                let _ = writeln!(out, "{head},{what},{},{wanted},{tail}", number(finding.number));
            }
        });
        out
    }

    /// All of it for programs.
    pub fn json(&self) -> Value {
        let mut cells = Vec::new();
        self.visit(|scene, method, run, cell| {
            let mut entry = json!({
                "scene": scene.id, "method": method, "result": cell.verdict.name(), "reason": cell.reason,
                "criteria": cell.findings.iter().map(|finding| json!({
                    "what": finding.what, "result": finding.verdict.name(), "found": finding.number,
                    "wanted": finding.wanted,
                })).collect::<Vec<_>>(),
            });
            if let Run::Wanted(wanted) = run {
                entry["must"] = wanted.must.into();
                entry["text"] = wanted.text.clone().into();
                entry["command"] = wanted.case.command().into();
            }
            if !matches!(run, Run::Cannot(_)) {
                entry["end"] = self.outcome(run).map_or("not run", Outcome::end).into();
                entry["summary"] = self.outcome(run).map_or(Value::Null, |outcome| outcome.summary().clone());
            }
            cells.push(entry);
        });
        json!({"title": self.survey.title, "machine": self.machine, "cells": cells})
    }

    fn visit(&self, mut visit: impl FnMut(&Scene, &str, &'a Run, Cell)) {
        for scene in &self.survey.scenes {
            for (Method { label, .. }, run) in self.survey.methods.iter().zip(&scene.runs) {
                if let Some(run) = run {
                    visit(scene, label, run, self.judge(run));
                }
            }
        }
    }
}

/// How many came out how.
fn tally(all: &[Verdict]) -> String {
    let verdicts = [Verdict::Pass, Verdict::Degraded, Verdict::Fails, Verdict::Refused, Verdict::Cannot];
    let told = verdicts.iter().map(|verdict| {
        let count = all.iter().filter(|found| *found == verdict).count();
        format!("<b class=\"{0}\">{1} {0}</b> {count}", verdict.name(), verdict.sign())
    });
    told.collect::<Vec<_>>().join(", ")
}

/// What is told where there is no number.
fn missing(finding: &Finding) -> String {
    match finding.verdict {
        Verdict::Pass => "as expected".into(),
        Verdict::Unmeasured => "was not measured".into(),
        _ if finding.what.starts_with("ends") => "another end".into(),
        _ => "not there, or not finite".into(),
    }
}

fn in_line(finding: &Finding) -> String {
    match finding.number {
        Some(number) => format!("{} {} ({})", finding.what, shown(Some(number)), finding.wanted),
        None => format!("{}: {} ({})", finding.what, missing(finding), finding.wanted),
    }
}
