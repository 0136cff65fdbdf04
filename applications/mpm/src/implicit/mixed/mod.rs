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
mod spreading;
mod step;
mod subscales;
#[cfg(test)]
mod tests;
mod volume;

use super::problem::Problem;
use crate::points::{Block, MaterialPoints};
use crate::settings::{MixedSettings, Regime, SolverSettings, Stabilization, Variant};
use crate::space::Space;
use bia_constitutive::Shear;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::solving::{ActiveDofs, Field, Reference, System};
use constants::Constants;
use element::Terms;
use gather::PressureSums;
use osgs::Projection;
pub use problem::MixedProblem;
pub use step::relax_fluids;
pub use volume::stray_volume;

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
    /// Room of each of the grid's nodes; empty until it is asked for.
    room: Vec<f64>,
    /// Displacements that take points apart where they are too many.
    spread: Vec<f64>,
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
            room: Vec::new(),
            spread: Vec::new(),
            shows_reaction: false,
            starts: !kratos_exact,
        }
    }

    /// PRESSURE_REACTION is wanted.
    pub fn show_reaction(&mut self, wanted: bool) {
        self.shows_reaction = wanted;
    }

    /// The first step is at hand, and is one of the backward Euler method: what pressures make of the
    /// acceleration is not known before.
    pub fn starts(&self) -> bool {
        self.starts
    }

    /// Says that a step is done.
    pub fn has_stepped(&mut self) {
        self.starts = false;
    }

    /// Saves or loads whether the first step is still to come; start values come from points and nodes.
    ///
    /// # Errors
    /// The checkpoint does not hold it.
    pub fn exchange(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.flag("the first step is to come", &mut self.starts)
    }

    /// Pressures at the end of the last step, by number of the node.
    pub fn pressures(&self) -> &[f64] {
        &self.unknowns.pressures
    }

    /// Displacements by which points are moved apart beside the motion of the step; empty for none.
    pub fn spread(&self) -> &[f64] {
        &self.spread
    }

    /// Warns, once, of solids in dynamics whose weight ASGS balances with pressure, also where they fall.
    pub fn tell_weight(&self, points: &MaterialPoints, told: &mut bool) {
        let is_solid = |block: &Block| block.law.mixed().is_some_and(|m| matches!(m.shear, Shear::Elastic(_)));
        let is_heavy = |block: &Block| block.gravity != [0.0; 3] || block.body_acceleration.is_used();
        let leaves_inertia = self.settings.stabilization == Stabilization::Asgs && self.settings.inertia.is_none();
        if !*told && leaves_inertia && points.blocks.iter().any(|block| is_solid(block) && is_heavy(block)) {
            *told = true;
            tracing::warn!(
                "asgs takes the weight of a solid as borne by its stress: one that falls has pressures of the order \
                 of its density x gravity x height; \"stabilization\": \"osgs\" or \"stabilization_parameters\": \
                 {{\"inertia\": true}} has not"
            );
        }
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
    pub fn number(&mut self, space: &Space, cells: &[u32], dimension: usize) -> System {
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
        let of_block = |block: &Block| {
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

/// A fluid without viscosity has pressures that nothing but its inertia can stabilise.
///
/// # Errors
/// There is one, and the stabilisation does not take inertia.
pub fn check_fluids(points: &MaterialPoints, settings: &SolverSettings) -> Result<(), InputErrors> {
    let Some(mixed) = settings.mixed.filter(|mixed| mixed.stabilization != Stabilization::None) else {
        return Ok(());
    };
    let inviscid = |block: &Block| block.law.mixed().is_some_and(|moduli| moduli.shear == Shear::Viscous(0.0));
    let takes_inertia = settings.regime == Regime::Dynamic
        && mixed.c_t.is_none_or(|c_t| c_t > 0.0)
        && mixed.variant != Some(Variant::Kratos);
    if takes_inertia || !points.blocks.iter().any(inviscid) {
        return Ok(());
    }
    let message = "cannot act on a fluid whose DYNAMIC_VISCOSITY is 0";
    let help = "give it a viscosity, or in dynamics a c_t above 0 with the consistent variant";
    Err(settings.settings.error("stabilization", message).help(help).into())
}
