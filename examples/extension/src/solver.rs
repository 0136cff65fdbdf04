//! A solver: reads its settings, assembles its elements, solves each step, and shows temperatures.

use crate::element::HeatElement;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::{Error, Failure};
use bia_kernel::geometry::{Shape, rule};
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::json::JsonObject;
use bia_kernel::linalg::{Method, solver};
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::parameters::{Key, Kind, Range, Settings};
use bia_kernel::processes::vtk::{CellKind, mesh_dataset};
use bia_kernel::processes::{Clock, Context, Location, Requirements};
use bia_kernel::registry::{Registry, SolverEntry};
use bia_kernel::solving::mesh::MESH_IMPORT;
use bia_kernel::solving::solver::{Inventory, Solver, write_failed_state};
use bia_kernel::solving::stepping::TIME_STEPPING;
use bia_kernel::solving::{ActiveDofs, MeshSource, StepReport, Stepping, System};
use bia_kernel::variables::Variable;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Temperature of a node.
pub const TEMPERATURE: Variable = Variable::scalar("TEMPERATURE", "K", "temperature of a node");

const PART: &str = "Solid";

const KEYS: &[Key] = &[
    Key::required("solver_type", Kind::Text, "heat"),
    Key::required("domain_size", Kind::Integer { min: 1 }, "dimension of space"),
    Key::required("time_stepping", Kind::Object(TIME_STEPPING), "the time step [s]"),
    Key::new("model_import_settings", Kind::Object(MESH_IMPORT), "{}", "mesh of the part Solid"),
    Key::required("conductivity", Kind::Number(Range::POSITIVE), "k [W/(m K)]"),
    Key::new("heat_capacity", Kind::Number(Range::NOT_NEGATIVE), "0.0", "c per volume [J/(m³ K)]; 0: steady"),
    Key::new("initial_temperature", Kind::Number(Range::ANY), "0.0", "temperature at the start [K]"),
];

// [solver]
/// Heat conduction by backward differences in time.
pub const HEAT: SolverEntry = SolverEntry {
    types: &["heat"],
    keys: KEYS,
    help: "heat conduction in a solid",
    build: |parameters, _, options| {
        let settings = parameters.read(KEYS)?;
        let stepping = Stepping::read(&settings, false)?;
        let mesh = MeshSource::read(&settings, "model_import_settings", &options.folder)?;
        Ok(Box::new(Heat { settings, stepping, mesh, dofs: ActiveDofs::default(), system: None }))
    },
};
// [/solver]

struct Heat {
    settings: Settings,
    stepping: Stepping,
    mesh: MeshSource,
    dofs: ActiveDofs,
    system: Option<System>,
}

impl Heat {
    /// Finds the temperatures at the end of the step: the system is linear, so one solution does.
    fn step(&mut self, part: &mut ModelPart, time_step: f64) -> Result<StepReport, Error> {
        let missing = || Failure::new("the solver was not initialised", "report this as a fault of the program");
        let system = self.system.as_mut().ok_or_else(missing)?;
        let count = part.nodes.len();
        let start = part.node_fields.scalar(&TEMPERATURE).ok_or_else(missing)?.to_vec();
        let element = HeatElement {
            capacity_rate: self.settings.number("heat_capacity") / time_step,
            conductivity: self.settings.number("conductivity"),
        };
        system.clear(true);
        let cells = &part.elements;
        system.add_cells(true, |index, buffer| {
            let (shape, nodes) = (cells.shapes[index], cells.nodes_of(index));
            let corners = part.corners(cells, index);
            let values: Vec<f64> = nodes.iter().map(|&node| start[node as usize]).collect();
            let fault = || {
                let what = format!("the element {} is flat or inside out", cells.ids[index]);
                Failure::new(what, "a mesh whose elements have a volume")
            };
            let rule = rule(shape, points(shape)).map_err(|_| fault())?;
            // Supports have put the values of this step on held nodes, which counts as the state now.
            element.add(shape, &corners, &rule, [&values, &values], buffer).ok_or_else(fault)
        })?;
        let held = part.node_fields.fixed(&TEMPERATURE);
        let held: Vec<bool> =
            self.dofs.nodes().iter().map(|&node| held.is_some_and(|held| held[node as usize][0])).collect();
        let (mut change, rhs) = (vec![0.0; self.dofs.order()], &mut system.rhs);
        system.matrix.constrain(&held, rhs);
        let solved = solver(Method::Symmetric).solve(&system.matrix, rhs, &mut change);
        solved.map_err(|error| Failure::new(error.to_string(), "a fixed temperature somewhere, or a heat capacity"))?;
        let temperatures = part.node_fields.scalar_mut(&TEMPERATURE, count);
        self.dofs.nodes().iter().zip(&change).for_each(|(&node, change)| temperatures[node as usize] += change);
        Ok(StepReport { iterations: 1, converged: true, ..StepReport::default() })
    }
}

/// Points of quadrature: enough for N_a N_b.
fn points(shape: Shape) -> usize {
    match shape {
        Shape::Line2 => 2,
        Shape::Triangle3 => 3,
        Shape::Hexahedron8 => 8,
        _ => 4,
    }
}

impl Solver for Heat {
    fn import(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        let dimension = self.settings.integer("domain_size") as usize;
        self.mesh.import(model, PART, dimension, registry, (&self.settings, "model_import_settings"))
    }

    fn initialize(&mut self, model: &mut Model, requirements: &Requirements) -> Result<(), InputErrors> {
        let mut errors = InputErrors::default();
        requirements.choose(Location::Nodes, &[TEMPERATURE], &mut errors);
        for location in [Location::Points, Location::PointConditions, Location::Elements] {
            requirements.choose(location, &[], &mut errors);
        }
        errors.or(())?;
        let Some(part) = model.part_mut(PART) else { return Ok(()) };
        let all: Vec<u32> = (0..part.elements.len() as u32).collect();
        self.dofs = ActiveDofs::of_cells(1, part.nodes.len(), &part.elements, &all);
        self.system = Some(System::of_cells(&part.elements, &all, &self.dofs));
        let start = self.settings.number("initial_temperature");
        part.node_fields.scalar_mut(&TEMPERATURE, part.nodes.len()).fill(start);
        Ok(())
    }

    /// Temperatures stand in the model, which saves itself.
    fn exchange_state(&mut self, _: &mut Model, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn time_step(&mut self, _: &Model, clock: &Clock) -> Result<f64, Error> {
        self.stepping.step(clock, f64::INFINITY)
    }

    fn predict(&mut self, _: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    fn solve_solution_step(&mut self, context: &mut Context) -> Result<StepReport, Error> {
        match context.model.part_mut(PART) {
            Some(part) => self.step(part, context.clock.time_step),
            None => Ok(StepReport::default()),
        }
    }

    fn finalize_solution_step(&mut self, _: &mut Context) -> Result<(), Error> {
        Ok(())
    }

    fn inventory(&self, model: &Model) -> Inventory {
        let mut inventory = Inventory::default();
        let cells = model.part(PART).map_or(0, |part| part.elements.len());
        inventory.lines.push(("mesh".into(), format!("{cells} elements, {} temperatures", self.dofs.order())));
        inventory
    }

    fn energies(&self, _: &Model) -> Vec<(&'static str, f64)> {
        Vec::new()
    }

    fn account(&self, _: &Model) -> serde_json::Map<String, serde_json::Value> {
        serde_json::Map::new()
    }

    fn snapshot(&self, model: &Model, out: &mut JsonObject) -> std::io::Result<()> {
        match model.part(PART) {
            Some(part) => out.object("nodes", |out| part.node_fields.record(out)),
            None => Ok(()),
        }
    }

    fn stages(&self) -> Vec<(&'static str, Duration)> {
        Vec::new()
    }

    fn save_state(&self, model: &Model, folder: &Path) -> Result<Vec<PathBuf>, Error> {
        let (Some(part), Some(members)) = (model.part(PART), model.members(PART)) else { return Ok(Vec::new()) };
        let data = mesh_dataset(part, &members, CellKind::Elements, true, [&[], &[], &[]]);
        write_failed_state(&data, folder)
    }
}
