//! Sums over material points: mass, volume, centre of mass, momentum, angular momentum, overfill.

use super::overfill::Blocks;
use crate::grid::GRID;
use crate::points::{Block, MaterialPoints};
use crate::processes::acceleration::check_part;
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::checkpoint::{Archive, CheckpointError};
use bia_kernel::io::table::Heading;
use bia_kernel::model::Model;
use bia_kernel::parameters::{Key, Kind, Parameters, Settings};
use bia_kernel::processes::measure::{Measurement, TABLE, TableOutput};
use bia_kernel::processes::{Location, Process, Requirements, Wanted};
use bia_kernel::registry::{Building, ProcessEntry, Registry};

const KEYS: &[Key] = &Key::join::<7, 4, 11>(
    TABLE,
    [
        Key::new("model_part_name", Kind::Text, "\"MPM_Material\"", "part of points, such as MPM_Material.Body"),
        Key::new(
            "quantities",
            Kind::Texts,
            "[\"mass\", \"volume\", \"center_of_mass\", \"linear_momentum\", \"angular_momentum\"]",
            "which of these, or overfill, are measured",
        ),
        Key::new("center", Kind::Vector3, "[0.0, 0.0, 0.0]", "place about which the angular momentum is taken [m]"),
        Key::optional(
            "overfill_block",
            Kind::Vector3,
            "overfill: edges of the blocks of whole cells in which points may be too many, such as two cells [m]",
        ),
    ],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "mpm_totals_output_process",
        aliases: &[],
        application: Some("MPMApplication"),
        keys: KEYS,
        help: "sums over material points in time as a table",
        build,
    });
}

/// What is summed up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Total {
    Mass,
    Volume,
    CenterOfMass,
    LinearMomentum,
    AngularMomentum,
    Overfill,
}

impl Total {
    const ALL: [(&'static str, Total); 6] = [
        ("mass", Total::Mass),
        ("volume", Total::Volume),
        ("center_of_mass", Total::CenterOfMass),
        ("linear_momentum", Total::LinearMomentum),
        ("angular_momentum", Total::AngularMomentum),
        ("overfill", Total::Overfill),
    ];

    /// The variable of points that is needed.
    fn variable(self) -> Option<&'static str> {
        match self {
            Total::Volume | Total::Overfill => Some("MP_VOLUME"),
            Total::LinearMomentum | Total::AngularMomentum => Some("MP_VELOCITY"),
            Total::Mass | Total::CenterOfMass => None,
        }
    }

    fn headings(self) -> Vec<Heading> {
        let vector = |name: &str, unit: &str| ["X", "Y", "Z"].map(|axis| Heading::new(format!("{name}_{axis}"), unit));
        match self {
            Total::Mass => vec![Heading::new("MASS", "kg")],
            Total::Volume => vec![Heading::new("VOLUME", "m³")],
            Total::CenterOfMass => vector("CENTER_OF_MASS", "m").into(),
            Total::LinearMomentum => vector("LINEAR_MOMENTUM", "kg m/s").into(),
            Total::AngularMomentum => vector("ANGULAR_MOMENTUM", "kg m²/s").into(),
            Total::Overfill => vec![Heading::new("OVERFILL", "1")],
        }
    }
}

fn build(building: Building) -> Result<Box<dyn Process>, InputErrors> {
    let settings = building.settings.clone();
    let mut errors = InputErrors::default();
    let mut wanted = Vec::new();
    for entry in settings.get("quantities").map_or(Vec::new(), Parameters::entries) {
        let name = entry.value().as_str().unwrap_or_default();
        match Total::ALL.iter().find(|(known, _)| *known == name) {
            Some((_, total)) => wanted.push(*total),
            None => {
                let diagnostic = entry.error(format!("{name:?} is no sum over points"));
                errors.push(diagnostic.allowed(name, Total::ALL.iter().map(|(known, _)| *known)));
            }
        }
    }
    if wanted.contains(&Total::Overfill) && settings.get("overfill_block").is_none() {
        errors.push(settings.parameters().error("\"overfill\" needs \"overfill_block\""));
    }
    errors.or(())?;
    Ok(Box::new(TableOutput::new(&building, Totals { settings, wanted, blocks: None })?))
}

struct Totals {
    settings: Settings,
    wanted: Vec<Total>,
    blocks: Option<Blocks>,
}

/// The sums so far.
#[derive(Default)]
struct Sums {
    mass: f64,
    volume: f64,
    moment: [f64; 3],
    momentum: [f64; 3],
    angular: [f64; 3],
}

impl Sums {
    fn add(&mut self, block: &Block, point: usize, center: [f64; 3]) {
        let (mass, x) = (block.mass.row(point)[0], block.coordinates(point));
        self.mass += mass;
        self.volume += block.volume.row(point).first().copied().unwrap_or(0.0);
        let (velocity, angular) = (block.velocity.row(point), block.angular_momentum(point, center));
        for a in 0..3 {
            self.moment[a] += mass * x[a];
            self.momentum[a] += mass * velocity.get(a).copied().unwrap_or(0.0);
            self.angular[a] += angular[a];
        }
    }
}

impl Measurement for Totals {
    fn name(&self) -> &'static str {
        "totals"
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        check_part(model, &self.settings)?;
        let (true, Some(grid)) = (self.wanted.contains(&Total::Overfill), model.part(GRID)) else { return Ok(()) };
        let dimension = grid.elements.shapes.iter().map(|shape| shape.dimension()).max().unwrap_or(0);
        let size = self.settings.vector("overfill_block");
        if size[..dimension].iter().any(|edge| *edge <= 0.0) {
            return Err(self.settings.error("overfill_block", "has an edge that is not above 0").into());
        }
        let cut = |cell: u32| {
            let message = format!("the blocks do not consist of whole cells: element {cell} lies in several");
            self.settings.error("overfill_block", message).help("blocks begin at the lowest corner of the grid")
        };
        self.blocks = Some(Blocks::new(grid, size, dimension).map_err(cut)?);
        Ok(())
    }

    fn require(&self, requirements: &mut Requirements) {
        for variable in self.wanted.iter().filter_map(|total| total.variable()) {
            let place = self.settings.parameters().clone();
            requirements.variables.push(Wanted { location: Location::Points, variable: variable.into(), place });
        }
    }

    fn exchange_state(&mut self, _: &mut Archive) -> Result<(), CheckpointError> {
        Ok(())
    }

    fn headings(&mut self, _: &Model) -> Vec<Heading> {
        self.wanted.iter().flat_map(|total| total.headings()).collect()
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        let Some(points) = model.extension::<MaterialPoints>() else { return };
        let Some(selection) = points.select(self.settings.text("model_part_name")) else { return };
        let (mut sums, center) = (Sums::default(), self.settings.vector("center"));
        if let Some(blocks) = &mut self.blocks {
            blocks.clear();
        }
        for block in points.blocks.iter().filter(|block| selection.holds(block.body)) {
            for point in block.in_order_of_id().into_iter().map(|point| point as usize) {
                sums.add(block, point, center);
                if let (Some(blocks), &[volume]) = (&mut self.blocks, block.volume.row(point)) {
                    blocks.fill(block.coordinates(point), volume);
                }
            }
        }
        for total in &self.wanted {
            match total {
                Total::Mass => rows.push(sums.mass),
                Total::Volume => rows.push(sums.volume),
                Total::CenterOfMass => rows.extend(sums.moment.map(|moment| moment / sums.mass)),
                Total::LinearMomentum => rows.extend(sums.momentum),
                Total::AngularMomentum => rows.extend(sums.angular),
                Total::Overfill => rows.push(self.blocks.as_ref().map_or(f64::NAN, Blocks::overfill)),
            }
        }
    }
}
