//! Data that a mesh file gives to nodes, conditions and elements, put where solvers read it.

use super::{ModelPart, Value};
use crate::registry::Registry;
use crate::variables::{Fields, Rank, Variable};

impl ModelPart {
    /// Stores `NodalData` and `ConditionalData` of registered variables in the part's fields, with
    /// fixity, and returns what has no effect.
    pub fn apply_data(&mut self, registry: &Registry) -> Vec<String> {
        let mut unused = Vec::new();
        let name = self.name.clone();
        let mut unknown = |block: &str, variable: &str| {
            unused.push(format!("{block} of {variable} in {name} has no effect: no component reads it"));
        };
        let (nodes, conditions) = (self.nodes.len(), self.conditions.len());
        for (variable, rows) in std::mem::take(&mut self.nodal_data) {
            let Some(target) = Target::find(registry, &variable) else {
                unknown("NodalData", &variable);
                continue;
            };
            for (node, fixed, value) in rows {
                if !target.store(&mut self.node_fields, nodes, node as usize, &value) {
                    unknown("a value of NodalData that is no number (or vector)", &variable);
                }
                if fixed {
                    target.fix(&mut self.node_fields, nodes, node as usize);
                }
            }
        }
        for (variable, rows) in std::mem::take(&mut self.conditional_data) {
            match Target::find(registry, &variable) {
                Some(target) => {
                    for (condition, value) in &rows {
                        if !target.store(&mut self.condition_fields, conditions, *condition as usize, value) {
                            unknown("a value of ConditionalData that is no number (or vector)", &variable);
                        }
                    }
                }
                None => unknown("ConditionalData", &variable),
            }
        }
        for variable in std::mem::take(&mut self.elemental_data).keys() {
            unknown("ElementalData", variable);
        }
        unused
    }
}

/// A variable, or one component of a vector.
struct Target {
    variable: Variable,
    component: Option<usize>,
}

impl Target {
    fn find(registry: &Registry, name: &str) -> Option<Self> {
        if let Some(variable) = registry.find_variable(name) {
            return Some(Self { variable, component: None });
        }
        let component = ["_X", "_Y", "_Z"].iter().position(|suffix| name.ends_with(suffix))?;
        let variable = registry.find_variable(&name[..name.len() - 2])?;
        (variable.rank == Rank::Vector).then_some(Self { variable, component: Some(component) })
    }

    /// False for a value that does not fit the variable.
    fn store(&self, fields: &mut Fields, count: usize, index: usize, value: &Value) -> bool {
        match (self.variable.rank, self.component, value) {
            (Rank::Vector, Some(component), Value::Number(number)) => {
                fields.vector_mut(&self.variable, count)[index][component] = *number;
            }
            (Rank::Vector, None, Value::Vector(numbers)) => {
                let row = &mut fields.vector_mut(&self.variable, count)[index];
                row.iter_mut().zip(numbers).for_each(|(entry, number)| *entry = *number);
            }
            (Rank::Scalar, _, Value::Number(number)) => fields.scalar_mut(&self.variable, count)[index] = *number,
            _ => return false,
        }
        true
    }

    fn fix(&self, fields: &mut Fields, count: usize, index: usize) {
        let fixed = &mut fields.fixed_mut(&self.variable, count)[index];
        match self.component {
            Some(component) => fixed[component] = true,
            None => *fixed = [true; 3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn data_of_known_variables_is_stored_and_the_rest_is_told() {
        const MOVED: Variable = Variable::vector("MOVED", "m", "");
        const HEAT: Variable = Variable::scalar("HEAT", "J", "");
        let mut registry = Registry::default();
        registry.variable(MOVED);
        registry.variable(HEAT);
        let mut part = ModelPart::new("Grid");
        part.nodes.ids = vec![1, 2];
        part.nodes.coordinates = vec![[0.0; 3]; 2];
        part.nodal_data.insert("MOVED_Y".into(), vec![(1, true, Value::Number(2.5))]);
        part.nodal_data.insert("HEAT".into(), vec![(0, false, Value::Number(7.0))]);
        part.nodal_data.insert("STRANGE".into(), vec![(0, false, Value::Number(1.0))]);
        let unused = part.apply_data(&registry);
        assert_eq!(unused.len(), 1);
        assert!(unused[0].contains("STRANGE"), "{}", unused[0]);
        assert_eq!(part.node_fields.vector(&MOVED), Some(&[[0.0; 3], [0.0, 2.5, 0.0]][..]));
        assert_eq!(part.node_fields.fixed(&MOVED).unwrap()[1], [false, true, false]);
        assert_eq!(part.node_fields.scalar(&HEAT), Some(&[7.0, 0.0][..]));
    }
}
