//! The book in `docs/`: links lead somewhere, the reference is what the program knows, the tutorial runs as written.
//!
//! `SUMMARY.md` and `book.toml` are mdbook's, so that `mdbook build` makes web pages of it; CI does not, as mdbook takes longer to
//! install than everything else, and broken links, which it would not find either, are found here.

use std::collections::BTreeSet;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All pages, and those at the root that link to them.
fn pages() -> Vec<PathBuf> {
    let mut pages = vec![root().join("README.md"), root().join("CONTRIBUTING.md")];
    for folder in ["docs", "docs/studies"] {
        let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        pages.extend(entries.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    pages
}

/// The text without blocks of code.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

/// Targets of links and pictures: what stands in parentheses after a bracket.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.to_string()).collect()
}

/// Names to which headings can be linked: lower case, blanks as hyphens, other signs left out.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let name = |line: &str| {
        let kept = line.trim_start_matches('#').trim().to_lowercase();
        kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>().replace(' ', "-")
    };
    headings.map(name).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut faults = Vec::new();
    for page in pages() {
        let text = read_to_string(&page).unwrap();
        for link in links(&text).into_iter().filter(|link| !link.starts_with("http")) {
            let (file, anchor) =
                link.split_once('#').map_or((link.as_str(), None), |(file, anchor)| (file, Some(anchor)));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let found = target.exists()
                && anchor.is_none_or(|anchor| anchors(&read_to_string(&target).unwrap()).contains(anchor));
            if !found {
                faults.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(faults.is_empty(), "links that lead nowhere:\n{}", faults.join("\n"));
    assert_eq!(links("a [b](c.md#d) ![e](f.png) ```[x](y)```"), ["c.md#d", "f.png"]);
}

#[test]
fn the_summary_names_every_page() {
    let summary = links(&read_to_string(root().join("docs/SUMMARY.md")).unwrap());
    for page in pages() {
        let Ok(name) = page.strip_prefix(root().join("docs")) else { continue };
        let name = name.to_str().unwrap().replace('\\', "/");
        assert!(name == "SUMMARY.md" || summary.contains(&name), "docs/SUMMARY.md does not name {name}");
    }
}

#[test]
fn the_reference_is_what_the_program_knows() {
    let output = Command::new(env!("CARGO_BIN_EXE_bia")).args(["info", "--markdown"]).output().unwrap();
    let (page, written) =
        (String::from_utf8(output.stdout).unwrap(), read_to_string(root().join("docs/reference.md")).unwrap());
    let differs = page.lines().zip(written.lines()).find(|(a, b)| a != b);
    assert!(page == written, "write it anew: bia info --markdown > docs/reference.md; first at {differs:?}");
    for name in [
        "`solver_settings`",
        "### `BodyModeler`",
        "a primitive of type stl",
        "`output_control_type`",
        "`YOUNG_MODULUS`",
    ] {
        assert!(page.contains(name), "{name}");
    }
}

/// Tests that the pages name, `file::test`, exist.
#[test]
fn tests_that_are_named_exist() {
    let text = read_to_string(root().join("docs/users.md")).unwrap();
    let named: Vec<(&str, &str)> =
        text.split('`').filter_map(|word| word.split_once("::")).filter(|(file, _)| file.ends_with(".rs")).collect();
    assert!(named.len() > 30, "{}", named.len());
    for (file, test) in named {
        let source = read_to_string(root().join(file)).unwrap_or_default();
        assert!(source.contains(&format!("fn {test}(")), "there is no test {file}::{test}");
    }
}

/// Blocks of the page with this mark.
fn blocks<'a>(text: &'a str, mark: &str) -> Vec<&'a str> {
    let begin = format!("```{mark}\n");
    text.split(begin.as_str()).skip(1).filter_map(|rest| Some(rest.split_once("```")?.0)).collect()
}

/// The commands of the tutorial, one after the other, in an empty folder; and the answers that it promises.
#[test]
fn the_tutorial_runs_as_written() {
    let text = read_to_string(root().join("docs/tutorial.md")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let json = blocks(&text, "json");
    assert_eq!(json.len(), 1);
    std::fs::write(folder.path().join("column.json"), json[0]).unwrap();
    let mut commands = 0;
    for line in blocks(&text, "sh").into_iter().flat_map(str::lines) {
        let words: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(words[0], "bia", "{line}");
        let output =
            Command::new(env!("CARGO_BIN_EXE_bia")).current_dir(folder.path()).args(&words[1..]).output().unwrap();
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        commands += 1;
    }
    assert_eq!(commands, 6);
    for file in ["first/results/vtk_output/MPM_Material.pvd", "results/pictures/MPM_Material.pvd"] {
        assert!(folder.path().join(file).exists(), "{file}");
    }
    let top = |results: &str| -> f64 {
        let table = read_to_string(folder.path().join(results).join("top.csv")).unwrap();
        table.lines().last().unwrap().split(',').nth(2).unwrap().trim().parse().unwrap()
    };
    assert!((top("results") / -0.01 - 1.0).abs() < 0.02, "{}", top("results"));
    assert!((top("heavy") / top("results") - 2.0).abs() < 0.04, "{}", top("heavy"));
    // What the text says of slips.
    std::fs::write(folder.path().join("slip.json"), json[0].replace("cell_size", "cell_sise")).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_bia"))
        .current_dir(folder.path())
        .args(["check", "slip.json"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("did you mean \"cell_size\""));
}
