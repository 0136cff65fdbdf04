//! The mixed displacement-pressure formulation: nearly and fully incompressible solids and fluids
//! (spec 06; Iaconeta et al. 2019; Moreno, Contri and Larese 2022).
//!
//! Nodes have displacement increments and the mean stress p. What concerns displacements alone, mass,
//! motion, loads, kinematics, is that of the displacement formulation; here stand the rows of pressure
//! and what keeps pressures from oscillating.

mod constants;
mod element;
mod gather;
mod kratos;
mod osgs;
mod problem;
mod projected;
mod subscales;

use super::Implicit;
use super::problem::Problem;
use crate::points::MaterialPoints;
use crate::settings::{MixedSettings, Regime, Stabilization, Variant};
use crate::variables::{DISPLACEMENT, PRESSURE, PRESSURE_REACTION};
use bia_constitutive::Shear;
use bia_kernel::error::Error;
use bia_kernel::linalg::LinearSolver;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::{ActiveDofs, Field, Newton, NodalFrames, NonlinearSystem, Reference, StepReport, System};
use constants::Constants;
use element::Terms;
use gather::PressureSums;
use osgs::Projection;
pub use problem::MixedProblem;

/// Evaluates an expression with a plane or solid cell as a [`MeshCell`] of `D` dimensions, `N` nodes and
/// `DOFS` unknowns a node: `with_cell!(space, cell, |basis, D, N, DOFS| expression, else other)`.
///
/// [`MeshCell`]: bia_kernel::geometry::MeshCell
macro_rules! with_cell {
    ($space:expr, $cell:expr, |$basis:ident, $D:ident, $N:ident, $DOFS:ident| $body:expr, else $other:expr) => {
        $crate::implicit::mixed::with_cell!(@ $space, $cell, |$basis, $D, $N, $DOFS| $body, else $other,
            Triangle3 2 3 3, Quadrilateral4 2 4 3, Tetrahedron4 3 4 4, Hexahedron8 3 8 4)
    };
    (@ $space:expr, $cell:expr, |$basis:ident, $D:ident, $N:ident, $DOFS:ident| $body:expr, else $other:expr,
        $($name:ident $dimension:literal $nodes:literal $dofs:literal),*) => {
        match $space.shape($cell) {
            $(Some(bia_kernel::geometry::Shape::$name) => {
                const $D: usize = $dimension;
                const $N: usize = $nodes;
                const $DOFS: usize = $dofs;
                let $basis =
                    bia_kernel::geometry::MeshCell::<bia_kernel::geometry::$name, $D, $N>::new($space.corners($cell));
                $body
            })*
            _ => $other,
        }
    };
}
use with_cell;

/// The unknowns, and the pressures among them.
#[derive(Debug, Clone, Default)]
pub struct Unknowns {
    /// Displacement increments and pressure, node by node.
    pub values: Vec<f64>,
    /// Pressures by number of the node.
    pub pressures: Vec<f64>,
}

impl Unknowns {
    /// Interleaves increments, `block` a node, with pressures.
    fn join(&mut self, block: usize, increments: &[f64], pressures: &[f64]) {
        self.pressures.clear();
        self.pressures.extend_from_slice(pressures);
        self.values.clear();
        for (increments, pressure) in increments.chunks_exact(block).zip(pressures) {
            self.values.extend_from_slice(increments);
            self.values.push(*pressure);
        }
    }

    /// Writes the unknowns apart.
    fn split(&mut self, block: usize, increments: &mut [f64]) {
        let nodes = increments.chunks_exact_mut(block).zip(&mut self.pressures);
        for (values, (increments, pressure)) in self.values.chunks_exact(block + 1).zip(nodes) {
            increments.copy_from_slice(&values[..block]);
            *pressure = values[block];
        }
    }
}

/// What the formulation keeps from step to step.
pub struct Mixed {
    settings: MixedSettings,
    variant: Variant,
    /// Dofs of displacement, then pressure, node by node.
    pub dofs: ActiveDofs,
    sums: PressureSums,
    couplings: Option<System>,
    unknowns: Unknowns,
    shows_reaction: bool,
    starts: bool,
}

impl Mixed {
    /// The formulation with these settings.
    pub fn new(settings: MixedSettings, kratos_exact: bool) -> Self {
        Self {
            variant: settings.variant(kratos_exact),
            settings,
            dofs: ActiveDofs::default(),
            sums: PressureSums::default(),
            couplings: None,
            unknowns: Unknowns::default(),
            shows_reaction: false,
            starts: !kratos_exact,
        }
    }

    /// PRESSURE_REACTION is wanted.
    pub fn show_reaction(&mut self, wanted: bool) {
        self.shows_reaction = wanted;
    }

    /// The first step is at hand, and is one of the backward Euler method. What pressures make of the
    /// acceleration is not known before; Newmark's scheme would carry the error of a guess along for ever.
    pub fn starts(&self) -> bool {
        self.starts
    }

    /// Says that the first step is done.
    pub fn has_started(&mut self) {
        self.starts = false;
    }

    /// Pressures at the end of the last step, by number of the node.
    pub fn pressures(&self) -> &[f64] {
        &self.unknowns.pressures
    }

    /// Whether the tangent is symmetric where those of all laws are.
    pub fn is_symmetric(&self) -> bool {
        let projects = matches!(self.settings.stabilization, Stabilization::None | Stabilization::Ppp);
        projects && self.settings.volumetric == Default::default()
    }

    /// Stabilisation in terms of an element.
    fn terms(&self) -> Terms {
        match (self.settings.stabilization, self.variant) {
            (Stabilization::None, _) => Terms::Galerkin,
            (Stabilization::Ppp, Variant::Consistent) => Terms::Projected,
            (Stabilization::Ppp, Variant::Kratos) => Terms::KratosProjected,
            (Stabilization::Asgs, Variant::Kratos) => Terms::KratosSubscales,
            (Stabilization::Asgs | Stabilization::Osgs, _) => Terms::Subscales,
        }
    }

    /// Numbers the dofs of `cells` and makes the system that couples them.
    pub fn number(&mut self, space: &crate::space::Space, cells: &[u32], dimension: usize) -> System {
        self.dofs = space.active_dofs(cells, dimension + 1);
        let system = super::system(space, cells, &self.dofs);
        if self.settings.stabilization != Stabilization::Osgs {
            return system;
        }
        // A projection reaches from each node to its neighbours.
        let pattern = system.matrix.pattern.clone();
        let starts = pattern.row_start();
        let around = starts.windows(2).map(|row| &pattern.columns()[row[0] as usize..row[1] as usize]);
        let wide = system.widened(around);
        self.couplings = Some(system);
        wide
    }

    /// Residuals of pressure are volumes and do not compare with forces; Kratos compares them.
    fn fields(&self, dimension: usize) -> Vec<Field> {
        match self.variant {
            Variant::Kratos => Vec::new(),
            Variant::Consistent => vec![
                Field { components: 0..dimension, reference: Reference::First },
                Field { components: dimension..dimension + 1, reference: Reference::Largest(self.sums.scale()) },
            ],
        }
    }

    /// The step in the unknowns of `base` and the present pressures.
    pub fn problem<'a>(&'a mut self, base: Problem<'a>) -> MixedProblem<'a> {
        let of_block = |block: &crate::points::Block| {
            let moduli = block.law.mixed()?;
            Some(Constants::new(block, moduli, &self.settings, self.variant, base.inertia, base.time_step))
        };
        let constants = base.points.blocks.iter().filter_map(of_block).collect();
        MixedProblem {
            constants,
            terms: self.terms(),
            size: self.settings.size,
            fields: self.fields(base.dofs.block()),
            unknowns: std::mem::take(&mut self.unknowns),
            projection: Projection::default(),
            couplings: self.couplings.as_mut(),
            dofs: &self.dofs,
            base,
        }
    }
}

impl Implicit {
    /// Start values of the pressures, and which dofs are held.
    ///
    /// A held pressure keeps what stands on its node. The others start from those of the points, but in
    /// statics from the last solution.
    pub(super) fn predict_pressures(&mut self, points: &MaterialPoints, grid: &mut ModelPart) {
        let Some(mixed) = &mut self.mixed else { return };
        let space = &self.scene.space;
        mixed.sums.gather(&points.blocks, &self.active, space, &self.dofs);
        let count = grid.nodes.len();
        let held = grid.node_fields.fixed(&PRESSURE).map_or(Vec::new(), <[_]>::to_vec);
        let column = grid.node_fields.scalar_mut(&PRESSURE, count);
        let is_held = |node: usize| held.get(node).is_some_and(|held| held[0]);
        let keeps = self.scene.settings.regime == Regime::Static;
        if !keeps {
            (0..count).filter(|&node| !is_held(node)).for_each(|node| column[node] = 0.0);
        }
        let block = self.dofs.block();
        let mut pressures = Vec::with_capacity(self.dofs.nodes().len());
        for (number, &node) in self.dofs.nodes().iter().enumerate() {
            let node = node as usize;
            let stays = is_held(node) || keeps;
            pressures.push(if stays { column[node] } else { mixed.sums.pressure(number) });
            let fixed = &mut mixed.dofs.fixed_mut()[number * (block + 1)..][..=block];
            fixed[..block].copy_from_slice(&self.dofs.fixed()[number * block..][..block]);
            fixed[block] = is_held(node);
        }
        mixed.unknowns.join(block, &self.increments, &pressures);
    }

    /// Solves the step for displacements and pressures.
    pub(super) fn solve_mixed(
        &mut self,
        mixed: &mut Mixed,
        (points, grid): (&MaterialPoints, &ModelPart),
        time_step: f64,
        system: &mut System,
        linear: &mut dyn LinearSolver,
    ) -> Result<StepReport, Error> {
        let newton: &Newton = &self.scene.settings.newton;
        let slides = grid.node_fields.slides(&DISPLACEMENT);
        let frames = NodalFrames::new(self.dofs.block(), &mixed.dofs, slides);
        let mut problem = mixed.problem(self.problem(points, grid, time_step));
        let report = frames.solve(newton, &mut problem, system, linear);
        let MixedProblem { base, unknowns, .. } = problem;
        let (increments, assembled) = (base.increments, base.assembled);
        mixed.unknowns = unknowns;
        (self.increments, self.assembled) = (increments, assembled);
        report
    }

    /// Writes the pressures to the grid.
    pub(super) fn write_pressures(&self, grid: &mut ModelPart) {
        let Some(mixed) = &self.mixed else { return };
        let count = grid.nodes.len();
        let column = grid.node_fields.scalar_mut(&PRESSURE, count);
        for (&node, pressure) in self.dofs.nodes().iter().zip(mixed.pressures()) {
            column[node as usize] = *pressure;
        }
    }

    /// Minus the residuals of displacement at the solution; writes those that hold pressures.
    pub(super) fn mixed_reactions(
        &mut self,
        mixed: &mut Mixed,
        points: &MaterialPoints,
        grid: &mut ModelPart,
        time_step: f64,
        system: &mut System,
    ) -> Result<Vec<f64>, Error> {
        let mut problem = mixed.problem(self.problem(points, grid, time_step));
        let assembled = problem.assemble(system, false);
        let unknowns = problem.unknowns;
        mixed.unknowns = unknowns;
        assembled?;
        let block = self.dofs.block();
        let residuals = system.rhs.chunks_exact(block + 1);
        if mixed.shows_reaction {
            let count = grid.nodes.len();
            let column = grid.node_fields.scalar_mut(&PRESSURE_REACTION, count);
            column.fill(0.0);
            let held = mixed.dofs.fixed().chunks_exact(block + 1).map(|fixed| fixed[block]);
            for ((&node, residuals), _) in
                self.dofs.nodes().iter().zip(residuals.clone()).zip(held).filter(|(_, held)| *held)
            {
                column[node as usize] = -residuals[block];
            }
        }
        Ok(residuals.flat_map(|node| &node[..block]).map(|r| -r).collect())
    }
}

/// Lets the volume of fluids follow their pressure: J becomes J(p), without memory of shape.
///
/// The constraint sees averages over nodes only, so that J of single points drifts apart; a solid resists
/// that by its shear stiffness, a fluid does not, and after a change of cells the new averages would ask
/// for a divergence of (J − 1)/Δt (spec 06 §6).
pub fn relax_fluids(points: &mut MaterialPoints) {
    for block in &mut points.blocks {
        let Some(moduli) = block.law.mixed().filter(|moduli| matches!(moduli.shear, Shear::Viscous(_))) else {
            continue;
        };
        let dimension = block.kinematics.dimension();
        for point in 0..block.len() {
            let jacobian = moduli.volumetric.jacobian(moduli.compressibility * block.pressure.row(point)[0]);
            let stretch = jacobian.powf(1.0 / dimension as f64);
            let mut gradient = nalgebra::Matrix3::identity();
            (0..dimension).for_each(|a| gradient[(a, a)] = stretch);
            crate::points::compress(&gradient, block.gradient.row_mut(point));
            if block.volume.is_used() {
                let reference = block.mass.row(point)[0] / block.density;
                block.volume.set(point, [reference * jacobian]);
            }
        }
    }
}
