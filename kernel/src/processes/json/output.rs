//! Writes values of entities in time to a JSON file.

use super::{Countdown, EntitySource, SHARED, other_list, refuse_flags};
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::history::{HistoryWriter, Series};
use crate::model::Model;
use crate::parameters::{Key, Kind, Parameters};
use crate::processes::quantity::Quantity;
use crate::processes::{Context, Process, Requirements};
use crate::registry::Building;
use std::path::PathBuf;

/// Keys of a process that writes.
pub const WRITING: &[Key] = &Key::join::<8, 4, 12>(
    SHARED,
    [
        Key::new("output_variables", Kind::Texts, "[]", "variables of nodes"),
        Key::new(
            "gauss_points_output_variables",
            Kind::Texts,
            "[]",
            "variables of entities that carry values of their own",
        ),
        Key::required("output_file_name", Kind::Text, "the file"),
        Key::new("resultant_solution", Kind::Bool, "false", "write the sums over all entities as RESULTANT"),
    ],
);

/// The process.
pub struct JsonOutput<S> {
    name: &'static str,
    source: S,
    quantities: Vec<Quantity>,
    path: PathBuf,
    place: Parameters,
    resultant: bool,
    countdown: Countdown,
    writer: Option<HistoryWriter>,
}

impl<S: EntitySource> JsonOutput<S> {
    /// From settings with the keys [`WRITING`]; the key `list` names the variables, `other` is the
    /// one of the other kind of entity.
    ///
    /// # Errors
    /// Unknown variables, no file name.
    pub fn new(
        name: &'static str,
        building: &Building,
        source: S,
        [list, other]: [&str; 2],
    ) -> Result<Self, InputErrors> {
        let settings = &building.settings;
        let mut errors = InputErrors::default();
        errors.absorb(refuse_flags(settings));
        errors.absorb(other_list(settings, other, list, source.location()));
        let quantities = errors.absorb(Quantity::read_list(settings, list, building.registry)).unwrap_or_default();
        let file = settings.text("output_file_name");
        if file.is_empty() {
            errors.push(settings.error("output_file_name", "names no file"));
        }
        let (path, resultant) = (building.options.output.join(file), settings.flag("resultant_solution"));
        errors.absorb(building.result_file(path.clone()));
        let countdown = Countdown::new(settings);
        let place = settings.parameters().clone();
        errors.or(Self { name, source, quantities, path, place, resultant, countdown, writer: None })
    }

    fn failed(&self, source: std::io::Error) -> Error {
        Error::Write { path: self.path.clone(), source }
    }
}

impl<S: EntitySource> Process for JsonOutput<S> {
    fn name(&self) -> &str {
        self.name
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        self.source.connect(model)
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.quantities, self.source.location(), requirements);
        requirements.write(&self.path, &self.place);
    }

    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        let tensor = self.source.tensor_length(context.model);
        let series: Vec<Series> = self.quantities.iter().flat_map(|quantity| quantity.series(tensor)).collect();
        let mut writer = HistoryWriter::new(self.path.clone(), series);
        if self.resultant {
            writer.declare(RESULTANT);
        } else if !self.quantities.is_empty() {
            self.source.visit(context.model, &[], &mut |entity, _| writer.declare(entity.key))?;
        }
        writer.finish().map_err(|source| self.failed(source))?;
        self.writer = Some(writer);
        Ok(())
    }

    fn execute_finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        if !self.countdown.is_due(context.clock) {
            return Ok(());
        }
        let Some(writer) = &mut self.writer else { return Ok(()) };
        writer.begin(context.clock.time);
        if self.resultant {
            let mut sums: Vec<f64> = Vec::new();
            self.source.visit(context.model, &self.quantities, &mut |_, values| {
                sums.resize(values.len(), 0.0);
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            })?;
            writer.add(RESULTANT, &sums);
        } else if !self.quantities.is_empty() {
            self.source.visit(context.model, &self.quantities, &mut |entity, values| writer.add(entity.key, values))?;
        }
        writer.end().map_err(|source| Error::Write { path: self.path.clone(), source })
    }

    fn execute_finalize(&mut self, _: &mut Context) -> Result<(), Error> {
        let finished = self.writer.as_mut().map_or(Ok(()), HistoryWriter::finish);
        finished.map_err(|source| self.failed(source))
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.countdown.exchange(archive)?;
        let mut is_begun = self.writer.is_some();
        archive.flag("begun", &mut is_begun)?;
        if is_begun {
            let begin = || HistoryWriter::new(self.path.clone(), Vec::new());
            self.writer.get_or_insert_with(begin).exchange(archive)?;
        }
        Ok(())
    }

    fn files(&self) -> Vec<PathBuf> {
        self.writer.iter().map(|writer| writer.path().to_path_buf()).collect()
    }
}

const RESULTANT: &str = "RESULTANT";
