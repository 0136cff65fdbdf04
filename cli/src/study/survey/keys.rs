//! Keys of survey files.

use crate::study::quantity::QUANTITY;
use bia_kernel::parameters::{Key, Kind, Range};

/// Keys of a survey, `bia survey SURVEY.json`.
pub const SURVEY: &[Key] = &[
    Key::optional("$schema", Kind::Any, "ignored"),
    Key::required("title", Kind::Text, "title of the report"),
    Key::new("text", Kind::Text, "\"\"", "what the reader should know"),
    Key::new("advice", Kind::Text, "\"\"", "what a user should take from it"),
    Key::new("repetitions", Kind::Integer { min: 1 }, "1", "runs of each cell, for the spread of the CPU time"),
    Key::new("time_limit", Kind::Number(Range::POSITIVE), "60.0", "wall time after which a run is ended [s]"),
    Key::new("threads", Kind::Integer { min: 1 }, "1", "threads of each run"),
    Key::required("methods", Kind::List, "columns of the matrix"),
    Key::required("scenes", Kind::List, "rows of the matrix"),
];

/// Keys of a method.
pub const METHOD: &[Key] = &[
    Key::required("label", Kind::Text, "name in the report"),
    Key::new("text", Kind::Text, "\"\"", "a line about it"),
];

/// Keys of a scene.
pub const SCENE: &[Key] = &[
    Key::required("id", Kind::Text, "short name"),
    Key::required("title", Kind::Text, "name in the report"),
    Key::new("text", Kind::Text, "\"\"", "its set-up, and why it is hard"),
    Key::optional("set", Kind::Any, "values of all its projects by JSON pointer"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
    Key::new("criteria", Kind::List, "[]", "what a run must keep, unless it has its own"),
    Key::new("time_limit", Kind::Number(Range::POSITIVE), "60.0", "instead of the survey's, if given [s]"),
    Key::required("runs", Kind::Any, "runs by the label of their method"),
];

/// Keys of a run.
pub const RUN: &[Key] = &[
    Key::optional("cannot", Kind::Text, "why the method cannot run the scene; then nothing else is given"),
    Key::optional("project", Kind::Text, "project"),
    Key::optional("set", Kind::Any, "values of the project by JSON pointer; /- adds an entry to a list"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
    Key::optional("criteria", Kind::List, "its own criteria"),
    Key::new("must", Kind::Bool, "false", "theory says that it passes"),
    Key::new("text", Kind::Text, "\"\"", "explanation, above all where it does not pass"),
];

/// Keys of a criterion of a quantity, or of the end.
pub const CRITERION: &[Key] = &Key::join::<4, 6, 10>(
    QUANTITY,
    [
        Key::optional("max", Kind::Number(Range::ANY), "passes up to this"),
        Key::optional("min", Kind::Number(Range::ANY), "passes from this on"),
        Key::optional("degraded", Kind::Number(Range::ANY), "is degraded, not failed, up to (or from) this"),
        Key::optional("expect", Kind::Choice(&["done", "failed", "input"]), "how the run must end"),
        Key::optional("reason_contains", Kind::Text, "what its reason must tell"),
        Key::new("text", Kind::Text, "\"\"", "what the quantity is, with its unit"),
    ],
);
