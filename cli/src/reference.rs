//! The page of every component and key, written by `bia info --markdown`.

use crate::info::{Component, default_of, kind_of};
use bia_kernel::analysis::project_keys;
use bia_kernel::parameters::{Key, Kind};
use std::fmt::Write;

const HEAD: &str = "# Every component and key

Written by `bia info --markdown > docs/reference.md` from the tables by which the program checks its input; a test holds
this page equal to them. `bia info NAME` shows one component, `bia schema` the same for editors.
";

/// The page; sections have a title and components.
pub fn page(sections: &[(&'static str, Vec<Component>)]) -> String {
    let mut page = String::from(HEAD);
    page += "\n## project\n";
    keys(&mut page, project_keys());
    for (title, components) in sections {
        section(&mut page, title, components);
    }
    page
}

fn section(page: &mut String, title: &str, components: &[Component]) {
    // Writing to a text cannot fail.
    let _ = writeln!(page, "\n## {title}");
    let is_list = components.iter().all(|component| component.keys.is_empty() && component.values.is_empty());
    if is_list {
        let _ = writeln!(page, "\n| name | |\n|---|---|");
        for component in components {
            let _ = writeln!(page, "| `{}` | {} |", component.names[0], cell(&component.help));
        }
        return;
    }
    for component in components {
        let names: Vec<String> = component.names.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(page, "\n### {}\n\n{}", names.join(", "), component.help);
        keys(page, component.keys);
        for (what, list) in &component.lists {
            let _ = writeln!(page, "\n{what}:");
            keys(page, list);
        }
        if !component.values.is_empty() {
            let _ = writeln!(page, "\n| constant | unit | range | meaning |\n|---|---|---|---|");
        }
        for [name, unit, range, help] in &component.values {
            let _ = writeln!(page, "| `{name}` | {unit} | {range} | {} |", cell(help));
        }
    }
}

fn keys(page: &mut String, list: &[Key]) {
    if list.is_empty() {
        return;
    }
    let _ = writeln!(page, "\n| key | value | | meaning |\n|---|---|---|---|");
    rows(page, list, "");
}

fn rows(page: &mut String, list: &[Key], above: &str) {
    for key in list {
        let name = format!("{above}{}", key.name);
        let (kind, default) = (cell(&kind_of(key.kind)), cell(&default_of(key)));
        let _ = writeln!(page, "| `{name}` | {kind} | {default} | {} |", cell(key.help));
        if let Kind::Object(inner) = key.kind {
            rows(page, inner, &format!("{name}."));
        }
    }
}

/// A text for a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}
