//! A field of a `.vtu` file, asked for its value at any place: initial states from other runs and programs.

use crate::diagnostic::{Diagnostic, InputErrors, Place};
use crate::geometry::CellLocator;
use crate::io::dataset::{CellsOf, Dataset, Field, FieldData};
use crate::io::{convert, vtu_read};
use crate::model::ModelPart;
use crate::parameters::{Key, Kind, Range, Settings};
use std::collections::HashMap;
use std::path::Path;

/// Keys of processes that take values from a file.
pub const KEYS: [Key; 4] = [
    Key::optional("file", Kind::Text, "vtu file with the values, beside the project; instead of functions"),
    Key::optional("field", Kind::Text, "name of the field in the file, by default that of the variable"),
    Key::new(
        "match",
        Kind::Choice(&["nearest", "interpolated"]),
        "\"nearest\"",
        "value of the file's nearest point (or centre of a cell, for fields of cells), or interpolated in its cells",
    ),
    Key::optional(
        "tolerance",
        Kind::Number(Range::NOT_NEGATIVE),
        "largest distance to the nearest point [m]; by default any",
    ),
];

/// Values over space, of `width` numbers each.
pub struct SampledField {
    values: Vec<f64>,
    width: usize,
    search: Search,
}

enum Search {
    Nearest(Nearest, f64),
    Cells(Box<(ModelPart, CellLocator)>),
}

impl SampledField {
    /// The field that the settings (with the keys of this module) name, with `width` numbers at each place;
    /// none where they name no file.
    ///
    /// # Errors
    /// A file that cannot be read; a field that it does not hold, or of another width, or with values that
    /// are no numbers.
    pub fn read(settings: &Settings, variable: &str, width: usize, folder: &Path) -> Result<Option<Self>, InputErrors> {
        if settings.get("file").is_none() {
            return match settings.get("field") {
                Some(_) => Err(settings.error("field", "is for a \"file\", and none is given").into()),
                None => Ok(None),
            };
        }
        let path = folder.join(settings.text("file"));
        let data = vtu_read::read_vtu(&path)?;
        let name = if settings.get("field").is_some() { settings.text("field") } else { variable };
        let (places, field) = places(&data, name, settings)?;
        let values: Vec<f64> = match &field.values {
            FieldData::F64(values) => values.clone(),
            FieldData::I32(values) => values.iter().map(|&value| f64::from(value)).collect(),
        };
        let told = |message: String| InputErrors::from(Diagnostic::error(Place::file(&path), message));
        if field.components != width {
            return Err(told(format!("the field {name:?} has {} components, must have {width}", field.components)));
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            return Err(told(format!("the field {name:?} has the value {} at the entry {}", values[at], at / width)));
        }
        let search = if settings.text("match") == "nearest" {
            let tolerance = settings.get("tolerance").map_or(f64::INFINITY, |_| settings.number("tolerance"));
            Search::Nearest(Nearest::new(places), tolerance)
        } else {
            let part = convert::model_part(data, &path)?;
            if part.elements.shapes.iter().all(|shape| shape.dimension() == 0) {
                return Err(told(
                    "has no cells in which values could be interpolated; \"match\" must be nearest".into(),
                ));
            }
            let locator = CellLocator::new(&part, 1e-9);
            Search::Cells(Box::new((part, locator)))
        };
        Ok(Some(Self { values, width, search }))
    }

    /// The value at a place; none where no cell holds it or no point is near enough.
    pub fn at(&self, x: [f64; 3], out: &mut [f64]) -> Option<()> {
        let row = |index: usize| &self.values[index * self.width..(index + 1) * self.width];
        match &self.search {
            Search::Nearest(nearest, tolerance) => {
                let (index, distance) = nearest.find(x)?;
                if distance > *tolerance {
                    return None;
                }
                out.iter_mut().zip(row(index)).for_each(|(out, value)| *out = *value);
            }
            Search::Cells(cells) => {
                let (part, locator) = &**cells;
                let (cell, xi) = locator.locate(x, None)?;
                let mut functions = [0.0; 8];
                part.elements.shapes[cell as usize].functions(xi, &mut functions);
                out.fill(0.0);
                for (&node, n) in part.elements.nodes_of(cell as usize).iter().zip(functions) {
                    out.iter_mut().zip(row(node as usize)).for_each(|(out, value)| *out += n * value);
                }
            }
        }
        Some(())
    }
}

/// Where the values of a field stand: its points, or the centres of its cells.
fn places<'a>(data: &'a Dataset, name: &str, settings: &Settings) -> Result<(Vec<[f64; 3]>, &'a Field), InputErrors> {
    if let Some(field) = data.point_fields.iter().find(|field| field.name == name) {
        return Ok((data.points.clone(), field));
    }
    match (data.cell_fields.iter().find(|field| field.name == name), &data.cells) {
        (Some(_), _) if settings.text("match") != "nearest" => {
            let message = format!("the field {name:?} is one of cells, which cannot be interpolated");
            Err(settings.error("match", message).help("set \"match\" to \"nearest\"").into())
        }
        (Some(field), CellsOf::Mesh { starts, nodes, .. }) => {
            let center = |cell: &[u32]| {
                let sum = |axis: usize| nodes[cell[0] as usize..cell[1] as usize].iter().map(move |&n| (n, axis));
                let count = f64::from(cell[1] - cell[0]).max(1.0);
                std::array::from_fn(|axis| {
                    sum(axis).map(|(n, axis)| data.points[n as usize][axis]).sum::<f64>() / count
                })
            };
            Ok((starts.windows(2).map(center).collect(), field))
        }
        (field, _) => {
            let names = data.point_fields.iter().chain(&data.cell_fields).map(|field| field.name.as_str());
            let key = if settings.get("field").is_some() { "field" } else { "file" };
            match field {
                Some(field) => Ok((data.points.clone(), field)),
                None => {
                    Err(settings.error(key, format!("the file holds no field {name:?}")).allowed(name, names).into())
                }
            }
        }
    }
}

/// Points in cubes, about one in each.
struct Nearest {
    points: Vec<[f64; 3]>,
    low: [f64; 3],
    /// Edge of the cubes [m].
    size: f64,
    /// Range of cubes along each axis.
    most: [i64; 3],
    cubes: HashMap<[i64; 3], Vec<u32>>,
}

impl Nearest {
    fn new(points: Vec<[f64; 3]>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for x in &points {
            (0..3).for_each(|a| (low[a], high[a]) = (low[a].min(x[a]), high[a].max(x[a])));
        }
        let extents: Vec<f64> = (0..3).map(|a| high[a] - low[a]).filter(|extent| *extent > 0.0).collect();
        let volume: f64 = extents.iter().product();
        let longest = extents.iter().fold(0.0f64, |most, extent| most.max(*extent));
        let size = (volume / points.len().max(1) as f64).powf(1.0 / extents.len().max(1) as f64).max(longest / 1e6);
        let size = if size > 0.0 && size.is_finite() { size } else { 1.0 };
        let mut nearest = Self { points, low, size, most: [0; 3], cubes: HashMap::new() };
        for index in 0..nearest.points.len() {
            let cube = nearest.cube(nearest.points[index]);
            (0..3).for_each(|a| nearest.most[a] = nearest.most[a].max(cube[a]));
            nearest.cubes.entry(cube).or_default().push(index as u32);
        }
        nearest
    }

    fn cube(&self, x: [f64; 3]) -> [i64; 3] {
        std::array::from_fn(|a| ((x[a] - self.low[a]) / self.size).floor() as i64)
    }

    /// Index and distance [m] of the nearest point; of several the first. None without points.
    fn find(&self, x: [f64; 3]) -> Option<(usize, f64)> {
        let center = self.cube(x);
        let mut best: Option<(u32, f64)> = None;
        // The first shell that meets the cubes, and the last one.
        let reach = |a: usize| (center[a].saturating_sub(self.most[a]).max(0)).max(-center[a].min(0));
        let first = (0..3).map(reach).max()?;
        let last = (0..3).map(|a| (self.most[a] - center[a]).abs().max(center[a].abs())).max()?;
        for shell in first..=last {
            // All points of this shell are at least so far away.
            if best.is_some_and(|(_, square)| square.sqrt() <= (shell - 1) as f64 * self.size) {
                break;
            }
            self.shell(center, shell, |index| {
                let away: f64 = (0..3).map(|a| (self.points[index as usize][a] - x[a]).powi(2)).sum();
                if best.is_none_or(|(other, least)| away < least || (away == least && index < other)) {
                    best = Some((index, away));
                }
            });
        }
        best.map(|(index, square)| (index as usize, square.sqrt()))
    }

    /// Visits the points in cubes whose largest distance from the centre along an axis is `shell`.
    fn shell(&self, center: [i64; 3], shell: i64, mut visit: impl FnMut(u32)) {
        let range = |a: usize| (center[a] - shell).max(0)..=(center[a] + shell).min(self.most[a]);
        for i in range(0) {
            for j in range(1) {
                let edge = (i - center[0]).abs() == shell || (j - center[1]).abs() == shell;
                let whole = range(2);
                let ends = [center[2] - shell, center[2] + shell];
                let mut look = |k: i64| self.cubes.get(&[i, j, k]).into_iter().flatten().for_each(|&p| visit(p));
                if edge {
                    whole.for_each(&mut look);
                } else {
                    let distinct = if shell == 0 { &ends[..1] } else { &ends[..] };
                    distinct.iter().filter(|k| whole.contains(k)).for_each(|&k| look(k));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::vtu::{VtuOptions, write_vtu};
    use crate::parameters::{Document, Parameters};

    fn random(count: usize) -> Vec<[f64; 3]> {
        let mut seed = 7u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..count).map(|_| [next(), 3.0 * next(), 0.1 * next() - 1.0]).collect()
    }

    #[test]
    fn the_nearest_point_is_that_of_a_full_search() {
        for count in [1, 2, 50, 2000] {
            let nearest = Nearest::new(random(count));
            for x in random(300).into_iter().map(|x| x.map(|x| 2.0 * x - 0.7)) {
                let square = |p: &[f64; 3]| (0..3).map(|a| (p[a] - x[a]).powi(2)).sum::<f64>();
                let least = nearest.points.iter().map(square).fold(f64::INFINITY, f64::min);
                assert_eq!(nearest.find(x).unwrap().1, least.sqrt(), "{x:?}");
            }
        }
        let plane = Nearest::new(random(100).into_iter().map(|[x, y, _]| [x, y, 0.0]).collect());
        assert!(plane.find([1e9, 0.0, 0.0]).is_some() && Nearest::new(Vec::new()).find([0.0; 3]).is_none());
    }

    fn settings(object: &str, folder: &Path) -> Settings {
        let document = Document::parse(&folder.join("P.json"), object.into()).unwrap();
        Parameters::root(document).read(&KEYS).unwrap()
    }

    /// A linear field is interpolated exactly; the nearest value is that of a corner.
    #[test]
    fn fields_of_meshes_are_interpolated_or_taken_from_the_nearest_point() {
        let folder = tempfile::tempdir().unwrap();
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let mut data = Dataset::vertices(corners.to_vec());
        data.cells = CellsOf::Mesh { starts: vec![0, 4], nodes: vec![0, 1, 2, 3], types: vec![9] };
        let linear = |[x, y, _]: [f64; 3]| [1.0 + x - y, x + y, 0.0];
        let values = FieldData::F64(corners.iter().flat_map(|&x| linear(x)).collect());
        data.point_fields.push(Field { name: "V".into(), components: 3, values });
        data.cell_fields.push(Field { name: "C".into(), components: 3, values: FieldData::I32(vec![4, 5, 6]) });
        write_vtu(&folder.path().join("a.vtu"), &data, None, &VtuOptions::default()).unwrap();
        let read = |object: &str| SampledField::read(&settings(object, folder.path()), "V", 3, folder.path());
        let at = |object: &str, x: [f64; 3]| {
            let mut out = [f64::NAN; 3];
            read(object).unwrap().unwrap().at(x, &mut out).map(|()| out)
        };
        let interpolated = r#"{"file": "a.vtu", "match": "interpolated"}"#;
        let found = at(interpolated, [0.7, 0.4, 0.0]).unwrap();
        found.iter().zip(linear([0.7, 0.4, 0.0])).for_each(|(a, b)| assert!((a - b).abs() < 1e-14, "{found:?}"));
        assert_eq!(at(interpolated, [2.1, 0.4, 0.0]), None);
        assert_eq!(at(r#"{"file": "a.vtu"}"#, [2.1, 0.4, 0.0]), Some(linear([2.0, 0.0, 0.0])));
        assert_eq!(at(r#"{"file": "a.vtu", "tolerance": 0.1}"#, [2.1, 0.4, 0.0]), None);
        assert_eq!(at(r#"{"file": "a.vtu", "field": "C"}"#, [9.0; 3]), Some([4.0, 5.0, 6.0]));
        assert!(read("{}").unwrap().is_none());
        for (object, part) in [
            (r#"{"file": "b.vtu"}"#, "cannot be read"),
            (r#"{"file": "a.vtu", "field": "W"}"#, "no field \"W\""),
            (r#"{"file": "a.vtu", "field": "C", "match": "interpolated"}"#, "cannot be interpolated"),
            (r#"{"field": "V"}"#, "is for a \"file\""),
        ] {
            let errors = read(object).err().unwrap();
            assert!(errors.to_string().contains(part), "{errors}");
        }
        let narrow = SampledField::read(&settings(r#"{"file": "a.vtu"}"#, folder.path()), "V", 1, folder.path());
        assert!(narrow.err().unwrap().to_string().contains("has 3 components, must have 1"));
    }
}
