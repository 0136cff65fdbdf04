//! Meshes and the values on their nodes as VTK files (spec 07 §9).

mod files;
mod mesh;

pub use files::{FILES, VtkFiles};
pub use mesh::{CellKind, direct_parts, mesh_dataset};

use super::quantity::Quantity;
use super::{Context, Location, Process, Requirements};
use crate::diagnostic::InputErrors;
use crate::error::Error;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::control::OutputControl;
use crate::model::{Members, Model};
use crate::parameters::{Key, Kind, Settings};
use crate::registry::{ProcessEntry, Registry};
use std::path::PathBuf;

const KEYS: &[Key] = &Key::join::<14, 10, 24>(
    FILES,
    [
        Key::required("model_part_name", Kind::Text, "part to be written, such as Background_Grid"),
        Key::new("output_path", Kind::Text, "\"VTK_Output\"", "folder of the files, emptied at the start")
            .or(&["folder_name"]),
        Key::new("nodal_solution_step_data_variables", Kind::Texts, "[]", "variables of nodes"),
        Key::new("nodal_data_value_variables", Kind::Texts, "[]", "variables of nodes too"),
        Key::new("nodal_flags", Kind::List, "[]", "must be empty: nodes have no flags"),
        Key::new("element_data_value_variables", Kind::Texts, "[]", "variables of elements"),
        Key::new(
            "condition_data_value_variables",
            Kind::Texts,
            "[]",
            "variables of conditions, with entity_type condition",
        ),
        Key::new("gauss_point_variables_extrapolated_to_nodes", Kind::List, "[]", "must be empty"),
        Key::new(
            "gauss_point_variables_in_elements",
            Kind::Texts,
            "[]",
            "variables of elements: means over their points",
        ),
        Key::new("write_deformed_configuration", Kind::Bool, "false", "accepted: the nodes do not move"),
    ],
);

/// Lists that name what does not exist here.
const EMPTY: &[&str] = &["nodal_flags", "gauss_point_variables_extrapolated_to_nodes"];

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "vtk_output_process",
        aliases: &[],
        application: None,
        keys: KEYS,
        help: "meshes and values on their nodes as VTK files",
        build: |building| {
            let settings = building.settings;
            let mut errors = InputErrors::default();
            errors.absorb(refuse_lists(&settings, EMPTY));
            let files = errors.absorb(VtkFiles::read(&settings, building.options));
            let mut read =
                |key| errors.absorb(Quantity::read_list(&settings, key, building.registry)).unwrap_or_default();
            let mut nodal = read("nodal_solution_step_data_variables");
            let conditional = read("condition_data_value_variables");
            let mut elemental = read("element_data_value_variables");
            elemental.extend(read("gauss_point_variables_in_elements"));
            // Kratos keeps two values of a variable on a node; here there is one, shown once.
            for quantity in read("nodal_data_value_variables") {
                if !nodal.iter().any(|other| other.name == quantity.name) {
                    nodal.push(quantity);
                }
            }
            let control = OutputControl::read(&settings);
            match files {
                Some(files) => errors.or(Box::new(MeshOutput {
                    settings,
                    files,
                    control,
                    nodal,
                    elemental,
                    conditional,
                    parts: Vec::new(),
                })),
                None => Err(errors),
            }
        },
    });
}

/// Refuses lists that are not empty.
///
/// # Errors
/// One for each of them.
pub fn refuse_lists(settings: &Settings, keys: &[&str]) -> Result<(), InputErrors> {
    let mut errors = InputErrors::default();
    for key in keys {
        if settings.get(key).is_some_and(|list| !list.entries().is_empty()) {
            let help = "flags and values extrapolated to nodes do not exist in Bia: leave the list empty";
            errors.push(settings.error(key, "nothing here provides what the list names").help(help));
        }
    }
    errors.or(())
}

struct MeshOutput {
    settings: Settings,
    files: VtkFiles,
    control: OutputControl,
    nodal: Vec<Quantity>,
    elemental: Vec<Quantity>,
    conditional: Vec<Quantity>,
    /// File name and members of each part to be written.
    parts: Vec<(String, Members)>,
}

impl Process for MeshOutput {
    fn name(&self) -> &str {
        "vtk_output"
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        errors.absorb(self.files.check_folder(&self.settings));
        let path = self.settings.text("model_part_name");
        let name = path.rsplit('.').next().unwrap_or(path);
        match model.members(path) {
            Some(members) => {
                self.parts.push((self.files.name(name), members));
                if self.settings.flag("output_sub_model_parts") {
                    self.parts.extend(direct_parts(model, path).into_iter().filter_map(|below| {
                        let members = model.members(&format!("{path}.{below}"))?;
                        Some((self.files.name(&format!("{name}_{below}")), members))
                    }));
                }
            }
            None => {
                let diagnostic = self.settings.error("model_part_name", format!("there is no model part {path:?}"));
                errors.absorb::<()>(Err(model.suggest_part(diagnostic, path).into()));
            }
        }
        errors.or(())
    }

    fn require(&self, requirements: &mut Requirements) {
        Quantity::require(&self.nodal, Location::Nodes, requirements);
        Quantity::require(&self.elemental, Location::Elements, requirements);
        for (name, _) in &self.parts {
            self.files.claim(name, requirements, self.settings.parameters());
        }
    }

    fn execute_initialize(&mut self, _: &mut Context) -> Result<(), Error> {
        self.files.prepare()
    }

    fn is_output_step(&mut self, context: &Context) -> bool {
        self.control.is_due(context.clock)
    }

    fn print_output(&mut self, context: &mut Context) -> Result<(), Error> {
        let kind = CellKind::read(&self.settings);
        let ids = self.settings.flag("write_ids");
        for (name, members) in &self.parts {
            let Some(part) = context.model.part(&members.root) else { continue };
            let data = mesh_dataset(part, members, kind, ids, [&self.nodal, &self.elemental, &self.conditional]);
            self.files.write(name, context.clock, &data, true)?;
        }
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
