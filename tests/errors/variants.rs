//! A good project spoilt in one place, again and again: `variants.json` holds for each variant what is
//! changed and all that is said of it. The first rows are those that were tried on Kratos 10.4.4 with the
//! same project, under the same names; the others are ours.
//!
//! A message that is meant to change is read anew with `BIA_ACCEPT_VARIANTS=1 cargo test variants`; the
//! difference is for a human to judge.

use super::base::listing;
use bia_kernel::analysis::Analysis;
use bia_kernel::diagnostic::{Diagnostic, Severity};
use bia_kernel::parameters::Document;
use bia_kernel::processes::RunOptions;
use bia_kernel::registry::Registry;
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

const CASE: &str = "tests/kratos/imp_newmark_quad4";
const TABLE: &str = "tests/errors/variants.json";
const PROJECT: &str = "ProjectParameters.json";
/// As the table calls them, and as they are called.
const FILES: [(&str, &str); 4] = [
    (PROJECT, PROJECT),
    ("ParticleMaterials.json", "ParticleMaterials.json"),
    ("Grid.mdpa", "imp_newmark_quad4_Grid.mdpa"),
    ("Body.mdpa", "imp_newmark_quad4_Body.mdpa"),
];
/// Letters of a help that are compared: lists of what is allowed are long, and grow.
const HELP: usize = 100;

type Files = BTreeMap<&'static str, Vec<u8>>;

fn good() -> Files {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(CASE);
    FILES.iter().map(|(_, name)| (*name, std::fs::read(folder.join(name)).unwrap())).collect()
}

/// Makes one change: `[file, what, …]`.
fn change(files: &mut Files, edit: &Value) {
    let word = |i: usize| edit[i].as_str().unwrap_or_else(|| panic!("{edit}"));
    let (_, name) = FILES.into_iter().find(|(short, _)| *short == word(0)).unwrap();
    if word(1) == "delete" {
        files.remove(name);
        return;
    }
    let content = files.get_mut(name).unwrap();
    let text = || String::from_utf8(content.clone()).unwrap();
    let new = match word(1) {
        "set" | "remove" => set(&text(), word(2), edit.get(3)),
        "replace" => {
            assert_eq!(text().matches(word(2)).count(), 1, "{edit}");
            text().replace(word(2), word(3))
        }
        "replace_all" => text().replace(word(2), word(3)),
        "append" => text() + word(2),
        "cut" => text()[..(text().len() as f64 * edit[2].as_f64().unwrap()) as usize].into(),
        "cut_last" => text()[..text().rfind(word(2)).unwrap()].into(),
        "turn_cells" => rows(&text(), |row| match row {
            [id, "0", a, b, c, d] => Some(format!("{id} 0 {d} {c} {b} {a}")),
            _ => None,
        }),
        "shift" => rows(&text(), |row| match row {
            [id, x, y, "0"] => Some(format!("{id} {:?} {y} 0", x.parse::<f64>().unwrap() + edit[2].as_f64().unwrap())),
            _ => None,
        }),
        "drop_elements" => without(&without(&text(), "Elements "), "SubModelPartElements"),
        "drop_parts" => text()[..text().find("Begin SubModelPart ").unwrap()].into(),
        "noise" => {
            *content = noise(edit[2].as_u64().unwrap() as usize);
            return;
        }
        other => panic!("{other}"),
    };
    assert_ne!(new.as_bytes(), content, "{edit} changes nothing");
    *content = new.into_bytes();
}

/// The document with another value at a pointer, or without it.
fn set(text: &str, pointer: &str, value: Option<&Value>) -> String {
    let mut root: Value = serde_json::from_str(text).unwrap();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match (root.pointer_mut(parent).unwrap(), value) {
        (Value::Object(members), Some(value)) => drop(members.insert(key.into(), value.clone())),
        (Value::Object(members), None) => drop(members.remove(key).unwrap()),
        (Value::Array(entries), Some(value)) => entries[key.parse::<usize>().unwrap()] = value.clone(),
        (other, _) => panic!("{pointer}: {other}"),
    }
    serde_json::to_string_pretty(&root).unwrap()
}

fn rows(text: &str, new: impl Fn(&[&str]) -> Option<String>) -> String {
    let row = |line: &str| new(&line.split(' ').collect::<Vec<_>>()).unwrap_or_else(|| line.into()) + "\n";
    text.lines().map(row).collect()
}

/// Without the block that begins so; of a block in a part the head and the end stay.
fn without(text: &str, block: &str) -> String {
    let (begin, name) = (text.find(&format!("Begin {block}")).unwrap(), block.trim());
    let end = begin + text[begin..].find(&format!("End {name}")).unwrap();
    match name.starts_with("Sub") {
        true => format!("{}\n{}", &text[..begin + "Begin ".len() + name.len()], &text[end..]),
        false => format!("{}{}", &text[..begin], &text[end + "End ".len() + name.len()..]),
    }
}

fn noise(count: usize) -> Vec<u8> {
    let mut state = 0x5eed_0b1a_u64;
    let mut byte = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 56) as u8
    };
    (0..count).map(|_| byte()).collect()
}

/// `place: message | beginning of the help`.
fn line(diagnostic: &Diagnostic, folder: &Path) -> String {
    let text = match &diagnostic.help {
        None => format!("{}: {}", diagnostic.place, diagnostic.message),
        Some(help) => {
            let begin: String = help.chars().take(HELP).collect();
            let more = if begin.len() < help.len() { "…" } else { "" };
            format!("{}: {} | {begin}{more}", diagnostic.place, diagnostic.message)
        }
    };
    let text = text.strip_prefix(": ").unwrap_or(&text);
    text.replace(&format!("{}/", folder.display()), "")
}

/// What is said of the project in a folder before it runs.
fn judge(folder: &Path, registry: &Registry) -> (i32, Vec<String>) {
    let options = RunOptions { folder: folder.into(), output: folder.join("results"), kratos_exact: false };
    let prepared = Document::read(&folder.join(PROJECT))
        .and_then(|document| Analysis::prepare(document, registry, options, false));
    match prepared {
        Err(errors) => {
            assert!(errors.any_error());
            let faults = errors.0.iter().filter(|d| d.severity == Severity::Error);
            (2, faults.map(|d| line(d, folder)).collect())
        }
        Ok(analysis) => {
            let warnings = analysis.inventory().warnings;
            let first = |text: &String| text.lines().next().unwrap_or_default().to_owned();
            (0, warnings.iter().map(|text| first(text).replace(&format!("{}/", folder.display()), "")).collect())
        }
    }
}

/// Runs the program on it: exit code, and files that were not there before.
fn run(folder: &Path) -> (Option<i32>, Vec<String>) {
    let before = listing(folder);
    let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
    let arguments = ["run", PROJECT, "--threads", "1", "--quiet", "--output", "results"];
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    let new = listing(folder).into_iter().filter(|file| !before.contains(file)).collect();
    (output.status.code(), new)
}

fn table() -> Vec<Value> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(TABLE);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Writes the table, a row on a few lines.
fn accept(rows: &[Value]) {
    let texts = rows.iter().map(|row| {
        let says = row["says"].as_array().unwrap().iter().map(|line| format!("\n      {line}")).collect::<Vec<_>>();
        format!(
            "  {{\"name\": {}, \"exit\": {},\n    \"edit\": {},\n    \"says\": [{}]}}",
            row["name"],
            row["exit"],
            row["edit"],
            says.join(",")
        )
    });
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(TABLE);
    std::fs::write(path, format!("[\n{}\n]\n", texts.collect::<Vec<_>>().join(",\n"))).unwrap();
}

#[test]
fn each_variant_says_what_it_should() {
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    bia_structural::register(&mut registry);
    bia_dgmpm::register(&mut registry);
    let (mut table, mut wrong) = (table(), Vec::new());
    for row in &mut table {
        let folder = TempDir::new().unwrap();
        let mut files = good();
        row["edit"].as_array().unwrap().iter().for_each(|edit| change(&mut files, edit));
        files.iter().for_each(|(name, content)| std::fs::write(folder.path().join(name), content).unwrap());
        let (code, says) = judge(folder.path(), &registry);
        let (exit, new) = run(folder.path());
        let whole = files.iter().all(|(name, content)| std::fs::read(folder.path().join(name)).unwrap() == *content);
        let judged = json!(code) == row["exit"] && exit == Some(code) && whole && (code == 0 || new.is_empty());
        if !judged || json!(says) != row["says"] {
            wrong.push(format!(
                "--- {}: exit {exit:?}, files left {new:?}, inputs {}\n{}\ninstead of {:#}",
                row["name"],
                if whole { "whole" } else { "changed" },
                says.join("\n"),
                row["says"]
            ));
        }
        row["says"] = json!(says);
    }
    if std::env::var_os("BIA_ACCEPT_VARIANTS").is_some() {
        accept(&table);
    }
    assert!(wrong.is_empty(), "{} of {} variants:\n{}", wrong.len(), table.len(), wrong.join("\n"));
}

#[test]
fn the_table_has_all_variants_of_kratos_and_many_more() {
    let table = table();
    let names: HashSet<&str> = table.iter().map(|row| row["name"].as_str().unwrap()).collect();
    assert_eq!(names.len(), table.len(), "a name stands twice");
    assert!(table.iter().all(|row| row["exit"] == 0 || !row["says"].as_array().unwrap().is_empty()));
    let refused = table.iter().filter(|row| row["exit"] == 2).count();
    assert!(table.len() >= 77 + 40 && refused >= 100, "{} variants, {refused} refused", table.len());
}
