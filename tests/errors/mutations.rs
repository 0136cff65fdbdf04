//! Ten thousand spoilt files: whatever a file holds, the answer is a scene or a list of faults, soon and
//! within a gigabyte.

use super::base::{BODY, GRID, MATERIALS, PROJECT, Scene};
use bia_kernel::analysis::{Analysis, peak_memory_mb};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::expression::Expression;
use bia_kernel::io::checkpoint::{Archive, file};
use bia_kernel::io::gmsh;
use bia_kernel::parameters::Document;
use bia_kernel::processes::RunOptions;
use bia_kernel::registry::Registry;
use serde_json::{Value, json};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
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

/// The same for a document as bytes.
fn spoil_json(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    spoil_value(std::str::from_utf8(bytes).unwrap(), random).into_bytes()
}

/// The same for letters.
fn spoil_letters(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    spoil_text(std::str::from_utf8(bytes).unwrap(), random).into_bytes()
}

/// Cuts off, removes, doubles and overwrites bytes, and numbers in them.
fn spoil_bytes(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..1 + random.below(3) {
        let start = random.below(bytes.len());
        let end = (start + 1 + random.below(40)).min(bytes.len());
        match random.below(6) {
            0 => bytes.truncate(start),
            1 => drop(bytes.drain(start..end)),
            2 => {
                let piece = bytes[start..end].to_vec();
                drop(bytes.splice(start..start, piece));
            }
            3 => bytes[start] = random.below(256) as u8,
            4 => bytes[start] ^= 1 << random.below(8),
            _ => {
                let number = random.of(&[0u64, 1, 0x7fff_ffff, 0xffff_ffff, u64::MAX, 1 << 40]).to_le_bytes();
                let width = random.of(&[4, 8]).min(bytes.len() - start);
                bytes[start..start + width].copy_from_slice(&number[..width]);
            }
        }
        if bytes.is_empty() {
            bytes.push(b'0');
        }
    }
    bytes
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
    sound(prepared).is_some_and(|analysis| !analysis.inventory().lines.is_empty())
}

/// What was read; faults say something.
fn sound<T>(result: Result<T, InputErrors>) -> Option<T> {
    result.map_err(|e| assert!(e.any_error() && e.0.iter().all(|d| !d.message.is_empty()), "{e:?}")).ok()
}

type Change = fn(&[u8], &mut Random) -> Vec<u8>;

/// Spoils a content again and again and gives it to a reader, which says whether it accepts; returns how
/// often it did.
fn spoil(
    name: &str,
    good: &[u8],
    count: usize,
    seed: u64,
    change: Change,
    read: &mut dyn FnMut(&[u8]) -> bool,
) -> usize {
    let mut random = Random(seed);
    let mut accepted = 0;
    for number in 0..count {
        let bad = change(good, &mut random);
        let begin = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| read(&bad))) {
            Ok(fine) => accepted += usize::from(fine),
            Err(_) => panic!("{name}: number {number} of seed {seed:#x} panics:\n{}", String::from_utf8_lossy(&bad)),
        }
        let long = begin.elapsed() > Duration::from_secs(5);
        assert!(!long, "{name}: number {number} of seed {seed:#x} takes long:\n{}", String::from_utf8_lossy(&bad));
    }
    accepted
}

/// Spoils a file of the base scene.
fn spoil_file(file: &str, count: usize, seed: u64, change: Change) -> usize {
    let folder = TempDir::new().unwrap();
    // With a table in a file, for the reader of such tables.
    let table = "{\"name\": \"csv_table\", \"filename\": \"table.csv\"}";
    let scene = Scene::base().replace(PROJECT, "\"0.0*t\"", table).write(TABLE, "0.0, 0.0\n0.01, 1e-3\n0.02, N/A\n");
    scene.write_to(folder.path());
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    let (path, project) = (folder.path().join(file), scene.text(PROJECT));
    let good = scene.text(file).into_bytes();
    spoil(file, &good, count, seed, change, &mut |bad| {
        if file == PROJECT {
            return prepare(folder.path(), String::from_utf8(bad.to_vec()).unwrap(), &registry);
        }
        std::fs::write(&path, bad).unwrap();
        prepare(folder.path(), project.clone(), &registry)
    })
}

const TABLE: &str = "table.csv";

/// Spoils files and gives how many there were; each kind must be accepted at times and refused at times.
fn spoil_files(rows: &[(&str, usize, Change)], seed: u64) -> usize {
    for (file, count, change) in rows {
        let accepted = spoil_file(file, *count, seed, *change);
        assert!(accepted > 0 && accepted < *count, "{accepted} of {count} variants of {file} are accepted");
    }
    rows.iter().map(|row| row.1).sum()
}

/// Nothing that was read may have taken much memory, all tests of this program together.
fn within_memory() {
    let peak = peak_memory_mb().unwrap_or(0.0);
    assert!(peak < 1024.0, "{peak} MB");
}

fn projects(scale: usize, seed: u64) -> usize {
    spoil_files(&[(PROJECT, 2500 * scale, spoil_json), (PROJECT, 800 * scale, spoil_letters)], seed)
}

/// A project whose meshes modelers make.
fn modelers(scale: usize, seed: u64) -> usize {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("examples/falling_disc/ProjectParameters.json");
    let (good, folder, count) = (std::fs::read(path).unwrap(), TempDir::new().unwrap(), 400 * scale);
    let mut registry = Registry::with_kernel();
    bia_mpm::register(&mut registry);
    let accepted = spoil("modelers", &good, count, seed, spoil_json, &mut |bad| {
        prepare(folder.path(), String::from_utf8(bad.to_vec()).unwrap(), &registry)
    });
    assert!(accepted > 0 && accepted < count, "{accepted}");
    count
}

fn materials(scale: usize, seed: u64) -> usize {
    let rows: &[(&str, usize, Change)] = &[
        (MATERIALS, 1000 * scale, spoil_json),
        (MATERIALS, 400 * scale, spoil_letters),
        (MATERIALS, 200 * scale, spoil_bytes),
        (TABLE, 400 * scale, spoil_bytes),
    ];
    spoil_files(rows, seed)
}

fn mdpa(scale: usize, seed: u64) -> usize {
    let rows: &[(&str, usize, Change)] = &[
        (GRID, 800 * scale, spoil_letters),
        (GRID, 400 * scale, spoil_bytes),
        (BODY, 800 * scale, spoil_letters),
        (BODY, 400 * scale, spoil_bytes),
    ];
    spoil_files(rows, seed)
}

/// Meshes that Gmsh wrote: both formats, text and binary.
fn msh(scale: usize, seed: u64) -> usize {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/gmsh");
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let (mut accepted, count) = (0, 200 * scale);
    for path in &paths {
        let name = path.file_name().unwrap().to_string_lossy();
        let mut read = |bad: &[u8]| sound(gmsh::parse(bad, path, "Part", "Element")).is_some();
        accepted += spoil(&name, &std::fs::read(path).unwrap(), count, seed, spoil_bytes, &mut read);
    }
    assert!(accepted > 0 && accepted < paths.len() * count, "{accepted} accepted");
    paths.len() * count
}

fn functions(scale: usize, seed: u64) -> usize {
    let good = b"1.5*sin(2*pi*t) + (x if y > 0.5 else -z**2)*max(1, abs(X - Y)) % 3";
    let count = 800 * scale;
    let accepted = spoil("function", good, count, seed, spoil_letters, &mut |bad| {
        Expression::parse(std::str::from_utf8(bad).unwrap()).is_ok()
    });
    assert!(accepted > 0 && accepted < count, "{accepted}");
    count
}

/// A check sum guards checkpoints; none that is changed passes for whole.
fn checkpoints(scale: usize, seed: u64) -> usize {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("state");
    let mut columns = (vec![1.5f64; 40], vec![7u32; 9], 3usize);
    let mut exchange = |archive: &mut Archive| {
        archive.column("a", &mut columns.0)?;
        archive.column("b", &mut columns.1)?;
        archive.count("c", &mut columns.2)
    };
    file::write(&path, serde_json::Map::new(), &mut exchange).unwrap();
    let good = std::fs::read(&path).unwrap();
    let count = 600 * scale;
    spoil("checkpoint", &good, count, seed, spoil_bytes, &mut |bad| {
        std::fs::write(&path, bad).unwrap();
        let read = file::read(&path);
        assert!(read.is_err() || bad == good);
        read.is_ok()
    });
    count
}

#[test]
fn spoilt_projects_never_panic() {
    assert!(projects(1, SEED) + modelers(1, SEED) >= 3700);
    within_memory();
}

#[test]
fn spoilt_materials_and_tables_never_panic() {
    assert!(materials(1, SEED) >= 2000);
    within_memory();
}

#[test]
fn spoilt_meshes_never_panic() {
    // With the projects, materials and tables above these are more than ten thousand.
    let count = mdpa(1, SEED) + msh(1, SEED) + functions(1, SEED) + checkpoints(1, SEED);
    assert!(count >= 6000 && count + 3700 + 2000 >= 10_000, "{count}");
    within_memory();
}

/// The same with other seeds for as long as one likes: BIA_MUTATE_SECONDS says how long.
#[test]
#[ignore = "takes minutes: a search, not a test"]
fn search_for_spoilt_files_that_panic() {
    let seconds = std::env::var("BIA_MUTATE_SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(60);
    let (begin, mut seed, mut total) = (Instant::now(), SEED, 0);
    while begin.elapsed() < Duration::from_secs(seconds) {
        seed = seed.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(1) | 1;
        for kind in [projects, modelers, materials, mdpa, msh, functions, checkpoints] {
            total += kind(1, seed);
        }
        within_memory();
    }
    println!("{total} spoilt files in {:.0} s, none panics", begin.elapsed().as_secs_f64());
}
