//! Where a step starts: the increments of displacement, imposed ones among them.

use super::Implicit;
use crate::settings::{Frame, Regime};
use crate::variables::DISPLACEMENT;
use bia_kernel::model::ModelPart;
use bia_kernel::solving::NodalFrames;

impl Implicit {
    /// Sets the unknowns at the start of the step and the grid's DISPLACEMENT with them.
    ///
    /// Imposed displacements are increments of the step (spec 03 §3), of which a piece of a step has its
    /// share.
    pub(super) fn predict_increments(&mut self, grid: &mut ModelPart, share: f64) {
        let count = grid.nodes.len();
        let fixed = grid.node_fields.fixed(&DISPLACEMENT).map_or(Vec::new(), <[_]>::to_vec);
        let values = grid.node_fields.vector_mut(&DISPLACEMENT, count);
        let ignored = self.faults().ignores_imposed(self.scene.settings.regime);
        if self.scene.settings.regime != Regime::Static {
            for (node, value) in values.iter_mut().enumerate() {
                for a in 0..3 {
                    let held = fixed.get(node).is_some_and(|fixed| fixed[a]);
                    self.scene.was_worked_on |= held && value[a] != 0.0;
                    let kratos = if held { self.previous[node][a] } else { 0.0 };
                    if held && value[a] != kratos && !ignored && !self.told.imposed {
                        self.told.imposed = true;
                        tracing::info!(
                            "imposed displacements change in time and act; Kratos 10.4.4 keeps those of the start \
                             (--kratos-exact does, too)"
                        );
                    }
                    if !held || ignored {
                        value[a] = kratos;
                    }
                }
            }
        }
        if share < 1.0 && !ignored {
            for (value, held) in values.iter_mut().zip(&fixed) {
                (0..3).filter(|a| held[*a]).for_each(|a| value[a] *= share);
            }
        }
        let block = self.dofs.block();
        self.increments.clear();
        self.increments.resize(self.dofs.order(), 0.0);
        let space = &self.scene.space;
        let (fixed, values) = (space.held(&fixed), space.at_anchors(values));
        // In statics that is what nodes moved by in the last step. Those at the edge of a body that has moved
        // on may turn it inside out.
        let is_reset = self.scene.settings.discretisation.frame == Frame::Updated;
        let starts_from_last = self.scene.options.kratos_exact || self.mixed.is_none() || !is_reset;
        for number in 0..self.dofs.nodes().len() {
            let function = self.dofs.nodes()[number] as usize;
            for a in 0..block {
                let held = fixed.get(function).is_some_and(|fixed| fixed[a]);
                self.dofs.fixed_mut()[number * block + a] = held;
                // The nodes know too little of the last step's functions of higher order to start from it.
                if held || (space.is_mesh() && starts_from_last) {
                    self.increments[number * block + a] = values[function][a];
                }
            }
        }
        self.frames = NodalFrames::new(block, &self.dofs, grid.node_fields.slides(&DISPLACEMENT));
        self.frames.slide(&mut self.increments);
    }
}
