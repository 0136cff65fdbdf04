//! Parts of a grid on which processes act, but not on the bodies.

use super::Analysis;

impl Analysis {
    /// Parts that no body has reached, and those that bodies have come away from since the first step.
    pub(super) fn unreached(&self) -> Vec<String> {
        let Some(reached) = self.solver.reached(&self.model) else { return Vec::new() };
        let mut told: Vec<String> = Vec::new();
        for (_, group) in self.project.child("processes").map_or(Vec::new(), |processes| processes.members()) {
            let parts =
                group.entries().into_iter().filter_map(|block| block.child("Parameters")?.child("model_part_name"));
            for part in parts {
                let path = part.value().as_str().unwrap_or_default();
                let members = self.model.members(path);
                let Some(nodes) =
                    members.filter(|of| of.root == reached.root && path != reached.root).map(|of| of.nodes)
                else {
                    continue;
                };
                let any = |flags: &[bool]| nodes.iter().any(|node| flags.get(*node as usize).is_some_and(|flag| *flag));
                let message = if nodes.is_empty() {
                    continue;
                } else if !any(&reached.ever) {
                    format!("no body has reached the nodes of {path} in this run: what acts there had no effect")
                } else if any(&self.reached_first) && !any(&reached.now) {
                    format!(
                        "the bodies have come away from the nodes of {path}: what held or moved them there does not now"
                    )
                } else {
                    continue;
                };
                told.push(part.warning(message).to_string());
            }
        }
        told
    }
}
