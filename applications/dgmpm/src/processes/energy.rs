//! Energies of the points in time as a table.

use super::{elements_of, points_of};
use crate::engine::Points;
use crate::fields::energies;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::control::OutputControl;
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Range, Settings};
use bia_kernel::processes::measure::Extremes;
use bia_kernel::processes::{Clock, Context, Process, Requirements, Results};
use bia_kernel::registry::{ProcessEntry, Registry};
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

const KEYS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of the cells"),
    Key::new("output_control_type", Kind::Choice(&["step", "time"]), "\"step\"", "what output_interval counts"),
    Key::new("output_interval", Kind::Number(Range::NOT_NEGATIVE), "1.0", "between outputs [steps or s]"),
    Key::new("file_name", Kind::Text, "\"energy.dat\"", "name of the table"),
];

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "dgmpm_energy_output_process",
        aliases: &[],
        application: Some("DGMPMApplication"),
        keys: KEYS,
        help: "kinetic and strain energy of the points and the work of the whole boundary in time",
        build: |building| {
            let path = building.result_file(building.options.output.join(building.settings.text("file_name")))?;
            let control = OutputControl::read(&building.settings);
            let extremes = Extremes::of(["KINETIC", "STRAIN", "TOTAL", "SUPPLIED"].map(String::from).into());
            let (settings, elements) = (building.settings, Vec::new());
            Ok(Box::new(Energy { settings, path, file: None, control, elements, extremes }))
        },
    });
}

struct Energy {
    settings: Settings,
    path: PathBuf,
    file: Option<File>,
    control: OutputControl,
    elements: Vec<u32>,
    extremes: Extremes,
}

impl Energy {
    fn write(&mut self, line: &str) -> Result<(), Error> {
        let failed = |source| Error::Write { path: self.path.clone(), source };
        if self.file.is_none() {
            if let Some(folder) = self.path.parent() {
                std::fs::create_dir_all(folder).map_err(failed)?;
            }
            self.file = Some(File::create(&self.path).map_err(failed)?);
        }
        match &mut self.file {
            Some(file) => file.write_all(line.as_bytes()).map_err(failed),
            None => Ok(()),
        }
    }

    fn row(&mut self, model: &Model, clock: &Clock) -> Result<(), Error> {
        let Some(points) = model.extension::<Points>() else { return Ok(()) };
        let (kinetic, strain) = energies(points.body.as_ref(), points_of(points, &self.elements));
        let strain = strain.unwrap_or(f64::NAN);
        let (total, work) = (kinetic + strain, points.body.work());
        self.extremes.add(&[kinetic, strain, total, work]);
        self.write(&format!("{:?} {kinetic:e} {strain:e} {total:e} {work:e}\n", clock.time))
    }
}

impl Process for Energy {
    fn name(&self) -> &str {
        "dgmpm_energy_output"
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        self.elements = elements_of(model, &self.settings)?;
        Ok(())
    }

    fn require(&self, requirements: &mut Requirements) {
        requirements.energies = true;
    }

    fn print_start(&mut self, context: &mut Context) -> Result<(), Error> {
        let part = self.settings.text("model_part_name").to_string();
        self.write(&format!("# {part}\n# time kinetic_energy strain_energy their_sum boundary_work\n"))?;
        self.row(context.model, context.clock)
    }

    fn is_output_step(&mut self, context: &Context) -> bool {
        self.control.is_due(context.clock)
    }

    fn print_output(&mut self, context: &mut Context) -> Result<(), Error> {
        self.row(context.model, context.clock)?;
        self.control.printed(context.clock);
        Ok(())
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.control.exchange(archive)?;
        self.extremes.exchange(archive)?;
        archive.growing_file("table", &self.path, &mut self.file)
    }

    fn results(&self, results: &mut Results) {
        results.add_table(&self.path, &self.extremes);
    }

    fn files(&self) -> Vec<PathBuf> {
        self.file.iter().map(|_| self.path.clone()).collect()
    }
}
