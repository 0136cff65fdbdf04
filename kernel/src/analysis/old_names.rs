//! Old names in a project: taken, and told once each.

use super::Project;
use crate::parameters::{Key, Kind, Parameters};
use crate::registry::Registry;

/// An old name where it stands first.
struct Found {
    old: String,
    name: &'static str,
    place: Parameters,
    count: usize,
}

/// A warning for each old name of a process or a key, with its first place and the name to write instead.
pub(super) fn old_names(project: &Project, registry: &Registry) -> Vec<String> {
    let mut all = Vec::new();
    if let Some(settings) = &project.solver {
        add_keys(settings, registry.solver_keys(settings), &mut all);
    }
    for block in project.processes.iter().chain(&project.outputs) {
        let Some((module, entry)) = block.child("python_module").and_then(|module| {
            let entry = registry.process_named(module.value().as_str()?)?;
            Some((module, entry))
        }) else {
            continue;
        };
        let given = module.value().as_str().and_then(|name| name.rsplit('.').next()).unwrap_or_default();
        if given != entry.name {
            add(given, entry.name, &module, &mut all);
        }
        if let Some(parameters) = block.child("Parameters") {
            add_keys(&parameters, entry.keys, &mut all);
        }
    }
    all.iter().map(Found::warning).collect()
}

impl Found {
    fn warning(&self) -> String {
        let Self { old, name, place, count } = self;
        let more = if *count > 1 {
            format!(", here and at {} more place{}", count - 1, if *count > 2 { "s" } else { "" })
        } else {
            String::new()
        };
        place.warning(format!("{old:?} is an old name of {name:?}{more}")).to_string()
    }
}

fn add_keys(object: &Parameters, keys: &'static [Key], all: &mut Vec<Found>) {
    for key in keys {
        let old = key.aliases.iter().find_map(|old| Some((old, object.child(old)?)));
        if let Some((old, place)) = &old {
            add(old, key.name, place, all);
        }
        if let (Kind::Object(inner), Some(nested)) = (key.kind, object.child(key.name).or(old.map(|(_, place)| place)))
        {
            add_keys(&nested, inner, all);
        }
    }
}

fn add(old: &str, name: &'static str, place: &Parameters, all: &mut Vec<Found>) {
    match all.iter_mut().find(|found| found.old == old && found.name == name) {
        Some(found) => found.count += 1,
        None => all.push(Found { old: old.into(), name, place: place.clone(), count: 1 }),
    }
}
