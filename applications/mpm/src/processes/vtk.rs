//! Material points, their conditions and the background grid as VTK files (spec 07 §9).

use super::acceleration::check_part;
use crate::grid::GRID;
use crate::points::conditions::PointConditions;
use crate::points::fields::{CONDITION_VARIABLES, append, append_condition};
use crate::points::{MaterialPoints, Selection};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::control::OutputControl;
use bia_kernel::io::dataset::{Dataset, Field, FieldData};
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Parameters, Settings};
use bia_kernel::processes::vtk::{CellKind, FILES, VtkFiles, direct_parts, mesh_dataset};
use bia_kernel::processes::{Clock, Context, Location, Process, Requirements, Wanted};
use bia_kernel::registry::{ProcessEntry, Registry};
use std::path::PathBuf;

const KEYS: &[Key] = &Key::join::<14, 3, 17>(
    FILES,
    [
        Key::required("model_part_name", Kind::Text, "part of points, such as MPM_Material or MPM_Material.Body"),
        Key::new("output_path", Kind::Text, "\"MPM_VTK_Output\"", "folder of the files, emptied at the start")
            .or(&["folder_name"]),
        Key::new("gauss_point_variables_in_elements", Kind::Texts, "[]", "variables of points or their conditions")
            .or(&["gauss_point_results"]),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "mpm_vtk_output_process",
        aliases: &["particle_vtk_output_process"],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "material points and, once, the background grid as VTK files",
        build: |building| {
            let settings = building.settings;
            let files = VtkFiles::read(&settings, building.options)?;
            let control = OutputControl::read(&settings);
            let kind = CellKind::read(&settings);
            let parts = settings.flag("output_sub_model_parts");
            let (mut of_points, mut of_conditions) = (Vec::new(), Vec::new());
            for place in settings.get("gauss_point_variables_in_elements").map_or(Vec::new(), Parameters::entries) {
                let name = place.value().as_str().unwrap_or_default().to_string();
                let on_condition = match kind {
                    CellKind::Elements => false,
                    CellKind::Conditions => true,
                    CellKind::Automatic => parts && CONDITION_VARIABLES.contains(&name.as_str()),
                };
                if on_condition { &mut of_conditions } else { &mut of_points }.push((name, place));
            }
            Ok(Box::new(PointOutput { settings, files, control, kind, file: String::new(), of_points, of_conditions }))
        },
    });
}

struct PointOutput {
    settings: Settings,
    files: VtkFiles,
    control: OutputControl,
    kind: CellKind,
    /// How the names of the files of points begin, but for the prefix.
    file: String,
    /// Variables and the places that ask for them.
    of_points: Vec<(String, Parameters)>,
    of_conditions: Vec<(String, Parameters)>,
}

impl PointOutput {
    /// The path of the part: one that begins with the grid's name means the points, as in Kratos.
    fn path(&self, points: &MaterialPoints) -> String {
        let path = self.settings.text("model_part_name");
        path.strip_prefix(GRID).map_or_else(|| path.to_string(), |below| format!("{}{below}", points.name))
    }

    fn print(&mut self, model: &Model, clock: &Clock) -> Result<(), Error> {
        let Some(points) = model.extension::<MaterialPoints>() else { return Ok(()) };
        let path = self.path(points);
        let Some(selection) = points.select(&path) else { return Ok(()) };
        let name = path.rsplit('.').next().unwrap_or(&path);
        if self.kind == CellKind::Conditions {
            let data = self.conditions(&points.conditions, 0, points.conditions.len());
            return self.files.write(&self.files.name(name), clock, &data, true);
        }
        let data = self.points(points, selection);
        self.files.write(&self.files.name(name), clock, &data, true)?;
        if !self.settings.flag("output_sub_model_parts") || selection != Selection::All {
            return Ok(());
        }
        for (index, body) in points.bodies.iter().enumerate() {
            let data = self.points(points, Selection::Body(index));
            self.files.write(&self.files.name(&format!("{name}_{body}")), clock, &data, true)?;
        }
        for (part, first, end) in &points.conditions.parts {
            let data = self.conditions(&points.conditions, *first, *end);
            self.files.write(&self.files.name(&format!("{name}_{part}")), clock, &data, true)?;
        }
        Ok(())
    }

    /// The selected points, ascending by id.
    fn points(&self, points: &MaterialPoints, selection: Selection) -> Dataset {
        let order = points.by_id(selection);
        let block = |b: u32| &points.blocks[b as usize];
        let mut data = Dataset::vertices(order.iter().map(|&(b, p)| block(b).coordinates(p as usize)).collect());
        let mut fields = Vec::new();
        if self.settings.flag("write_ids") {
            fields.push(integers("PROPERTIES_ID", order.iter().map(|&(b, _)| block(b).material)));
            fields.push(integers("KRATOS_ELEMENT_ID", order.iter().map(|&(b, p)| block(b).ids[p as usize])));
        }
        for (variable, _) in &self.of_points {
            let mut values = Vec::new();
            order.iter().for_each(|&(b, p)| {
                append(block(b), p as usize, variable, &mut values);
            });
            fields.push(reals(variable, values, order.len()));
        }
        self.put(&mut data, fields);
        data
    }

    /// Material-point conditions from `first` to `end`.
    fn conditions(&self, conditions: &PointConditions, first: usize, end: usize) -> Dataset {
        let mut data = Dataset::vertices(conditions.position[first..end].to_vec());
        let mut fields = Vec::new();
        if self.settings.flag("write_ids") {
            fields.push(integers("PROPERTIES_ID", (first..end).map(|_| 0)));
            fields.push(integers("KRATOS_CONDITION_ID", conditions.ids[first..end].iter().copied()));
        }
        for (variable, _) in &self.of_conditions {
            let mut values = Vec::new();
            (first..end).for_each(|index| {
                append_condition(conditions, index, variable, &mut values);
            });
            fields.push(reals(variable, values, end - first));
        }
        self.put(&mut data, fields);
        data
    }

    /// Kratos puts values on the cells; ParaView shows values of points in more ways.
    fn put(&self, data: &mut Dataset, fields: Vec<Field>) {
        if self.files.is_vtu() { data.point_fields = fields } else { data.cell_fields = fields }
    }

    /// The background grid, which does not change.
    fn print_grid(&mut self, model: &Model, clock: &Clock) -> Result<(), Error> {
        let mut paths = vec![(GRID.to_string(), GRID.to_string())];
        if self.settings.flag("output_sub_model_parts") {
            let below = direct_parts(model, GRID).into_iter();
            paths.extend(below.map(|name| (format!("{GRID}.{name}"), format!("{GRID}_{name}"))));
        }
        for (path, name) in paths {
            if let (Some(grid), Some(members)) = (model.part(GRID), model.members(&path)) {
                let data = mesh_dataset(grid, &members, CellKind::Automatic, false, [&[], &[], &[]]);
                self.files.write_once(&name, clock, &data)?;
            }
        }
        Ok(())
    }
}

fn reals(name: &str, values: Vec<f64>, count: usize) -> Field {
    let components = values.len().checked_div(count).unwrap_or(1).max(1);
    Field { name: name.into(), components, values: FieldData::F64(values) }
}

fn integers(name: &str, values: impl Iterator<Item = u32>) -> Field {
    let values = values.map(|value| value as i32).collect();
    Field { name: name.into(), components: 1, values: FieldData::I32(values) }
}

impl Process for PointOutput {
    fn name(&self) -> &str {
        "mpm_vtk_output"
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        errors.absorb(check_part(model, &self.settings));
        let initial = model.parts().iter().find_map(|part| part.name.strip_prefix("Initial_"));
        let path = self.settings.text("model_part_name");
        let below = path.rsplit('.').next().unwrap_or(path);
        self.file = if path == GRID { initial.unwrap_or(path) } else { below }.into();
        errors.absorb(self.files.check_folder(&self.settings));
        errors.or(())
    }

    fn require(&self, requirements: &mut Requirements) {
        let points = self.of_points.iter().map(|wanted| (Location::Points, wanted));
        let conditions = self.of_conditions.iter().map(|wanted| (Location::PointConditions, wanted));
        requirements.variables.extend(points.chain(conditions).map(|(location, (variable, place))| Wanted {
            location,
            variable: variable.clone(),
            place: place.clone(),
        }));
        self.files.claim(&self.files.name(&self.file), requirements, self.settings.parameters());
    }

    fn execute_initialize(&mut self, _: &mut Context) -> Result<(), Error> {
        self.files.prepare()
    }

    /// The grid and the points at the start.
    fn print_start(&mut self, context: &mut Context) -> Result<(), Error> {
        self.print_grid(context.model, context.clock)?;
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
