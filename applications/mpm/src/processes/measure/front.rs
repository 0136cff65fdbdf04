//! How far a body reaches along a direction: its front, or its height at a wall.
//!
//! A quantile q is the coordinate that the share q of the mass does not reach. The mass of a point is
//! spread evenly around it: half of it counts as reached at the point, and between points the share is
//! linear. 1 is the outermost point.

use crate::points::MaterialPoints;
use crate::processes::acceleration::check_part;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::table::Heading;
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Parameters, Settings};
use bia_kernel::processes::measure::{Measurement, TABLE, TableOutput};
use bia_kernel::processes::{Process, Requirements};
use bia_kernel::registry::{Building, ProcessEntry, Registry};

const KEYS: &[Key] = &Key::join::<7, 5, 12>(
    TABLE,
    [
        Key::new("model_part_name", Kind::Text, "\"MPM_Material\"", "part of points, such as MPM_Material.Body"),
        Key::new(
            "direction",
            Kind::Vector3,
            "[1.0, 0.0, 0.0]",
            "direction along which coordinates count, of any length",
        ),
        Key::new("quantiles", Kind::List, "[1.0]", "shares of the mass, each from 0 (rearmost) to 1 (foremost point)"),
        Key::new(
            "low",
            Kind::List,
            "[null, null, null]",
            "only points beyond these coordinates count [m]; null is open",
        ),
        Key::new(
            "high",
            Kind::List,
            "[null, null, null]",
            "only points below these coordinates count [m]; null is open",
        ),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "mpm_front_output_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "quantiles of the points' coordinate along a direction in time as a table: a front, or a height",
        build,
    });
}

fn build(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = building.settings.clone();
    let mut errors = InputErrors::default();
    let mut quantiles = Vec::new();
    for entry in settings.get("quantiles").map_or(Vec::new(), Parameters::entries) {
        match entry.value().as_f64().filter(|share| (0.0..=1.0).contains(share)) {
            Some(share) => quantiles.push(share),
            None => errors.push(entry.error("must be a number from 0 to 1")),
        }
    }
    let direction = settings.vector("direction");
    let size = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
    if size == 0.0 {
        errors.push(settings.error("direction", "is the zero vector, which has no direction"));
    }
    let low = settings.get("low").and_then(|list| errors.absorb(bounds(list, f64::NEG_INFINITY)));
    let high = settings.get("high").and_then(|list| errors.absorb(bounds(list, f64::INFINITY)));
    let band = errors.or([low.unwrap_or_default(), high.unwrap_or_default()])?;
    let direction = direction.map(|d| d / size);
    let front = Front { settings, quantiles, direction, band, reached: Vec::new() };
    Ok(Box::new(TableOutput::new(&building, front)?))
}

/// Three numbers, `open` where null stands.
fn bounds(list: &Parameters, open: f64) -> Result<[f64; 3], InputErrors> {
    let number = |entry: &Parameters| if entry.value().is_null() { Some(open) } else { entry.value().as_f64() };
    let numbers: Option<Vec<f64>> = list.entries().iter().map(number).collect();
    let three = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    three.ok_or_else(|| list.error("must be a list of three numbers or nulls").into())
}

struct Front {
    settings: Settings,
    quantiles: Vec<f64>,
    direction: [f64; 3],
    /// Lower and upper bounds of the coordinates of points that count, in m.
    band: [[f64; 3]; 2],
    /// (coordinate in m, mass in kg) of those points.
    reached: Vec<(f64, f64)>,
}

/// The coordinate of a quantile, among coordinates in ascending order; not a number if there are none.
fn quantile(reached: &[(f64, f64)], share: f64) -> f64 {
    let (Some(first), Some(last)) = (reached.first(), reached.last()) else { return f64::NAN };
    let total: f64 = reached.iter().map(|(_, mass)| mass).sum();
    if share >= 1.0 {
        return last.0;
    }
    let (mut sum, mut before) = (0.0, (first.0, 0.0));
    for &(coordinate, mass) in reached {
        let at = (sum + 0.5 * mass) / total;
        if at >= share {
            let width = at - before.1;
            let part = if width > 0.0 { (share - before.1) / width } else { 1.0 };
            return before.0 + part * (coordinate - before.0);
        }
        before = (coordinate, at);
        sum += mass;
    }
    last.0
}

impl Measurement for Front {
    fn name(&self) -> &'static str {
        "front"
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        check_part(model, &self.settings)
    }

    fn require(&self, _: &mut Requirements) {}

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn headings(&mut self, _: &Model) -> Vec<Heading> {
        self.quantiles.iter().map(|share| Heading::new(format!("QUANTILE_{share:?}"), "m")).collect()
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        let Some(points) = model.extension::<MaterialPoints>() else { return };
        let Some(selection) = points.select(self.settings.text("model_part_name")) else { return };
        self.reached.clear();
        let [low, high] = self.band;
        for block in points.blocks.iter().filter(|block| selection.holds(block.body)) {
            for point in block.in_order_of_id() {
                let x = block.coordinates(point as usize);
                if (0..3).all(|a| x[a] >= low[a] && x[a] <= high[a]) {
                    let coordinate = x.iter().zip(self.direction).map(|(x, d)| x * d).sum();
                    self.reached.push((coordinate, block.mass.row(point as usize)[0]));
                }
            }
        }
        // Stable, so that points at one place add up in the order of their ids.
        self.reached.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows.extend(self.quantiles.iter().map(|share| quantile(&self.reached, *share)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n equal masses in the middle of equal parts of [0, 1]: quantiles are those of the interval.
    #[test]
    fn quantiles_of_an_even_layout_are_those_of_its_interval() {
        let even: Vec<(f64, f64)> = (0..10).map(|i| ((f64::from(i) + 0.5) / 10.0, 3.0)).collect();
        for share in [0.05, 0.1, 0.33, 0.5, 0.778, 0.95] {
            assert!((quantile(&even, share) - share).abs() < 1e-15, "{share}");
        }
        assert_eq!((quantile(&even, 0.0), quantile(&even, 1.0)), (0.05, 0.95));
        assert_eq!(quantile(&even, 0.999), 0.95, "beyond the last point nothing is known");
    }

    #[test]
    fn masses_weigh_and_empty_bands_have_no_quantile() {
        // Half of the mass of each is reached at the point: 1/8 at 0 and 5/8 at 1.
        let two = [(0.0, 1.0), (1.0, 3.0)];
        assert!((quantile(&two, 0.375) - 0.5).abs() < 1e-15);
        assert_eq!(quantile(&[(2.0, 1.0)], 0.3), 2.0);
        assert!(quantile(&[], 0.5).is_nan());
    }
}
