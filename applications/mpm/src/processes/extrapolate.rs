//! Values of material points on the nodes of the background grid: Q_i = Σ N_i m Q_p / Σ N_i m.
//!
//! Bia's own, with the functions of the mesh's cells at the present positions, or at the first ones in
//! a total-Lagrangian run.

use super::acceleration::check_part;
use crate::grid::GRID;
use crate::points::fields::append;
use crate::points::{Block, MaterialPoints, Selection};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::error::Error;
use bia_kernel::geometry::CellLocator;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::parameters::{Key, Kind, Settings};
use bia_kernel::processes::quantity::Quantity;
use bia_kernel::processes::{Context, Location, Process, Requirements, Wanted};
use bia_kernel::registry::{ProcessEntry, Registry};
use bia_kernel::variables::{Rank, Variable};

const KEYS: &[Key] = &[
    Key::new("model_part_name", Kind::Text, "\"MPM_Material\"", "part of points, such as MPM_Material.Body"),
    Key::required("variables", Kind::Texts, "variables of points, which nodes then have under the same names"),
    Key::new(
        "evaluate",
        Kind::Choice(&["step", "output"]),
        "\"step\"",
        "at the end of each step, or only before files are written (JSON processes then see the values of the last file)",
    ),
];

/// How far outside of a cell a point may lie, in local coordinates.
const TOLERANCE: f64 = 1e-5;

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "extrapolate_material_point_results_to_grid_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "averages of the points' values, weighted by mass and shape function, on the grid's nodes",
        build: |building| {
            let quantities = Quantity::read_list(&building.settings, "variables", building.registry)?;
            let mut errors = InputErrors::default();
            for (i, quantity) in quantities.iter().enumerate() {
                let twice = quantities[..i].iter().any(|other| other.name == quantity.name);
                if twice || quantity.component.is_some() {
                    let what = if twice { "stands twice" } else { "is a component: name the whole vector" };
                    errors.push(quantity.place.error(format!("{:?} {what}", quantity.name)));
                }
            }
            if quantities.is_empty() {
                errors.push(building.settings.error("variables", "names no variable"));
            }
            let at_output = building.settings.text("evaluate") == "output";
            let frame = building.project.child("solver_settings").and_then(|solver| solver.child("frame"));
            let total = frame.is_some_and(|frame| frame.value() == "total_lagrangian");
            let (settings, locator, sums) = (building.settings, None, Sums::default());
            errors.or(Box::new(Extrapolation { settings, quantities, at_output, total, locator, done: None, sums }))
        },
    });
}

struct Extrapolation {
    settings: Settings,
    quantities: Vec<Quantity>,
    at_output: bool,
    /// The points stay where they first were, as far as the grid goes.
    total: bool,
    /// Search among the grid's cells, of its own: solvers keep local coordinates in various forms.
    locator: Option<CellLocator>,
    /// The step whose values stand on the nodes.
    done: Option<usize>,
    sums: Sums,
}

/// Sums over the points on each node of the grid; memory that stays from call to call.
#[derive(Default)]
struct Sums {
    /// Σ N m.
    mass: Vec<f64>,
    /// Σ N m Q, node after node.
    weighted: Vec<f64>,
    /// Numbers a node.
    width: usize,
    /// Q of one point.
    row: Vec<f64>,
}

impl Sums {
    /// Adds up a variable of the selected points, body by body in the order of their ids.
    fn gather(&mut self, of: &Source, selection: Selection, variable: &str) {
        let grid = of.grid;
        let count = grid.nodes.len();
        self.mass.clear();
        self.mass.resize(count, 0.0);
        self.weighted.clear();
        self.width = 0;
        for block in of.points.blocks.iter().filter(|block| selection.holds(block.body)) {
            for point in block.in_order_of_id().into_iter().map(|point| point as usize) {
                // Points that have just left the grid have no part in it.
                let found = of.locator.locate(of.position(block, point), Some(block.cell[point]));
                let Some((cell, xi)) = found else { continue };
                self.row.clear();
                append(block, point, variable, &mut self.row);
                self.width = self.row.len();
                self.weighted.resize(count * self.width, 0.0);
                let mut functions = [0.0; 8];
                grid.elements.shapes[cell as usize].functions(xi, &mut functions);
                let mass = block.mass.row(point)[0];
                for (&node, function) in grid.elements.nodes_of(cell as usize).iter().zip(functions) {
                    let (node, share) = (node as usize, function * mass);
                    self.mass[node] += share;
                    let sums = &mut self.weighted[node * self.width..(node + 1) * self.width];
                    sums.iter_mut().zip(&self.row).for_each(|(sum, value)| *sum += share * value);
                }
            }
        }
    }

    /// Writes the averages to the grid; nodes without mass get 0.
    fn write(&self, grid: &mut ModelPart, variable: &Variable) {
        if self.width == 0 {
            return;
        }
        let count = self.mass.len();
        let target = match variable.rank {
            Rank::Scalar => grid.node_fields.scalar_mut(variable, count),
            Rank::Vector => grid.node_fields.vector_mut(variable, count).as_flattened_mut(),
            Rank::Voigt | Rank::Tensor => grid.node_fields.rows_mut(variable, self.width, count).values_mut(),
        };
        let rows = target.chunks_exact_mut(self.width).zip(self.weighted.chunks_exact(self.width));
        for ((row, sums), mass) in rows.zip(&self.mass) {
            let inverse = if *mass > 0.0 { 1.0 / mass } else { 0.0 };
            row.iter_mut().zip(sums).for_each(|(value, sum)| *value = sum * inverse);
        }
    }
}

/// What the sums are of.
struct Source<'a> {
    points: &'a MaterialPoints,
    grid: &'a ModelPart,
    locator: &'a CellLocator,
    total: bool,
}

impl Source<'_> {
    /// Where the grid sees a point, in m.
    fn position(&self, block: &Block, point: usize) -> [f64; 3] {
        let mut x = block.coordinates(point);
        if self.total {
            x.iter_mut().zip(block.displacement.row(point)).for_each(|(x, u)| *x -= u);
        }
        x
    }
}

impl Extrapolation {
    fn evaluate(&mut self, context: &mut Context) {
        if self.done.replace(context.clock.step) == Some(context.clock.step) {
            return;
        }
        let Some(points) = context.model.take::<MaterialPoints>() else { return };
        let selection = points.select(self.settings.text("model_part_name"));
        if let (Some(grid), Some(selection)) = (context.model.part_mut(GRID), selection) {
            let locator = self.locator.get_or_insert_with(|| CellLocator::new(grid, TOLERANCE));
            for quantity in &self.quantities {
                let source = Source { points: &points, grid, locator, total: self.total };
                self.sums.gather(&source, selection, quantity.variable.name);
                self.sums.write(grid, &quantity.variable);
            }
        }
        context.model.put(points);
    }
}

impl Process for Extrapolation {
    fn name(&self) -> &str {
        "extrapolate_material_point_results_to_grid"
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        check_part(model, &self.settings)
    }

    fn require(&self, requirements: &mut Requirements) {
        for quantity in &self.quantities {
            requirements.provide(quantity.variable.name, &quantity.place);
        }
        Quantity::require(&self.quantities, Location::Points, requirements);
        if self.total {
            let (variable, place) = ("MP_DISPLACEMENT".into(), self.settings.parameters().clone());
            requirements.variables.push(Wanted { location: Location::Points, variable, place });
        }
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        let (mut is_done, mut step) = (self.done.is_some(), self.done.unwrap_or_default());
        archive.flag("done", &mut is_done)?;
        archive.count("step", &mut step)?;
        self.done = is_done.then_some(step);
        Ok(())
    }

    fn execute_initialize(&mut self, context: &mut Context) -> Result<(), Error> {
        self.evaluate(context);
        Ok(())
    }

    /// The initial velocities may have come since.
    fn execute_before_solution_loop(&mut self, context: &mut Context) -> Result<(), Error> {
        self.done = None;
        self.evaluate(context);
        Ok(())
    }

    fn execute_finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        if !self.at_output {
            self.evaluate(context);
        }
        Ok(())
    }

    fn execute_before_output_step(&mut self, context: &mut Context) -> Result<(), Error> {
        self.evaluate(context);
        Ok(())
    }
}
