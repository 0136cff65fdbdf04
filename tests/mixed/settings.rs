//! Choices that do not go with nodal pressures are refused, all together, before anything runs; results
//! do not depend on the number of threads.

use super::common::Cell;
use super::membrane::Membrane;
use serde_json::{Value, json};

#[test]
fn results_do_not_depend_on_threads() {
    for stabilization in ["ppp", "asgs", "osgs"] {
        let settings = json!({"stabilization": stabilization, "time_stepping": {"time_step": 0.5}});
        let membrane = Membrane::new(Cell::Quadrilateral, 12, 0.5, 1.0).with(settings);
        let states: Vec<Value> =
            ["1", "2", "3"].map(|threads| membrane.run_with(&["--threads", threads]).last().json.clone()).into();
        assert!(states[0] == states[1] && states[0] == states[2], "{stabilization}");
    }
}
