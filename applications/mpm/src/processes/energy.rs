//! Energies of material points as a table (spec 07 §7).

use super::acceleration::check_part;
use crate::points::MaterialPoints;
use crate::points::fields::total_energies;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::control::OutputControl;
use bia_kernel::io::table::NumberFormat;
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Range, Settings};
use bia_kernel::processes::measure::Extremes;
use bia_kernel::processes::{Context, Process, Requirements, Results};
use bia_kernel::registry::{ProcessEntry, Registry};
use std::fs::File;
use std::io::Write;
use std::path::PathBuf;

const FILE: &[Key] = &[
    Key::new("file_name", Kind::Text, "\"\"", "name of the table, energy.dat by default"),
    Key::new("output_path", Kind::Text, "\"\"", "folder of the table"),
    Key::new("write_buffer_size", Kind::Any, "-1", "accepted"),
    Key::new("file_extension", Kind::Text, "\"dat\"", "extension"),
];
const KEYS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of points"),
    Key::new("output_control_type", Kind::Choice(&["step", "time"]), "\"step\"", "what output_interval counts"),
    Key::new("output_interval", Kind::Number(Range::NOT_NEGATIVE), "1.0", "between outputs [steps or s]"),
    Key::new("print_format", Kind::Text, "\".8f\"", "format of the numbers"),
    Key::new("interval", Kind::Interval, "[0.0, \"End\"]", "when it prints [s]"),
    Key::new("output_file_settings", Kind::Object(FILE), "{}", "the file"),
];

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "mpm_write_energy_output_process",
        aliases: &["mpm_write_energy_process"],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "potential, kinetic, strain and total energy of the points in time",
        build: |building| {
            let format = building.settings.text("print_format").to_string();
            let Some(format) = NumberFormat::parse(&format) else {
                let message = format!("{format:?} is no number format");
                let help = "a dot, the number of digits, and f or e: \".8f\", \".12e\"";
                return Err(building.settings.error("print_format", message).help(help).into());
            };
            let file = building.settings.nested("output_file_settings");
            let (name, folder, extension) = match file {
                Some(file) => (file.text("file_name"), file.text("output_path"), file.text("file_extension")),
                None => ("", "", "dat"),
            };
            let name = if name.is_empty() { "energy" } else { name };
            let name = if name.contains('.') { name.to_string() } else { format!("{name}.{extension}") };
            let path = building.result_file(building.options.output.join(folder).join(name))?;
            let control = OutputControl::read(&building.settings);
            let extremes = Extremes::of(["POTENTIAL", "KINETIC", "STRAIN", "TOTAL"].map(String::from).into());
            Ok(Box::new(Energy { settings: building.settings, path, file: None, format, control, extremes }))
        },
    });
}

struct Energy {
    settings: Settings,
    path: PathBuf,
    file: Option<File>,
    format: NumberFormat,
    control: OutputControl,
    extremes: Extremes,
}

impl Energy {
    fn write(&mut self, lines: &str) -> Result<(), Error> {
        let failed = |source| Error::Write { path: self.path.clone(), source };
        if self.file.is_none() {
            if let Some(folder) = self.path.parent() {
                std::fs::create_dir_all(folder).map_err(failed)?;
            }
            self.file = Some(File::create(&self.path).map_err(failed)?);
        }
        match &mut self.file {
            Some(file) => file.write_all(lines.as_bytes()).map_err(failed),
            None => Ok(()),
        }
    }

    fn row(&mut self, context: &Context) -> Result<(), Error> {
        let Some(points) = context.model.extension::<MaterialPoints>() else { return Ok(()) };
        let Some(selection) = points.select(self.settings.text("model_part_name")) else { return Ok(()) };
        let energies = total_energies(points, selection);
        let numbers = [energies.potential, energies.kinetic, energies.strain, energies.total()];
        self.extremes.add(&numbers);
        let row = numbers.map(|x| self.format.show(x)).join(" ");
        // Kratos's format is for the energies; the time has all its digits.
        self.write(&format!("{:?} {row}\n", context.clock.time))
    }
}

impl Process for Energy {
    fn name(&self) -> &str {
        "mpm_write_energy_output"
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        check_part(model, &self.settings)
    }

    fn require(&self, requirements: &mut Requirements) {
        requirements.energies = true;
        requirements.write(&self.path, self.settings.parameters());
    }

    fn print_start(&mut self, context: &mut Context) -> Result<(), Error> {
        let part = self.settings.text("model_part_name").to_string();
        self.write(&format!(
            "# Energy model part '{part}'\n# time potential_energy kinetic_energy strain_energy total_energy\n"
        ))?;
        self.row(context)
    }

    fn is_output_step(&mut self, context: &Context) -> bool {
        self.control.is_due(context.clock)
    }

    fn print_output(&mut self, context: &mut Context) -> Result<(), Error> {
        self.row(context)?;
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
