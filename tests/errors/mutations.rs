//! Thousands of spoilt texts: whatever a file holds, the answer is a scene or a list of faults.

use super::base::{BODY, GRID, MATERIALS, PROJECT, Scene};
use bia_kernel::analysis::Analysis;
use bia_kernel::parameters::Document;
use bia_kernel::processes::RunOptions;
use bia_kernel::registry::Registry;
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};
use tempfile::TempDir;

const SEED: u64 = 0x5eed_0b1a;

/// xorshift64* (S. Vigna, 2016).
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n.max(1)
    }

    fn of<T: Clone>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())].clone()
    }
}

fn strange_values() -> Vec<Value> {
    let mut values = vec![Value::Null, json!(true), json!([]), json!({}), json!([[[]]]), json!({"": {"~/": 1}})];
    values.extend([0.0, -1.0, 0.5, 1e308, -1e308, 1e-308, 4294967296.0, 1e18].map(|x| json!(x)));
    values.extend([0i64, 1, 2, 3, -1, i64::MAX, i64::MIN].map(|i| json!(i)));
    let texts =
        ["", ".", "..", "é", "t", "1/0", "log(-1)", "x if t else", "End", "MPM_Material", "Background_Grid", "\u{0}"];
    values.extend(texts.map(|text| json!(text)));
    values
}

/// All places of a value.
fn pointers(value: &Value, here: &str, list: &mut Vec<String>) {
    list.push(here.to_string());
    match value {
        Value::Object(members) => {
            for (key, member) in members {
                pointers(member, &format!("{here}/{}", key.replace('~', "~0").replace('/', "~1")), list);
            }
        }
        Value::Array(entries) => {
            entries.iter().enumerate().for_each(|(i, v)| pointers(v, &format!("{here}/{i}"), list))
        }
        _ => {}
    }
}

/// Puts strange values in places of the document, or removes, renames and copies members.
fn spoil_value(text: &str, random: &mut Random) -> String {
    let mut root: Value = serde_json::from_str(text).unwrap();
    for _ in 0..1 + random.below(3) {
        let mut places = Vec::new();
        pointers(&root, "", &mut places);
        let (place, other) = (random.of(&places), random.of(&places));
        let copied = root.pointer(&other).cloned().unwrap_or_default();
        let action = random.below(8);
        let Some(target) = root.pointer_mut(&place) else { continue };
        match (action, target) {
            (0, Value::Object(members)) => {
                let keys: Vec<String> = members.keys().cloned().collect();
                members.remove(&random.of(&[keys, vec![String::new()]].concat()));
            }
            (1, Value::Object(members)) => {
                let keys: Vec<String> = members.keys().cloned().collect();
                let key = random.of(&[keys, vec!["x".into()]].concat());
                let value = members.remove(&key).unwrap_or_default();
                members.insert(key.chars().rev().collect(), value);
            }
            (2, Value::Array(list)) => list.push(copied),
            (3, target) => *target = copied,
            (_, target) => *target = random.of(&strange_values()),
        }
    }
    root.to_string()
}

/// Removes, doubles, moves and changes letters.
fn spoil_text(text: &str, random: &mut Random) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    for _ in 0..1 + random.below(3) {
        let start = random.below(letters.len());
        let end = (start + 1 + random.below(30)).min(letters.len());
        let piece = letters[start..end].to_vec();
        match random.below(4) {
            0 => drop(letters.drain(start..end)),
            1 => drop(letters.splice(start..start, piece)),
            2 => {
                letters[start] =
                    random.of(&['"', '{', '}', '[', ']', ',', ':', '/', '*', '\\', 'e', '-', '9', 'é', '\n'])
            }
            _ => {
                let place = random.below(letters.len());
                drop(letters.splice(place..place, piece));
            }
        }
        if letters.is_empty() {
            letters.push('0');
        }
    }
    letters.into_iter().collect()
}

fn prepare(folder: &Path, project: String, registry: &Registry) -> bool {
    let options = RunOptions { folder: folder.into(), output: folder.into(), kratos_exact: false };
    let prepared = Document::parse(&folder.join(PROJECT), project)
        .and_then(|document| Analysis::prepare(document, registry, options, false));
    match prepared {
        Ok(analysis) => {
            analysis.inventory();
            true
        }
        Err(errors) => {
            assert!(errors.any_error() && errors.0.iter().all(|d| !d.message.is_empty()), "{errors:?}");
            false
        }
    }
}

/// Spoils one file again and again; returns how many texts were accepted.
fn spoil(file: &str, count: usize, seed: u64, change: fn(&str, &mut Random) -> String) -> usize {
    let folder = TempDir::new().unwrap();
    let scene = Scene::base();
    scene.write_to(folder.path());
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    let mut random = Random(seed);
    let mut accepted = 0;
    for number in 0..count {
        let text = change(&scene.text(file), &mut random);
        let project = if file == PROJECT {
            text.clone()
        } else {
            std::fs::write(folder.path().join(file), &text).unwrap();
            scene.text(PROJECT)
        };
        let begin = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| prepare(folder.path(), project, &registry))) {
            Ok(fine) => accepted += usize::from(fine),
            Err(_) => panic!("number {number} of seed {seed:#x} panics:\n{text}"),
        }
        assert!(begin.elapsed() < Duration::from_secs(5), "number {number} of seed {seed:#x} takes long:\n{text}");
    }
    accepted
}

#[test]
fn spoilt_projects_and_materials_never_panic() {
    for (file, count, change) in [
        (PROJECT, 1000, spoil_value as fn(&str, &mut Random) -> String),
        (PROJECT, 400, spoil_text),
        (MATERIALS, 400, spoil_value),
        (MATERIALS, 200, spoil_text),
    ] {
        let accepted = spoil(file, count, SEED, change);
        assert!(accepted > 0 && accepted < count, "{accepted} of {count} variants of {file} are accepted");
    }
}

#[test]
fn spoilt_meshes_never_panic() {
    for file in [GRID, BODY] {
        let accepted = spoil(file, 400, SEED, spoil_text);
        assert!(accepted > 0 && accepted < 400, "{accepted} variants of {file} are accepted");
    }
}
