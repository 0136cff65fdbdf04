//! Measurements: numbers of a run as tables in time, so that nothing needs to be taken from result
//! files by hand.
//!
//! A [`Measurement`] says what is measured; [`TableOutput`] makes a process of it, with the keys that all of
//! them share ([`TABLE`]).

mod error;
mod extremes;
mod oscillation;
mod probe;
mod range;
mod resultant;
mod sample;

pub use extremes::Extremes;
pub use probe::positions;

use super::{Clock, Context, Interval, Process, Requirements, Results};
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::control::OutputControl;
use crate::io::table::{Heading, NumberFormat, TableWriter};
use crate::model::Model;
use crate::parameters::{Key, Kind, Parameters, Range};
use crate::registry::{Building, Registry};
use std::path::PathBuf;

const FILE: &[Key] = &[
    Key::new("file_name", Kind::Text, "\"\"", "name of the table; the measurement names it by default"),
    Key::new("output_path", Kind::Text, "\"\"", "folder of the table"),
    Key::new("write_buffer_size", Kind::Any, "-1", "accepted: each line is written at once"),
    Key::new("file_extension", Kind::Text, "\"csv\"", "extension"),
];

/// Keys that all measurements share, but for the part that they look at.
pub const TABLE: [Key; 7] = [
    Key::optional("help", Kind::Any, "ignored"),
    Key::new("interval", Kind::Interval, "[0.0, \"End\"]", "when it measures [s]"),
    Key::new("output_control_type", Kind::Choice(&["step", "time"]), "\"step\"", "what output_interval counts"),
    Key::new("output_interval", Kind::Number(Range::NOT_NEGATIVE), "1.0", "between measurements [steps or s]"),
    Key::optional(
        "output_times",
        Kind::List,
        "measures only at the first steps that reach these times [s], or \"End\"",
    ),
    Key::new("print_format", Kind::Text, "\"\"", "format of the numbers such as \".8e\"; all digits by default"),
    Key::new("output_file_settings", Kind::Object(FILE), "{}", "the file"),
];

/// What a table holds beside the time.
pub trait Measurement: Send {
    /// Name of the measurement and, unless the input says otherwise, of its file.
    fn name(&self) -> &'static str;

    /// Name of its file, without extension, unless the input names one.
    fn file_name(&self) -> String {
        self.name().into()
    }

    /// Resolves the names of model parts once the meshes are read.
    ///
    /// # Errors
    /// Names that do not exist, places outside of the mesh.
    fn connect(&mut self, model: &Model) -> Result<(), InputErrors>;

    /// Names the variables that it will read.
    fn require(&self, requirements: &mut Requirements);

    /// Once everything is set up, before the run: faults that show only now.
    ///
    /// # Errors
    /// Faults of the input, all together.
    #[allow(unused_variables)]
    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        Ok(())
    }

    /// What it keeps from one measurement to the next, as
    /// [`Process::exchange_state`](super::Process::exchange_state).
    ///
    /// # Errors
    /// The checkpoint does not fit.
    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError>;

    /// The columns, once all that is measured exists, before the run.
    fn headings(&mut self, model: &Model) -> Vec<Heading>;

    /// Adds what it has found to the summary of the run, beside what is told of every column.
    #[allow(unused_variables)]
    fn results(&self, results: &mut Results) {}

    /// Says what time it is before each measurement.
    #[allow(unused_variables)]
    fn tell(&mut self, clock: &Clock) {}

    /// Appends the present numbers, a row after the other, each as long as the headings.
    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>);
}

/// Registers the measurements of the kernel.
pub fn register(registry: &mut Registry) {
    probe::register(registry);
    resultant::register(registry);
    oscillation::register(registry);
    error::register(registry);
    range::register(registry);
}

/// When a table gets its rows.
enum Moments {
    Control(OutputControl),
    /// Times still to come, in s, the next one last; infinite for the end.
    Times(Vec<f64>),
}

/// The process that measures and writes.
pub struct TableOutput<M> {
    measurement: M,
    place: Parameters,
    interval: Interval,
    moments: Moments,
    table: TableWriter,
    extremes: Extremes,
    rows: Vec<f64>,
}

impl<M: Measurement> TableOutput<M> {
    /// From settings with the keys [`TABLE`].
    ///
    /// # Errors
    /// A number format that is none, times that are none, a file that is an input file.
    pub fn new(building: &Building, measurement: M) -> Result<Self, InputErrors> {
        let settings = &building.settings;
        let mut errors = InputErrors::default();
        let format = settings.text("print_format");
        let parsed = NumberFormat::parse(format);
        if parsed.is_none() {
            let help = "a dot, the number of digits, and f or e: \".8f\", \".12e\"";
            errors.push(settings.error("print_format", format!("{format:?} is no number format")).help(help));
        }
        let moments = match settings.get("output_times") {
            Some(list) => errors.absorb(times(list)).map(Moments::Times),
            None => Some(Moments::Control(OutputControl::read(settings))),
        };
        let file = settings.nested("output_file_settings");
        let text = |key: &str| file.map_or("", |file| file.text(key));
        let given = text("file_name");
        let name = if given.is_empty() { measurement.file_name() } else { given.to_string() };
        let name = if name.contains('.') { name } else { format!("{name}.{}", text("file_extension")) };
        let path = errors.absorb(building.result_file(building.options.output.join(text("output_path")).join(name)));
        let (place, interval) = (settings.parameters().clone(), Interval(settings.interval("interval")));
        match (parsed, moments, path) {
            (Some(format), Some(moments), Some(path)) => errors.or(Self {
                measurement,
                place,
                interval,
                moments,
                table: TableWriter::new(path, format),
                extremes: Extremes::default(),
                rows: Vec::new(),
            }),
            _ => Err(errors),
        }
    }

    fn is_due(&self, clock: &Clock) -> bool {
        let due = match &self.moments {
            Moments::Control(control) => control.is_due(clock),
            Moments::Times(times) => times.last().is_some_and(|time| has_come(*time, clock)),
        };
        due && self.interval.contains(clock.time)
    }

    fn write(&mut self, context: &Context) -> Result<(), Error> {
        self.rows.clear();
        self.measurement.tell(context.clock);
        self.measurement.measure(context.model, &mut self.rows);
        let width = self.extremes.width();
        let mut line = Vec::with_capacity(1 + width);
        for row in self.rows.chunks_exact(width.max(1)) {
            self.extremes.add(row);
            line.clear();
            line.push(context.clock.time);
            line.extend_from_slice(row);
            self.table.row(&line).map_err(|source| Error::Write { path: self.table.path().into(), source })?;
        }
        Ok(())
    }
}

/// The times of the list, the first one last.
fn times(list: &Parameters) -> Result<Vec<f64>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut times: Vec<f64> = Vec::new();
    for entry in list.entries() {
        match (entry.value().as_f64(), entry.value().as_str()) {
            (Some(time), _) => times.push(time),
            (None, Some("End")) => times.push(f64::INFINITY),
            _ => errors.push(entry.error("must be a time in seconds, or \"End\"")),
        }
    }
    times.sort_by(|a, b| b.total_cmp(a));
    errors.or(times)
}

/// Whether a time has come, up to round-off of the accumulated one; that of the end comes with the last
/// step.
fn has_come(time: f64, clock: &Clock) -> bool {
    let slack = 1e-12 * clock.end.abs();
    if time.is_infinite() { clock.time >= clock.end } else { clock.time >= time - slack }
}

impl<M: Measurement> Process for TableOutput<M> {
    fn name(&self) -> &str {
        self.measurement.name()
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        self.measurement.connect(model)
    }

    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        self.measurement.check(model)
    }

    fn require(&self, requirements: &mut Requirements) {
        requirements.write(self.table.path(), &self.place);
        self.measurement.require(requirements);
    }

    fn print_start(&mut self, context: &mut Context) -> Result<(), Error> {
        let headings = self.measurement.headings(context.model);
        self.extremes = Extremes::of(headings.iter().map(|heading| heading.name.clone()).collect());
        let all: Vec<Heading> = std::iter::once(Heading::new("TIME", "s")).chain(headings).collect();
        self.table.begin(&all).map_err(|source| Error::Write { path: self.table.path().into(), source })?;
        // The start counts as an output, but among times only where it is named.
        let (clock, starts) = (*context.clock, matches!(self.moments, Moments::Control(_)));
        if (starts && self.interval.contains(clock.time)) || (!starts && self.is_due(&clock)) {
            self.write(context)?;
        }
        if let Moments::Times(times) = &mut self.moments {
            times.retain(|time| !has_come(*time, &clock));
        }
        Ok(())
    }

    fn is_output_step(&mut self, context: &Context) -> bool {
        self.is_due(context.clock)
    }

    fn print_output(&mut self, context: &mut Context) -> Result<(), Error> {
        self.write(context)?;
        match &mut self.moments {
            Moments::Control(control) => control.printed(context.clock),
            Moments::Times(times) => times.retain(|time| !has_come(*time, context.clock)),
        }
        Ok(())
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        match &mut self.moments {
            Moments::Control(control) => control.exchange(archive)?,
            Moments::Times(times) => archive.column("times", times)?,
        }
        self.extremes.exchange(archive)?;
        self.measurement.exchange_state(archive)?;
        self.table.exchange(archive)
    }

    fn results(&self, results: &mut Results) {
        results.add_table(self.table.path(), &self.extremes);
        self.measurement.results(results);
    }

    fn files(&self) -> Vec<PathBuf> {
        if self.table.is_begun() { vec![self.table.path().to_path_buf()] } else { Vec::new() }
    }
}
