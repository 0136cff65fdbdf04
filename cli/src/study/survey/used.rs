//! What runs used, and what they did without, beside the run that used most.

use crate::study::chart::escaped;
use crate::study::outcome::Outcome;
use crate::study::page::{Table, counted, shown};
use serde_json::Value;

/// What the runs of a scene used, by their labels, and at the end the fullest run of all scenes; nothing if
/// none of them tells.
pub fn used<'a>(runs: impl Iterator<Item = (&'a str, &'a Outcome)>, fullest: Option<(&str, &Outcome)>) -> String {
    let mut table =
        Table::new(&["method", "columns", "left out", "unknowns", "stages", "bytes a point", "of the fullest", "MB"])
            .of_texts();
    let most = fullest.and_then(|(_, outcome)| bytes(outcome));
    let mut any = false;
    for (label, outcome) in runs.filter(|(_, outcome)| outcome.summary()["columns"].is_array()) {
        any = true;
        table.row(&cells(label, outcome, most));
    }
    if !any {
        return String::new();
    }
    if let Some((name, outcome)) = fullest {
        table.row(&cells(&format!("the fullest of all: {name}"), outcome, most));
    }
    format!("<details><summary>What was used and what was left out</summary>\n{}</details>\n", table.html())
}

/// The first of the runs that use most bytes a point.
pub fn fullest<'a>(runs: impl Iterator<Item = (&'a str, &'a Outcome)>) -> Option<(&'a str, &'a Outcome)> {
    let weighed = runs.filter_map(|(name, outcome)| Some((name, outcome, bytes(outcome)?)));
    let most = weighed.reduce(|most, one| if one.2 > most.2 { one } else { most });
    most.map(|(name, outcome, _)| (name, outcome))
}

fn bytes(outcome: &Outcome) -> Option<f64> {
    outcome.number("/bytes_per_point")
}

fn cells(label: &str, outcome: &Outcome, most: Option<f64>) -> [String; 8] {
    let share = bytes(outcome).zip(most).map(|(bytes, most)| format!("{:.0} %", 100.0 * bytes / most));
    [
        escaped(label),
        names(outcome, "/columns", Some("name")),
        names(outcome, "/left_out", None),
        counted(outcome.number("/unknowns")),
        names(outcome, "/stages", None),
        shown(bytes(outcome)),
        share.unwrap_or_default(),
        shown(outcome.number("/peak_memory_mb")),
    ]
}

/// The texts of a list of the summary, or those at a key of its entries.
fn names(outcome: &Outcome, pointer: &str, key: Option<&str>) -> String {
    let list = outcome.summary().pointer(pointer).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    let name = |entry: &Value| key.map_or(entry, |key| &entry[key]).as_str().map(str::to_owned);
    escaped(&list.iter().filter_map(name).collect::<Vec<_>>().join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_fullest_is_the_same_each_time() {
        let of = |bytes: f64| {
            let summary = json!({"columns": [{"name": "mass"}], "left_out": ["volume"], "bytes_per_point": bytes});
            Outcome::new(vec![json!({"end": "done", "summary": summary})])
        };
        let (a, b, c) = (of(64.0), of(128.0), of(128.0));
        let runs = || [("a", &a), ("b", &b), ("c", &c)].into_iter();
        assert_eq!(fullest(runs()).map(|(name, _)| name), Some("b"), "the first of two");
        let table = used(runs().take(1), fullest(runs()));
        for part in ["<td>a</td>", "50 %", "mass", "volume", "the fullest of all: b", "100 %"] {
            assert!(table.contains(part), "{part:?} is not in {table}");
        }
        assert_eq!(used(runs().take(0), fullest(runs())), "");
    }
}
