//! Linear momentum and energy in the collision of two discs (Sulsky, Chen & Schreyer 1994).

use super::common::{Body, Cell, Mesh, Record, Scene, material};
use super::{CUBIC, Frame, Functions, HATS, NEO_HOOKEAN, SPLINE, explicit, initial_velocity};
use serde_json::{Value, json};

const RADIUS: f64 = 0.2;
const SPEED: f64 = 0.1;
/// When the undeformed discs touch: the gap over the closing speed.
const CONTACT: f64 = 1.585_786_437_626_904_9;

/// A disc whose cells follow the circle.
fn disc(center: f64) -> Mesh {
    Mesh::block(Cell::Quadrilateral, [8, 8, 0], [-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]).map(|[u, v, _]| {
        let round = |along: f64, across: f64| center + RADIUS * along * (1.0 - 0.5 * across * across).sqrt();
        [round(u, v), round(v, u), 0.0]
    })
}

/// Two discs that fly at each other along the diagonal, on a grid of free sides.
fn collision(functions: Functions, solver: &Value) -> Record {
    let grid = Mesh::block(Cell::Quadrilateral, [28, 28, 0], [-0.2, -0.2, 0.0], [1.2, 1.2, 0.0]);
    let law = material(NEO_HOOKEAN, 4, 1000.0, 1000.0, 0.3);
    let solver = explicit(Frame::Updated, functions, 0.003, solver);
    let mut scene = Scene::new(grid, disc(0.2), law.clone(), solver, 2.7);
    scene.bodies.push(Body { name: "Second", mesh: disc(0.8), material: law });
    scene
        .with(initial_velocity("MPM_Material.Body", ["0.1", "0.1", "0"]))
        .with(initial_velocity("MPM_Material.Second", ["-0.1", "-0.1", "0"]))
        .run(&["--record-states", "30"])
}

#[test]
fn every_transfer_keeps_momentum_in_a_collision() {
    let transfers = [
        json!({"stress_update": "usf"}),
        json!({"stress_update": "usl"}),
        json!({"stress_update": "musl"}),
        json!({"scheme_type": "central_difference"}),
        json!({"stress_update": "musl", "flip_fraction": 0.99}),
        json!({"stress_update": "musl", "transfer": "pic"}),
        json!({"stress_update": "musl", "transfer": "apic"}),
        json!({"stress_update": "usl", "transfer": "tpic"}),
        json!({"stress_update": "musl", "transfer": "xpic"}),
    ];
    for functions in [HATS, SPLINE, CUBIC] {
        for (index, transfer) in transfers.iter().enumerate() {
            if functions.order > 1 && [0, 1, 4].contains(&index) {
                continue;
            }
            let record = collision(functions, transfer);
            let scale = record.first().mass() * SPEED;
            let most = record.states().iter().flat_map(|s| s.total("momentum")).fold(0.0, |a: f64, p| a.max(p.abs()));
            assert!(most / scale < 1e-12, "{functions:?} {transfer}: momentum {:e}", most / scale);
            let start = record.first().energy("kinetic");
            let least = record.states().iter().map(|s| s.energy("kinetic")).fold(f64::INFINITY, f64::min);
            assert!(least < 0.3 * start, "{transfer}: the discs must meet, kinetic energy {least} of {start}");
        }
    }
}

/// K = π R² ρ v² each, elastic: FLIP keeps the energy, and the discs feel each other through the grid
/// about a cell before they touch.
#[test]
fn flip_keeps_the_energy_of_a_collision() {
    let record = collision(HATS, &json!({"stress_update": "musl"}));
    let start = record.first().energy("total");
    let area = record.first().mass() / 2000.0;
    assert!((area / (std::f64::consts::PI * RADIUS * RADIUS) - 1.0).abs() < 0.02, "{area}");
    assert!((start / (2.0 * area * 1000.0 * SPEED * SPEED) - 1.0).abs() < 1e-12, "{start}");
    let cell = 0.05 * 2f64.sqrt() / (2.0 * SPEED * 2f64.sqrt());
    for state in record.states() {
        let drift = (state.energy("total") / start - 1.0).abs();
        assert!(drift < 0.005, "energy drifts by {drift} at {}", state.time());
        if state.time() < CONTACT - 2.0 * cell {
            assert!((state.energy("kinetic") / start - 1.0).abs() < 1e-12, "contact too early, {}", state.time());
        }
    }
    // They part again with most of the energy as motion.
    assert!(record.last().energy("kinetic") > 0.7 * start);
}
