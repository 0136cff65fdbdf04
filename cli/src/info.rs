//! `bia info`, `bia schema`, `bia completions`: what this program knows.

use crate::{Cli, reference, report};
use bia_kernel::analysis::project_schema;
use bia_kernel::diagnostic::nearest;
use bia_kernel::io::mdpa::Category;
use bia_kernel::parameters::{Default, Key, Kind};
use bia_kernel::registry::{Description, Registry};
use clap::{Args, CommandFactory};
use clap_complete::Shell;
use report::{complain, say};
use std::process::ExitCode;

/// Arguments of `bia info`.
#[derive(Args)]
pub struct InfoArguments {
    /// A component or variable; its keys, units, ranges and defaults are shown
    name: Option<String>,
    /// Write everything as a page in Markdown: docs/reference.md
    #[arg(long, conflicts_with = "name")]
    markdown: bool,
}

/// What is shown of one component.
pub(crate) struct Component {
    pub names: Vec<String>,
    pub help: String,
    pub keys: &'static [Key],
    /// Keys of objects in lists, with words for which they are.
    pub lists: Vec<(String, &'static [Key])>,
    /// What a law takes: name, unit, range, meaning.
    pub values: Vec<[String; 4]>,
}

impl Component {
    fn new(names: Vec<String>, help: &str, keys: &'static [Key]) -> Self {
        Self { names, help: help.into(), keys, lists: Vec::new(), values: Vec::new() }
    }
}

impl From<Description> for Component {
    fn from(of: Description) -> Self {
        let names = std::iter::once(of.name).chain(of.aliases).collect();
        Self { names, help: of.help, keys: &[], lists: Vec::new(), values: of.values }
    }
}

/// Everything, kind by kind.
fn sections(registry: &Registry) -> Vec<(&'static str, Vec<Component>)> {
    let owned = |names: &[&str]| names.iter().map(|name| (*name).to_string()).collect::<Vec<_>>();
    let solvers = registry.solvers().iter().map(|entry| Component::new(owned(entry.types), entry.help, entry.keys));
    let processes = registry.processes().iter().map(|entry| {
        let names = std::iter::once(entry.name).chain(entry.aliases.iter().copied()).collect::<Vec<_>>();
        Component::new(owned(&names), entry.help, entry.keys)
    });
    let modelers = registry.modelers().iter().map(|entry| Component {
        lists: (entry.lists)(),
        ..Component::new(owned(&[entry.name]), entry.help, entry.keys)
    });
    let cells = |category| {
        let of_kind = registry.cells(category);
        of_kind.map(|(name, shape)| Component::new(owned(&[name]), shape.name(), &[])).collect::<Vec<_>>()
    };
    let variables = registry.variables().iter().map(|variable| {
        Component::new(owned(&[variable.name]), &format!("{} [{}]", variable.help, variable.unit), &[])
    });
    let mut sections = vec![
        ("solvers (solver_type)", solvers.collect()),
        ("processes (python_module)", processes.collect()),
        ("modelers (name)", modelers.collect::<Vec<_>>()),
    ];
    for kind in registry.kinds() {
        sections.push((kind.title, (kind.describe)(registry).into_iter().map(Component::from).collect()));
    }
    sections.push(("elements", cells(Category::Element)));
    sections.push(("conditions", cells(Category::Condition)));
    sections.push(("variables", variables.collect()));
    sections
}

/// Lists everything, or shows one component.
pub fn info(arguments: &InfoArguments, registry: &Registry) -> ExitCode {
    let sections = sections(registry);
    if arguments.markdown {
        say!("{}", reference::page(&sections).trim_end());
        return ExitCode::SUCCESS;
    }
    let Some(wanted) = &arguments.name else {
        for (title, components) in &sections {
            say!("{title}");
            for component in components {
                say!("  {:48} {}", component.names[0], component.help);
            }
            say!("");
        }
        say!("bia info NAME shows the keys of one of them.");
        return ExitCode::SUCCESS;
    };
    let is_named = |component: &&Component| component.names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
    let mut found = false;
    for (title, components) in &sections {
        for component in components.iter().filter(is_named) {
            found = true;
            show(title, component);
        }
    }
    if found {
        return ExitCode::SUCCESS;
    }
    let names: Vec<&str> =
        sections.iter().flat_map(|(_, list)| list).flat_map(|c| &c.names).map(String::as_str).collect();
    let near = nearest(wanted, names).map_or(String::new(), |near| format!("; did you mean {near:?}?"));
    complain!("error: this program knows no {wanted:?}{near}");
    ExitCode::from(2)
}

fn show(title: &str, component: &Component) {
    say!("{} — {title}", component.names.join(", "));
    say!("  {}", component.help);
    show_keys(component.keys, 1);
    for (what, keys) in &component.lists {
        say!("  {what}:");
        show_keys(keys, 2);
    }
    for [name, unit, range, help] in &component.values {
        say!("  {name:36} [{unit}], {range}: {help}");
    }
}

fn show_keys(keys: &[Key], depth: usize) {
    for key in keys {
        let indent = "  ".repeat(depth);
        let default = default_of(key);
        let width = 38 - 2 * depth.min(10);
        say!("{indent}{:width$} {}, {default}: {}", key.name, kind_of(key.kind), key.help);
        if let Kind::Object(inner) = key.kind {
            show_keys(inner, depth + 1);
        }
    }
}

/// Whether a key must be given, or what holds without it.
pub(crate) fn default_of(key: &Key) -> String {
    match key.default {
        Default::Required => "required".to_string(),
        Default::Absent => "optional".to_string(),
        Default::Json(text) => format!("default {text}"),
    }
}

/// What values a key takes.
pub(crate) fn kind_of(kind: Kind) -> String {
    match kind {
        Kind::Bool => "true or false".into(),
        Kind::Integer { min } => format!("whole number >= {min}"),
        Kind::Number(range) => range.text.into(),
        Kind::NumberOr(range, words) => format!("{} or {}", range.text, words.join(", ")),
        Kind::Text => "text".into(),
        Kind::Choice(words) => words.join(" | "),
        Kind::Vector3 => "3 numbers".into(),
        Kind::Interval => "[start, end or \"End\"]".into(),
        Kind::Function => "number or function of x, y, z, t".into(),
        Kind::Functions3 => "3 numbers, functions or null".into(),
        Kind::Bools3 => "1 or 3 of true, false".into(),
        Kind::Texts => "list of texts".into(),
        Kind::List => "list".into(),
        Kind::Object(_) => "object".into(),
        Kind::Any => "any".into(),
    }
}

/// Prints the JSON Schema of projects.
pub fn schema(registry: &Registry) -> ExitCode {
    say!("{:#}", project_schema(registry));
    ExitCode::SUCCESS
}

/// Prints the completions of a shell.
pub fn completions(shell: Shell) -> ExitCode {
    clap_complete::generate(shell, &mut Cli::command(), "bia", &mut std::io::stdout());
    ExitCode::SUCCESS
}
