//! Material points as VTK files. The cells are written by the kernel's `vtk_output_process`.

use super::{elements_of, points_of};
use crate::engine::Points;
use crate::fields::{DERIVED, OF_POINTS};
use crate::results::{dataset, field};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::control::OutputControl;
use bia_kernel::io::dataset::{Field, FieldData};
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind};
use bia_kernel::parameters::{Parameters, Settings};
use bia_kernel::processes::vtk::{FILES, VtkFiles};
use bia_kernel::processes::{Clock, Context, Location, Process, Requirements, Wanted};
use bia_kernel::registry::{ProcessEntry, Registry};
use std::path::PathBuf;

const KEYS: &[Key] = &Key::join::<14, 3, 17>(
    FILES,
    [
        Key::required("model_part_name", Kind::Text, "part of the cells whose points are written"),
        Key::new("output_path", Kind::Text, "\"DGMPM_VTK_Output\"", "folder of the files, emptied at the start")
            .or(&["folder_name"]),
        Key::new("gauss_point_variables_in_elements", Kind::Texts, "[]", "variables of points")
            .or(&["gauss_point_results"]),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "dgmpm_vtk_output_process",
        aliases: &[],
        application: Some("DGMPMApplication"),
        keys: KEYS,
        help: "material points as VTK files",
        build: |building| {
            let settings = building.settings;
            let files = VtkFiles::read(&settings, building.options)?;
            let control = OutputControl::read(&settings);
            Ok(Box::new(PointOutput { settings, files, control, elements: Vec::new() }))
        },
    });
}

struct PointOutput {
    settings: Settings,
    files: VtkFiles,
    control: OutputControl,
    elements: Vec<u32>,
}

impl PointOutput {
    fn variables(&self) -> Vec<Parameters> {
        self.settings.get("gauss_point_variables_in_elements").map_or(Vec::new(), Parameters::entries)
    }

    fn print(&mut self, model: &Model, clock: &Clock) -> Result<(), Error> {
        let Some(points) = model.extension::<Points>() else { return Ok(()) };
        let (engine, chosen) = (points.body.as_ref(), points_of(points, &self.elements).collect::<Vec<_>>());
        let mut data = dataset(engine, &chosen);
        let mut fields = Vec::new();
        if self.settings.flag("write_ids") {
            let integers = |name: &str, of: &dyn Fn(usize) -> i32| Field {
                name: name.into(),
                components: 1,
                values: FieldData::I32(chosen.iter().map(|&point| of(point)).collect()),
            };
            fields.push(integers("PROPERTIES_ID", &|point| engine.point(point).material as i32));
            fields.push(integers("KRATOS_ELEMENT_ID", &|point| point as i32 + 1));
        }
        for place in self.variables() {
            let name = place.value().as_str().unwrap_or_default();
            if let Some(variable) = OF_POINTS.iter().chain(DERIVED).find(|variable| variable.name == name) {
                fields.push(field(engine, &chosen, variable));
            }
        }
        // ParaView shows values of points in more ways; Kratos puts them on the cells.
        if self.files.is_vtu() {
            data.point_fields = fields
        } else {
            data.cell_fields = fields
        }
        let path = self.settings.text("model_part_name");
        let name = self.files.name(path.rsplit('.').next().unwrap_or(path));
        self.files.write(&name, clock, &data, true)
    }
}

impl Process for PointOutput {
    fn name(&self) -> &str {
        "dgmpm_vtk_output"
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        self.elements = errors.absorb(elements_of(model, &self.settings)).unwrap_or_default();
        errors.absorb(self.files.check_folder(&self.settings));
        errors.or(())
    }

    fn require(&self, requirements: &mut Requirements) {
        requirements.variables.extend(self.variables().into_iter().map(|place| Wanted {
            location: Location::Points,
            variable: place.value().as_str().unwrap_or_default().to_string(),
            place,
        }));
        let path = self.settings.text("model_part_name");
        let name = self.files.name(path.rsplit('.').next().unwrap_or(path));
        self.files.claim(&name, requirements, self.settings.parameters());
    }

    fn execute_initialize(&mut self, _: &mut Context) -> Result<(), Error> {
        self.files.prepare()
    }

    fn print_start(&mut self, context: &mut Context) -> Result<(), Error> {
        self.print(context.model, context.clock)
    }

    fn is_output_step(&mut self, context: &Context) -> bool {
        self.control.is_due(context.clock)
    }

    fn print_output(&mut self, context: &mut Context) -> Result<(), Error> {
        self.print(context.model, context.clock)?;
        self.control.printed(context.clock);
        Ok(())
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.control.exchange(archive)?;
        self.files.exchange(archive)
    }

    fn files(&self) -> Vec<PathBuf> {
        self.files.written().to_vec()
    }
}
