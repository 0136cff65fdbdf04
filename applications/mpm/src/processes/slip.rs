//! Walls of the grid along which bodies slide (spec 07 §5).
//!
//! Each node of the part is held along the mean normal of the conditions around it. Kratos knows one
//! normal a node; here every process holds its own, so that two walls with a process each hold their
//! corner.

use crate::grid::GRID;
use crate::variables::{DISPLACEMENT, NORMAL};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::model::{Model, ModelPart};
use bia_kernel::parameters::{Key, Kind, Range, Settings};
use bia_kernel::processes::{Process, Requirements};
use bia_kernel::registry::{ProcessEntry, Registry};
use bia_kernel::variables::Slide;

const KEYS: &[Key] = &[
    Key::required("model_part_name", Kind::Text, "part of grid conditions, such as Background_Grid.Slip"),
    Key::new("option", Kind::Choice(&["", "flip_normal"]), "\"\"", "flip_normal turns the NORMAL shown round"),
    Key::new("friction_coefficient", Kind::Number(Range::NOT_NEGATIVE), "0.0", "only 0: walls without friction"),
    Key::new(
        "tangential_penalty_coefficient",
        Kind::Number(Range::NOT_NEGATIVE),
        "0.0",
        "only 0, as there is no friction",
    )
    .or(&["tangential_penalty_factor"]),
    Key::new("avoid_recomputing_normals", Kind::Bool, "true", "accepted: the grid does not move, nor do its normals"),
];

/// Cosine of the largest angle between the normal of a face and the mean one at its nodes: 30 degrees, an
/// edge of 60 degrees.
const SHARPEST: f64 = 0.866;

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "apply_mpm_slip_boundary_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "holds grid nodes along the normal of a wall and lets them slide along it",
        build: |building| {
            for key in ["friction_coefficient", "tangential_penalty_coefficient"] {
                if building.settings.number(key) > 0.0 {
                    let message = "friction on walls is not there yet";
                    return Err(building.settings.error(key, message).help("0 lets bodies slide freely").into());
                }
            }
            // Kratos takes the mean of whatever normals there are.
            let any_edge = building.options.kratos_exact;
            Ok(Box::new(Slip { settings: building.settings, any_edge }))
        },
    });
}

struct Slip {
    settings: Settings,
    any_edge: bool,
}

impl Slip {
    /// Refuses edges too sharp for one normal.
    fn check_edges(
        &self,
        grid: &ModelPart,
        conditions: &[u32],
        normals: &[(u32, [f64; 3])],
    ) -> Result<(), InputErrors> {
        for &condition in conditions {
            let shape = grid.conditions.shapes[condition as usize];
            let own = shape.normal(&grid.corners(&grid.conditions, condition as usize), shape.center());
            for node in grid.conditions.nodes_of(condition as usize) {
                let Ok(at) = normals.binary_search_by_key(node, |(node, _)| *node) else { continue };
                let mean = normals[at].1;
                if dot(own, mean) < SHARPEST * (dot(own, own) * dot(mean, mean)).sqrt() {
                    let id = grid.nodes.ids[*node as usize];
                    let message = format!("the wall has an edge at node {id}, where no mean normal makes sense");
                    let help = "make a part of each face, with a slip process of its own: their corner is then held";
                    return Err(self.settings.error("model_part_name", message).help(help).into());
                }
            }
        }
        Ok(())
    }
}

impl Process for Slip {
    fn name(&self) -> &str {
        "apply_mpm_slip_boundary"
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn connect(&mut self, model: &mut Model) -> Result<(), InputErrors> {
        let path = self.settings.text("model_part_name");
        let members = model.members(path).filter(|found| found.root == GRID && !found.conditions.is_empty());
        let Some(conditions) = members.map(|members| members.conditions) else {
            let message = format!("{path:?} is no part of the grid with conditions");
            let diagnostic = self.settings.error("model_part_name", message);
            return Err(model.suggest_part(diagnostic, path).into());
        };
        let Some(grid) = model.part_mut(GRID) else { return Ok(()) };
        let normals = grid.nodal_normals(&conditions);
        if let Some((node, _)) = normals.iter().find(|(_, normal)| dot(*normal, *normal) == 0.0) {
            let message = format!("node {} of {path:?} has no normal", grid.nodes.ids[*node as usize]);
            return Err(self
                .settings
                .error("model_part_name", message)
                .help("use lines or faces as conditions")
                .into());
        }
        if !self.any_edge {
            self.check_edges(grid, &conditions, &normals)?;
        }
        let sign = if self.settings.text("option") == "flip_normal" { -1.0 } else { 1.0 };
        let count = grid.nodes.len();
        let shown = grid.node_fields.vector_mut(&NORMAL, count);
        normals.iter().for_each(|(node, normal)| shown[*node as usize] = normal.map(|n| sign * n));
        let unit = |normal: [f64; 3]| normal.map(|n| n / dot(normal, normal).sqrt());
        let slides = normals.into_iter().map(|(node, normal)| Slide { node, normal: unit(normal) });
        grid.node_fields.add_slides(&DISPLACEMENT, slides);
        Ok(())
    }

    fn require(&self, requirements: &mut Requirements) {
        // Several walls may show theirs.
        if !requirements.provided.contains(&NORMAL.name) {
            requirements.provided.push(NORMAL.name);
        }
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
