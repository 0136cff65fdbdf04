//! The smallest and the largest value of variables over points or nodes, such as the range of det F.

use super::sample::{SOURCE, Samples, Source};
use super::{Measurement, TABLE, TableOutput};
use crate::diagnostic::InputErrors;
use crate::io::checkpoint::{Archive, CheckpointError};
use crate::io::table::Heading;
use crate::model::Model;
use crate::parameters::{Key, Kind, Parameters};
use crate::processes::Requirements;
use crate::reference::Compared;
use crate::registry::{ProcessEntry, Registry};

const KEYS: &[Key] = &Key::join::<11, 1, 12>(
    Key::join::<7, 4, 11>(TABLE, SOURCE),
    [Key::required(
        "output_variables",
        Kind::Texts,
        "such as MP_DETERMINANT_F, VELOCITY_X, MP_CAUCHY_STRESS_VECTOR_XX",
    )],
);

/// Registers the process of this file.
pub fn register(registry: &mut Registry) {
    registry.process(ProcessEntry {
        name: "range_output_process",
        aliases: &[],
        application: None,
        keys: KEYS,
        help: "smallest and largest value of variables over points or nodes, in time as a table",
        build: |building| {
            let mut errors = InputErrors::default();
            let source = errors.absorb(Source::read(&building));
            let entries = building.settings.get("output_variables").map_or(Vec::new(), Parameters::entries);
            let mut quantities = Vec::new();
            for entry in entries {
                let name = entry.value().as_str().unwrap_or_default();
                let compared = errors.absorb(Compared::named(name, &entry, building.registry));
                quantities.extend(compared.map(|compared| (compared, entry)));
            }
            let Some(source) = source else { return Err(errors) };
            errors.or(())?;
            let (samples, width) = (Samples::default(), Vec::new());
            Ok(Box::new(TableOutput::new(&building, Ranges { source, quantities, samples, width })?))
        },
    });
}

struct Ranges {
    source: Source,
    quantities: Vec<(Compared, Parameters)>,
    samples: Samples,
    /// Numbers of each quantity.
    width: Vec<usize>,
}

impl Measurement for Ranges {
    fn name(&self) -> &'static str {
        "ranges"
    }

    fn connect(&mut self, model: &Model) -> Result<(), InputErrors> {
        self.source.connect(model)
    }

    fn require(&self, requirements: &mut Requirements) {
        for (compared, place) in &self.quantities {
            self.source.require(compared.variable.name, place, requirements);
        }
    }

    fn check(&mut self, model: &Model) -> Result<(), InputErrors> {
        self.source.find_points(model)
    }

    fn exchange_state(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        self.source.exchange(archive)?;
        let mut width: Vec<u64> = self.width.iter().map(|width| *width as u64).collect();
        archive.column("width", &mut width)?;
        self.width = width.into_iter().map(|width| width as usize).collect();
        Ok(())
    }

    fn headings(&mut self, model: &Model) -> Vec<Heading> {
        let (mut headings, mut width) = (Vec::new(), Vec::new());
        for (compared, _) in &self.quantities {
            self.source.sample(model, compared, &mut self.samples);
            width.push(self.samples.width);
            for name in compared.names(self.samples.width) {
                let of = |end: &str| Heading::new(format!("{name}_{end}"), compared.variable.unit);
                headings.extend([of("SMALLEST"), of("LARGEST")]);
            }
        }
        self.width = width;
        headings
    }

    fn measure(&mut self, model: &Model, rows: &mut Vec<f64>) {
        for ((compared, _), width) in self.quantities.iter().zip(&self.width) {
            self.source.sample(model, compared, &mut self.samples);
            for component in 0..*width {
                let values = self.samples.values.iter().skip(component).step_by((*width).max(1));
                rows.extend(range_of(values.copied()));
            }
        }
    }
}

/// Smallest and largest; not a number if one is, or if there are none.
fn range_of(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let widest = values.fold(None, |range: Option<[f64; 2]>, x| match range {
        None => Some([x, x]),
        Some([a, _]) if a.is_nan() || x.is_nan() => Some([f64::NAN; 2]),
        Some([smallest, largest]) => Some([smallest.min(x), largest.max(x)]),
    });
    widest.unwrap_or([f64::NAN; 2])
}

#[cfg(test)]
mod tests {
    use super::range_of;

    #[test]
    fn what_is_no_number_is_not_forgotten() {
        assert_eq!(range_of([3.0, -1.0, 2.0].into_iter()), [-1.0, 3.0]);
        assert!(range_of([3.0, f64::NAN, 2.0].into_iter()).iter().all(|x| x.is_nan()));
        assert!(range_of(std::iter::empty()).iter().all(|x| x.is_nan()));
    }
}
