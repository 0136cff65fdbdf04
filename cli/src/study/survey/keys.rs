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
    Key::new("beside", Kind::List, "[]", "files with results of other programs on these scenes, as further columns"),
    Key::required("scenes", Kind::List, "rows of the matrix"),
];

/// Keys of a method.
pub const METHOD: &[Key] = &[
    Key::required("label", Kind::Text, "name in the report"),
    Key::new("text", Kind::Text, "\"\"", "a line about it"),
    Key::optional("set", Kind::Any, "values by JSON pointer that it sets in the projects of scenes"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
    Key::new("criteria", Kind::List, "[]", "what its runs must keep besides the criteria of their scenes"),
];

/// Keys of a scene.
pub const SCENE: &[Key] = &[
    Key::required("id", Kind::Text, "short name"),
    Key::required("title", Kind::Text, "name in the report"),
    Key::new("text", Kind::Text, "\"\"", "its set-up, and why it is hard"),
    Key::optional("like", Kind::Text, "id of a scene before it, of which it takes what it does not say itself"),
    Key::optional("project", Kind::Text, "project of all runs that name no own"),
    Key::optional("set", Kind::Any, "values of this project by JSON pointer, for all these runs"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
    Key::new("criteria", Kind::List, "[]", "what a run must keep, unless it has its own"),
    Key::new("time_limit", Kind::Number(Range::POSITIVE), "60.0", "instead of the survey's, if given [s]"),
    Key::optional("runs", Kind::Any, "runs by the label of their method"),
];

/// Keys of a run.
pub const RUN: &[Key] = &[
    Key::optional("cannot", Kind::Text, "why the method cannot run the scene; then nothing else is given"),
    Key::optional(
        "like",
        Kind::Text,
        "method before it in the scene, of whose run it takes what it does not say itself",
    ),
    Key::optional("project", Kind::Text, "its own project; then what method and scene set does not count"),
    Key::new("unset", Kind::List, "[]", "pointers that method, scene or the run it is like set, and it does not"),
    Key::optional("set", Kind::Any, "values of the project by JSON pointer; /- adds an entry to a list"),
    Key::optional("values", Kind::Any, "numbers and texts by name, for ${name} in what is set"),
    Key::optional("criteria", Kind::List, "its own criteria, instead of all others"),
    Key::optional("more_criteria", Kind::List, "criteria besides those of scene and method"),
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
        Key::optional("reason_contains", Kind::Text, "what its reason, or a warning, must tell"),
        Key::new("text", Kind::Text, "\"\"", "what the quantity is, with its unit"),
    ],
);

/// Keys of a file with results of another program, which a survey shows beside its own.
pub const BESIDE: &[Key] = &[
    Key::required("program", Kind::Text, "its name"),
    Key::required("version", Kind::Text, "its version"),
    Key::required("date", Kind::Text, "when it was measured"),
    Key::new("text", Kind::Text, "\"\"", "how it was measured"),
    Key::required("methods", Kind::Any, "its columns: headings, by the label of the method whose criteria judge them"),
    Key::required("scenes", Kind::Any, "results, by the id of the scene and then by the label of the method"),
];

/// Keys of a result of another program.
pub const RESULT: &[Key] = &[
    Key::required("end", Kind::Choice(&["done", "failed", "input", "timed_out", "cannot"]), "how it ended"),
    Key::new("reason", Kind::Text, "\"\"", "why, where it did not end well"),
    Key::optional("steps", Kind::Number(Range::NOT_NEGATIVE), "time steps"),
    Key::optional("cpu_s", Kind::Number(Range::NOT_NEGATIVE), "CPU time [s]"),
    Key::optional("found", Kind::Any, "(quantity - minus)/over by the text of the criterion; null if not finite"),
];
