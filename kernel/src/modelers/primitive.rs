//! Primitives: what bodies are filled from.

use super::mesh::bounds;
use super::reading::{AXES, Extent};
use super::surface::Surface;
use crate::diagnostic::InputErrors;
use crate::parameters::{Key, Kind, Parameters, Range, Settings};
use std::f64::consts::PI;
use std::path::Path;

const TYPE: Key = Key::required("type", Kind::Text, "kind of primitive");
const CENTER: Key = Key::new("center", Kind::Vector3, "[0.0, 0.0, 0.0]", "centre [m]");
const AXIS: Key = Key::new("axis", Kind::Choice(&AXES), "\"z\"", "axis of the cylinder");
const HEIGHT: Key = Key::required("height", Kind::Number(Range::POSITIVE), "length along the axis [m]");
const RADIUS: Key = Key::required("radius", Kind::Number(Range::POSITIVE), "radius [m]");
const INNER: Key = Key::required("inner_radius", Kind::Number(Range::POSITIVE), "radius of the hole [m]");
const OUTER: Key = Key::required("outer_radius", Kind::Number(Range::POSITIVE), "outer radius [m]");

/// Names of the primitives with their keys.
pub(super) const TYPES: &[(&str, &[Key])] = &[
    ("box", &[TYPE, CORNER_LOW, CORNER_HIGH]),
    ("disc", &[TYPE, CENTER, RADIUS]),
    ("ring", &[TYPE, CENTER, INNER, OUTER]),
    ("polygon", &[TYPE, Key::required("vertices", Kind::List, "corners [x, y] or [x, y, 0], in order [m]")]),
    ("cylinder", &[TYPE, CENTER, AXIS, RADIUS, HEIGHT]),
    ("tube", &[TYPE, CENTER, AXIS, INNER, OUTER, HEIGHT]),
    ("sphere", &[TYPE, CENTER, RADIUS]),
    ("spherical_shell", &[TYPE, CENTER, INNER, OUTER]),
    ("circle", &[TYPE, CENTER, RADIUS]),
    ("annulus", &[TYPE, CENTER, INNER, OUTER]),
    ("stl", &[TYPE, FILE, SCALE]),
];
const FILE: Key = Key::required("file", Kind::Text, "STL file of a closed surface, text or binary, beside the project");
const SCALE: Key =
    Key::new("scale", Kind::Number(Range::POSITIVE), "1.0", "length of the file's unit [m], 0.001 for mm");
const CORNER_LOW: Key = Key::required("min", Kind::Vector3, "lowest corner [m]; a plane box has equal z of 0");
const CORNER_HIGH: Key = Key::required("max", Kind::Vector3, "highest corner [m]");

/// Share of a primitive's size by which a point on its surface may miss it through round-off.
const MARGIN: f64 = 1e-9;

/// The form of a primitive about its centre. Solid ones have the inner radius 0.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Form {
    /// A bar, rectangle or box.
    Box(Extent),
    /// A disc or ring in the plane.
    Disc { inner: f64, outer: f64 },
    /// A simple polygon in the plane, its corners counter-clockwise.
    Polygon(Vec<[f64; 2]>),
    /// A cylinder or tube about the axis of this index.
    Cylinder { inner: f64, outer: f64, height: f64, axis: usize },
    /// A sphere or spherical shell.
    Sphere { inner: f64, outer: f64 },
    /// What a closed surface encloses.
    Surface(Surface),
}

/// A primitive: its form and its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Primitive {
    /// Name of the type, for messages.
    pub name: String,
    /// Form.
    pub form: Form,
    /// Centre in m; centroid of a polygon, middle of the box around a surface.
    pub center: [f64; 3],
}

impl Primitive {
    /// From an object with the key `type`; files stand in `folder`.
    pub fn read(parameters: &Parameters, folder: &Path) -> Result<Self, InputErrors> {
        let name = parameters.text("type")?;
        let Some((_, keys)) = TYPES.iter().find(|(known, _)| *known == name) else {
            let place = parameters.child("type").unwrap_or_else(|| parameters.clone());
            let message = format!("there is no primitive {name:?}");
            return Err(place.error(message).allowed(&name, TYPES.iter().map(|(known, _)| *known)).into());
        };
        let settings = parameters.read(keys)?;
        let (form, center) = match name.as_str() {
            "box" => {
                let mut errors = InputErrors::default();
                let extent = Extent::read(&settings, &mut errors);
                errors.or((Form::Box(extent), extent.center()))?
            }
            "polygon" => {
                let vertices = vertices(&settings)?;
                let (_, [x, y]) = area_and_centroid(&vertices);
                (Form::Polygon(vertices), [x, y, 0.0])
            }
            "stl" => {
                let surface = Surface::read(&folder.join(settings.text("file")), settings.number("scale"))?;
                let (low, high) = surface.bounds();
                (Form::Surface(surface), std::array::from_fn(|axis| 0.5 * (low[axis] + high[axis])))
            }
            _ => (round(&name, &settings)?, settings.vector("center")),
        };
        let built = Self { name, form, center };
        if built.dimension() == 2 && center[2] != 0.0 {
            return Err(settings
                .error("center", format!("is {} in z, must be 0 for a plane primitive", center[2]))
                .into());
        }
        Ok(built)
    }

    /// Number of dimensions.
    pub fn dimension(&self) -> usize {
        match &self.form {
            Form::Box(extent) => extent.dimension,
            Form::Disc { .. } | Form::Polygon(_) => 2,
            Form::Cylinder { .. } | Form::Sphere { .. } | Form::Surface(_) => 3,
        }
    }

    /// Length (m), area (m²) or volume (m³).
    pub fn measure(&self) -> f64 {
        match &self.form {
            Form::Box(extent) => (0..extent.dimension).map(|axis| extent.size(axis)).product(),
            Form::Disc { inner, outer } => PI * (outer * outer - inner * inner),
            Form::Polygon(vertices) => area_and_centroid(vertices).0,
            Form::Cylinder { inner, outer, height, .. } => PI * (outer * outer - inner * inner) * height,
            Form::Sphere { inner, outer } => 4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3)),
            Form::Surface(surface) => surface.volume(),
        }
    }

    /// Corners of a box that holds the primitive.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        let half = match &self.form {
            Form::Box(extent) => return (extent.low, extent.high),
            Form::Surface(surface) => return surface.bounds(),
            Form::Polygon(vertices) => {
                let points: Vec<[f64; 3]> = vertices.iter().map(|&[x, y]| [x, y, 0.0]).collect();
                return bounds(&points);
            }
            Form::Disc { outer, .. } => [*outer, *outer, 0.0],
            Form::Cylinder { outer, height, axis, .. } => {
                std::array::from_fn(|i| if i == *axis { 0.5 * height } else { *outer })
            }
            Form::Sphere { outer, .. } => [*outer; 3],
        };
        (std::array::from_fn(|i| self.center[i] - half[i]), std::array::from_fn(|i| self.center[i] + half[i]))
    }

    /// Whether a point lies in the primitive or, but for round-off, on its surface.
    pub fn contains(&self, x: [f64; 3]) -> bool {
        let away: [f64; 3] = std::array::from_fn(|i| x[i] - self.center[i]);
        let between = |square: f64, inner: f64, outer: f64| {
            let (distance, margin) = (square.sqrt(), MARGIN * outer);
            distance >= inner - margin && distance <= outer + margin
        };
        let squares = away.map(|d| d * d);
        match &self.form {
            Form::Box(extent) => (0..extent.dimension).all(|axis| {
                let margin = MARGIN * extent.size(axis);
                x[axis] >= extent.low[axis] - margin && x[axis] <= extent.high[axis] + margin
            }),
            Form::Disc { inner, outer } => between(squares[0] + squares[1], *inner, *outer),
            Form::Polygon(vertices) => in_polygon(vertices, [x[0], x[1]]),
            Form::Cylinder { inner, outer, height, axis } => {
                let radial = squares.iter().enumerate().filter(|(i, _)| i != axis).map(|(_, square)| square).sum();
                away[*axis].abs() <= height * (0.5 + MARGIN) && between(radial, *inner, *outer)
            }
            Form::Sphere { inner, outer } => between(squares.iter().sum(), *inner, *outer),
            Form::Surface(surface) => surface.contains(x),
        }
    }
}

fn round(name: &str, settings: &Settings) -> Result<Form, InputErrors> {
    let (inner, outer) = if settings.given("radius") {
        (0.0, settings.number("radius"))
    } else {
        (settings.number("inner_radius"), settings.number("outer_radius"))
    };
    if inner >= outer {
        let message = format!("is {inner}, must be less than outer_radius, which is {outer}");
        return Err(settings.error("inner_radius", message).into());
    }
    Ok(match name {
        "cylinder" | "tube" => {
            let axis = AXES.iter().position(|axis| *axis == settings.text("axis")).unwrap_or(2);
            Form::Cylinder { inner, outer, height: settings.number("height"), axis }
        }
        "sphere" | "spherical_shell" => Form::Sphere { inner, outer },
        _ => Form::Disc { inner, outer },
    })
}

/// At least three corners that enclose an area, counter-clockwise.
fn vertices(settings: &Settings) -> Result<Vec<[f64; 2]>, InputErrors> {
    let mut errors = InputErrors::default();
    let mut corners = Vec::new();
    for entry in settings.get("vertices").map_or(Vec::new(), Parameters::entries) {
        let numbers: Option<Vec<f64>> =
            entry.value().as_array().and_then(|list| list.iter().map(serde_json::Value::as_f64).collect());
        match numbers.as_deref() {
            Some([x, y] | [x, y, 0.0]) => corners.push([*x, *y]),
            _ => errors.push(entry.error("must be [x, y] or [x, y, 0]")),
        }
    }
    errors.or(())?;
    let (area, _) = area_and_centroid(&corners);
    if corners.len() < 3 || area == 0.0 {
        let message = format!("has {} corners and the area {area}, must enclose an area", corners.len());
        return Err(settings.error("vertices", message).into());
    }
    if area < 0.0 {
        corners.reverse();
    }
    Ok(corners)
}

/// Signed area in m² and centroid of a polygon.
fn area_and_centroid(vertices: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let Some(&origin) = vertices.first() else { return (0.0, [0.0; 2]) };
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for (i, a) in vertices.iter().enumerate() {
        let b = vertices[(i + 1) % vertices.len()];
        let [u, v] = [[a[0] - origin[0], a[1] - origin[1]], [b[0] - origin[0], b[1] - origin[1]]];
        let triangle = 0.5 * (u[0] * v[1] - u[1] * v[0]);
        area += triangle;
        (0..2).for_each(|k| moment[k] += triangle * (u[k] + v[k]) / 3.0);
    }
    (area, std::array::from_fn(|k| origin[k] + moment[k] / area))
}

/// Counts the edges that a ray to the right crosses.
fn in_polygon(vertices: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let crosses = |i: usize| {
        let (a, b) = (vertices[i], vertices[(i + 1) % vertices.len()]);
        (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    (0..vertices.len()).filter(|&i| crosses(i)).count() % 2 == 1
}
