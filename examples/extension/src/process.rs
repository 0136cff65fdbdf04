//! A process: its keys, and the hooks that it uses.

// [process]
use bia_kernel::error::{Error, Failure};
use bia_kernel::parameters::{Key, Kind, Range as Allowed};
use bia_kernel::processes::{Context, Process};
use bia_kernel::registry::ProcessEntry;
use bia_mpm::points::MaterialPoints;

/// Stops the run when a material point is faster than a limit.
struct SpeedLimit {
    limit: f64,
}

/// The process and how it is built.
pub const SPEED_LIMIT: ProcessEntry = ProcessEntry {
    name: "speed_limit_process",
    aliases: &[],
    application: Some("MyApplication"),
    keys: &[Key::required("limit", Kind::Number(Allowed::POSITIVE), "largest speed [m/s]")],
    help: "stops the run when a material point is faster than a limit",
    build: |building| Ok(Box::new(SpeedLimit { limit: building.settings.number("limit") })),
};

impl Process for SpeedLimit {
    fn name(&self) -> &str {
        "speed_limit"
    }

    fn execute_finalize_solution_step(&mut self, context: &mut Context) -> Result<(), Error> {
        let Some(points) = context.model.extension::<MaterialPoints>() else { return Ok(()) };
        for block in &points.blocks {
            for (point, id) in block.ids.iter().enumerate() {
                let speed = block.velocity.row(point).iter().map(|v| v * v).sum::<f64>().sqrt();
                if speed > self.limit {
                    let what = format!("a speed of {speed} m/s is above the limit of {} m/s", self.limit);
                    let failure = Failure::new(what, "smaller loads, or a higher limit");
                    return Err(failure.at(format!("material point {id}"), block.coordinates(point)).into());
                }
            }
        }
        Ok(())
    }
}
// [/process]
