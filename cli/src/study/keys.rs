//! Keys of study files.

use bia_kernel::parameters::{Key, Kind, Range};

/// Keys of a study, `bia study STUDY.json`.
pub const STUDY: &[Key] = &[
    Key::optional("$schema", Kind::Any, "ignored"),
    Key::required("title", Kind::Text, "title of the report"),
    Key::new("text", Kind::Text, "\"\"", "what the reader should know"),
    Key::new("advice", Kind::Text, "\"\"", "what a user should choose"),
    Key::optional("project", Kind::Text, "project that all variants run unless they name their own"),
    Key::required(
        "error",
        Kind::Any,
        "label of an error process, JSON pointer into the summary, or quantity, minus, over",
    ),
    Key::new("error_name", Kind::Text, "\"relative error\"", "what the error is, with its unit, for the axes"),
    Key::new("size_name", Kind::Text, "\"h [m]\"", "what h is, with its unit, for the axes"),
    Key::new("repetitions", Kind::Integer { min: 1 }, "3", "runs of each case, for the spread of the CPU time"),
    Key::new("time_limit", Kind::Number(Range::POSITIVE), "60.0", "wall time after which a run is ended [s]"),
    Key::new("threads", Kind::Integer { min: 1 }, "1", "threads of each run"),
    Key::new("reference_slopes", Kind::List, "[1, 2]", "orders shown as lines in the diagram of convergence"),
    Key::new("wanted_errors", Kind::List, "[]", "errors for which the cheapest variant is told"),
    Key::optional("set", Kind::Any, "values of the project by JSON pointer, for all runs"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
    Key::required("variants", Kind::List, "methods that are compared"),
    Key::optional("sweep", Kind::List, "meshes, steps or tolerances with which each variant runs"),
];

/// Keys of a variant.
pub const VARIANT: &[Key] = &[
    Key::required("label", Kind::Text, "name in the report"),
    Key::new("text", Kind::Text, "\"\"", "a line about it"),
    Key::optional("project", Kind::Text, "its own project"),
    Key::optional("set", Kind::Any, "values of the project by JSON pointer; /- adds an entry to a list"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
    Key::optional("sweep", Kind::List, "its own sweep"),
];

/// Keys of an entry of a sweep.
pub const SWEEP: &[Key] = &[
    Key::required("label", Kind::Text, "name in the report"),
    Key::optional("h", Kind::Number(Range::POSITIVE), "size of the cells, or what else is refined"),
    Key::optional("set", Kind::Any, "values of the project by JSON pointer; /- adds an entry to a list"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
];
