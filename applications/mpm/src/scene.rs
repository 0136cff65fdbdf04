//! What all solvers of the application share: meshes, materials, points, columns, the search, and
//! the motion of conditions.

use crate::active::search;
use crate::grid::GRID;
use crate::points::MaterialPoints;
use crate::points::carriers;
use crate::points::conditions::{self, PointConditions, Requests};
use crate::points::{Columns, Plan, fields, generate};
use crate::settings::{Frame, Regime, SolverSettings};
use crate::space::Space;
use crate::variables::DISPLACEMENT;
use bia_constitutive::{BodyMaterial, Catalogue};
use bia_kernel::diagnostic::{Diagnostic, InputErrors, Place};
use bia_kernel::error::{Error, Failure};
use bia_kernel::geometry::CellLocator;
use bia_kernel::model::{Model, ModelPart, PointSet};
use bia_kernel::processes::{Location, Requirements, RunOptions};
use bia_kernel::registry::Registry;
use bia_kernel::solving::ActiveDofs;

/// Nodal variables that the solver can show.
pub const NODAL_VARIABLES: &[&str] = &[
    "DISPLACEMENT",
    "VELOCITY",
    "ACCELERATION",
    "REACTION",
    "NODAL_MASS",
    "POINT_LOAD",
    "LINE_LOAD",
    "SURFACE_LOAD",
    "POSITIVE_FACE_PRESSURE",
    "NEGATIVE_FACE_PRESSURE",
];

/// Nodal variables that mixed formulations have beside these.
pub const PRESSURE_VARIABLES: &[&str] = &["PRESSURE", "PRESSURE_REACTION"];

/// Losses of points that the log tells as they happen.
const TOLD: usize = 3;

/// A scene: its settings, its materials and the search on its grid.
pub struct Scene {
    /// Settings.
    pub settings: SolverSettings,
    /// Choices of the run.
    pub options: RunOptions,
    /// Materials.
    pub materials: Vec<BodyMaterial>,
    /// Search on the grid, once it is there.
    pub locator: Option<CellLocator>,
    /// The grid's functions, once it is there.
    pub space: Space,
    /// Whether points on faces of cells are taken to stand a little within.
    pub insets: bool,
    /// Whether loads or supports that move have worked on the bodies in any step, and how much is not known.
    pub was_worked_on: bool,
    /// Work in J of loads and supports that move, where the solver counts it.
    pub work: f64,
    catalogue: Catalogue,
    told_losses: usize,
}

impl Scene {
    /// A scene without meshes.
    pub fn new(settings: SolverSettings, options: RunOptions) -> Self {
        let catalogue = Catalogue::default();
        let (space, insets) = (Space::default(), !options.kratos_exact);
        let (materials, locator, was_worked_on, told_losses) = (Vec::new(), None, false, 0);
        Self { settings, options, materials, locator, space, insets, was_worked_on, work: 0.0, catalogue, told_losses }
    }

    /// Reads meshes and materials.
    ///
    /// # Errors
    /// All faults together.
    pub fn import(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        let initial = format!("Initial_{}", self.settings.part);
        let mut errors = InputErrors::default();
        for (name, source, key) in [
            (GRID, &self.settings.grid, "grid_model_import_settings"),
            (initial.as_str(), &self.settings.bodies, "model_import_settings"),
        ] {
            let settings = (&self.settings.settings, key);
            errors.absorb(source.import(model, name, self.settings.dimension, registry, settings));
            if name == GRID && model.part(name).is_some_and(|part| part.elements.is_empty()) {
                let place = source.file().map_or_else(Place::default, Place::file);
                errors.push(Diagnostic::error(place, "the background grid has no elements"));
            }
        }
        self.catalogue = registry.catalogue::<Catalogue>().cloned().unwrap_or_default();
        if let Some(bodies) = model.part_mut(&initial) {
            let roots = [initial.as_str(), self.settings.part.as_str()];
            self.materials =
                errors.absorb(self.settings.materials.assign(bodies, &roots, &self.catalogue)).unwrap_or_default();
        }
        errors.or(())
    }

    /// Makes the points with the columns that the solver needs and those that processes read. Says
    /// whether the tangents of all laws are symmetric.
    ///
    /// # Errors
    /// Faults that show only now: of points, conditions, and variables that nobody provides.
    pub fn make_points(
        &mut self,
        model: &mut Model,
        requirements: &Requirements,
        needed: Columns,
    ) -> Result<bool, InputErrors> {
        let initial = format!("Initial_{}", self.settings.part);
        let mut columns = needed.or(self.columns(requirements)?);
        if self.settings.explicit.is_none() {
            // Implicit steps advance both together.
            let moves = columns.velocity || columns.acceleration;
            (columns.velocity, columns.acceleration) = (moves, moves);
        }
        let requests = model.extension::<Requests>().cloned().unwrap_or_default();
        let (Some(grid), Some(bodies)) = (model.part(GRID), model.part(&initial)) else {
            return Ok(true);
        };
        let dimension = self.settings.dimension;
        if let Some(cell) = grid.elements.shapes.iter().position(|shape| shape.dimension() != dimension) {
            let (id, name) = (grid.elements.ids[cell], grid.elements.name_of(cell));
            let message = format!("is {dimension}, but grid element {id} is a {name}");
            return Err(self.settings.settings.error("domain_size", message).into());
        }
        let space = Space::new(grid, &self.settings.discretisation, &self.settings.settings)?;
        let space = if self.insets { space } else { space.without_inset() };
        if !space.is_mesh() && !grid.node_fields.slides(&DISPLACEMENT).is_empty() {
            let message = "walls to slide along need the functions of the mesh";
            let help = "fix the normal component of walls that stand along the axes, or leave \"basis\" out";
            return Err(self.settings.settings.parameters().error(message).help(help).into());
        }
        let locator = CellLocator::new(grid, self.settings.search_tolerance);
        let kinematics = self.settings.kinematics();
        let plan = Plan {
            grid,
            bodies,
            materials: &self.materials,
            catalogue: &self.catalogue,
            locator: &locator,
            kinematics,
            dynamic: self.settings.regime == Regime::Dynamic,
            placement: self.settings.discretisation.placement,
            columns,
            kratos_exact: self.options.kratos_exact,
            explicit: self.settings.explicit.is_some(),
            mixed: self.settings.mixed.map(|mixed| mixed.volumetric),
            part: &self.settings.part,
            file: self.settings.bodies.file(),
        };
        let mut points = generate(&plan)?;
        let elements = grid.elements.len() + bodies.elements.len() + points.len();
        points.conditions = conditions::generate(grid, &requests, &locator, elements)?;
        carriers::choose(&mut points);
        localise(&mut points, &space);
        let symmetric = points.blocks.iter().all(|block| block.law.is_symmetric());
        tracing::debug!("{}", locator.describe());
        (self.locator, self.space) = (Some(locator), space);
        model.extend(points);
        model.set_points(|model| model.extension::<MaterialPoints>().map(|points| points as &dyn PointSet));
        Ok(symmetric)
    }

    /// The columns that the processes need, and nothing else.
    fn columns(&self, requirements: &Requirements) -> Result<Columns, InputErrors> {
        let mut columns = Columns::default();
        let mut errors = InputErrors::default();
        let mixed = self.settings.mixed.is_some();
        let of_pressure = if mixed { PRESSURE_VARIABLES } else { &[] };
        let nodal = || NODAL_VARIABLES.iter().chain(of_pressure).chain(&requirements.provided).copied();
        for wanted in &requirements.variables {
            let name = wanted.variable.as_str();
            let unknown = |names: &mut dyn Iterator<Item = &'static str>| requirements.nobody(wanted, names);
            match wanted.location {
                Location::Points => match fields::columns_of(name).filter(|needed| mixed || !needed.pressure) {
                    Some(needed) => columns = columns.or(needed),
                    None => errors.push(unknown(&mut fields::names())),
                },
                Location::PointConditions if !fields::CONDITION_VARIABLES.contains(&name) => {
                    errors.push(unknown(&mut fields::CONDITION_VARIABLES.iter().copied()));
                }
                Location::Elements => errors.push(unknown(&mut std::iter::empty())),
                Location::Nodes if !nodal().any(|other| other == name) => errors.push(unknown(&mut nodal())),
                _ => {}
            }
        }
        if requirements.initial_positions {
            columns.displacement = true;
        }
        if requirements.energies {
            columns = columns.or(fields::ENERGY);
        }
        if requirements.record {
            columns = columns.or(fields::RECORD);
        }
        errors.or(columns)
    }

    /// Finds the cells of points and material-point conditions; they keep them for ever where
    /// functions are evaluated at their first positions.
    ///
    /// # Errors
    /// All points, or a condition, have left the grid.
    pub fn search(&mut self, points: &mut MaterialPoints) -> Result<(), Error> {
        let Some(locator) = self.locator.as_ref().filter(|_| self.settings.discretisation.frame == Frame::Updated)
        else {
            return Ok(());
        };
        let before = (points.losses.count, points.losses.mass);
        search(points, locator, &self.space, self.settings.lost_points)?;
        if points.losses.count > before.0 && self.told_losses < TOLD {
            self.told_losses += 1;
            let last = if self.told_losses == TOLD { "; any more are counted at the end" } else { "" };
            tracing::warn!("{} and were erased{last}", points.losses.since(before));
        }
        for i in 0..points.conditions.len() {
            if let Some(carrier) = points.conditions.carriers[i] {
                carriers::follow(points, &self.space, i, carrier)?;
                continue;
            }
            let conditions = &mut points.conditions;
            let x = conditions.position[i];
            match locator.locate(x, Some(conditions.cell[i])) {
                Some((cell, xi)) => {
                    (conditions.cell[i], conditions.local[i]) = (cell, self.space.local(cell as usize, x, xi));
                }
                None => {
                    let advice = "a larger grid";
                    let failure = Failure::new("a material-point condition has left the grid", advice);
                    let name = format!("material-point condition {}", conditions.ids[i]);
                    return Err(failure.at(name, x).into());
                }
            }
        }
        Ok(())
    }
}

/// Lets a solver work on the points and the grid together.
///
/// # Errors
/// Those of the work, or there are no points.
pub fn with_points<T>(
    model: &mut Model,
    work: impl FnOnce(&mut MaterialPoints, &mut ModelPart) -> Result<T, Error>,
) -> Result<T, Error> {
    let missing = || Failure::new("the solver was not initialised", "report this as a fault of Bia");
    let mut points = model.take::<MaterialPoints>().ok_or_else(missing)?;
    let result = match model.part_mut(GRID) {
        Some(grid) => work(&mut points, grid),
        None => Err(missing().into()),
    };
    model.put(points);
    result
}

/// Gives points and conditions the local coordinates of the grid's functions, given those in the mesh's cells.
fn localise(points: &mut MaterialPoints, space: &Space) {
    let dimension = points.dimension();
    for block in points.blocks.iter_mut().filter(|block| block.local.is_used()) {
        for point in 0..block.len() {
            let row = block.local.row(point);
            let of_mesh = std::array::from_fn(|a| row.get(a).copied().unwrap_or(0.0));
            let xi = space.local(block.cell[point] as usize, block.coordinates(point), of_mesh);
            block.local.row_mut(point).copy_from_slice(&xi[..dimension]);
        }
    }
    let conditions = &mut points.conditions;
    for i in 0..conditions.len() {
        conditions.local[i] = space.local(conditions.cell[i] as usize, conditions.position[i], conditions.local[i]);
    }
}

/// Carries material-point conditions with the grid; `least` as in
/// the field of this name of the implicit solver.
pub fn move_conditions(
    conditions: &mut PointConditions,
    space: &Space,
    dofs: &ActiveDofs,
    [increments, velocities]: [&[f64]; 2],
    least: Option<f64>,
) {
    let block = dofs.block();
    let mut functions = Vec::new();
    for i in 0..conditions.len() {
        let cell = conditions.cell[i] as usize;
        space.evaluate(cell, conditions.local[i], &mut functions);
        conditions.velocity[i] = [0.0; 3];
        for (&node, &n) in space.nodes_of(cell).iter().zip(&functions) {
            let Some(number) = dofs.number(node).filter(|_| least.is_none_or(|least| n > least)) else { continue };
            for a in 0..block {
                conditions.position[i][a] += n * increments[number * block + a];
                conditions.displacement[i][a] += n * increments[number * block + a];
                if let Some(velocity) = velocities.get(number * block + a) {
                    conditions.velocity[i][a] += n * velocity;
                }
            }
        }
    }
}

/// The points of a model, if they were made.
pub fn points_of(model: &Model) -> Option<&MaterialPoints> {
    model.extension::<MaterialPoints>()
}
