//! Cook's membrane, clamped on the left and sheared on the right: 4.8 m wide, from 4.4 to 1.6 m high, of
//! E = 250 Pa in plane strain (Cook 1974; Simo and Armero 1992; lengths a tenth of theirs).

use super::common::{Cell, Mesh, Record, Scene, fix, material, process};
use serde_json::{Value, json};

pub const YOUNG: f64 = 250.0;

/// A membrane of so many cells a side, with the material points of the figures that it is compared with.
pub struct Membrane {
    pub cell: Cell,
    pub count: usize,
    pub poisson: f64,
    /// Force per length of the right side in N/m.
    pub load: f64,
    /// Members of the solver settings.
    pub solver: Value,
}

impl Membrane {
    pub fn new(cell: Cell, count: usize, poisson: f64, load: f64) -> Self {
        Self { cell, count, poisson, load, solver: json!({}) }
    }

    /// With further members of the solver settings.
    pub fn with(mut self, solver: Value) -> Self {
        let members = self.solver.as_object_mut().unwrap();
        members.extend(solver.as_object().unwrap().clone());
        self
    }

    fn scene(&self) -> Scene {
        let n = self.count;
        let mesh = Mesh::block(self.cell, [n, n, 1], [0.0; 3], [1.0, 1.0, 0.0])
            .map(|[x, y, _]| [4.8 * x, (1.0 - y) * 4.4 * x + y * (4.4 + 1.6 * x), 0.0]);
        let points = if self.cell == Cell::Triangle { 3 } else { 16 };
        let law = "HyperElasticNeoHookeanPlaneStrainUP2DLaw";
        let mut solver = json!({"pressure_dofs": true, "residual_relative_tolerance": 1e-10});
        solver.as_object_mut().unwrap().extend(self.solver.as_object().unwrap().clone());
        let mut scene = Scene::new(mesh.clone(), mesh, material(law, points, 1.0, YOUNG, self.poisson), solver, 1.0)
            .part("Left", |x| x[0] == 0.0)
            .with(fix("Left", json!([0.0, 0.0, 0.0])));
        let right = (0..n).map(|j| vec![j * (n + 1) + n, (j + 1) * (n + 1) + n]).collect();
        scene.loads.push(("Right", "MPMGridLineLoadCondition2D2N", right));
        let load = json!({"model_part_name": "Background_Grid.Right", "variable_name": "LINE_LOAD",
                          "modulus": self.load, "direction": [0.0, 1.0, 0.0]});
        scene.with(process("assign_vector_by_direction_to_condition_process", load))
    }

    pub fn run(&self) -> Record {
        self.scene().run(&[])
    }

    pub fn run_with(&self, arguments: &[&str]) -> Record {
        self.scene().run(arguments)
    }
}

/// Displacement and pressure of the upper right corner.
pub fn corner(record: &Record) -> [f64; 3] {
    let last = record.last();
    let (u, p) = (last.nodes("DISPLACEMENT"), last.nodes("PRESSURE"));
    let node = u.len() - 1;
    [u[node][0], u[node][1], p[node][0]]
}

/// Newton iterations of the first step.
pub fn iterations(record: &Record) -> u64 {
    record.json["iterations"][0].as_u64().unwrap()
}

/// Share of the checkerboard in the nodal pressure: root mean square of its second differences over four
/// along both mesh directions and of the second differences of these, over its standard deviation.
pub fn oscillation(record: &Record) -> f64 {
    let p = record.last().nodes("PRESSURE").concat();
    let side = (p.len() as f64).sqrt().round() as usize;
    let at = |i: usize, j: usize| p[j * side + i];
    let second = |a: f64, b: f64, c: f64| 0.25 * (a - 2.0 * b + c);
    let along = |i: usize, j: usize| second(at(i - 1, j), at(i, j), at(i + 1, j));
    let inside = || (1..side - 1).flat_map(|i| (1..side - 1).map(move |j| (i, j)));
    let squares = inside().map(|(i, j)| {
        let up = second(at(i, j - 1), at(i, j), at(i, j + 1));
        let both = second(along(i, j - 1), along(i, j), along(i, j + 1));
        along(i, j).powi(2) + up.powi(2) + both.powi(2)
    });
    let mean = p.iter().sum::<f64>() / p.len() as f64;
    let variance = p.iter().map(|p| (p - mean).powi(2)).sum::<f64>() / p.len() as f64;
    (squares.sum::<f64>() / inside().count() as f64 / variance).sqrt()
}
