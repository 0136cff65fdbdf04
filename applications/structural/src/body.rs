//! The body: its elements with their laws and history, and what they answer to displacements.

use crate::element::Point;
use crate::settings::SolverSettings;
use bia_constitutive::{BodyMaterial, BuiltLaw, Catalogue, Deformation, Kinematics, Options, Response, Want};
use bia_kernel::diagnostic::{Diagnostic, InputErrors};
use bia_kernel::error::Failure;
use bia_kernel::geometry::{CellShape, QuadraturePoint, Shape, rule};
use bia_kernel::model::ModelPart;
use nalgebra::Matrix3;

/// A material as elements use it.
pub struct ElementMaterial {
    /// Its law.
    pub built: BuiltLaw,
    /// Density (kg/m³); 0 where statics has none.
    pub density: f64,
    /// Extent across the mesh: thickness (m), cross area (m²) or 1.
    pub extent: f64,
}

/// Elements with their materials and the history of their points.
pub struct Body {
    /// Materials.
    pub materials: Vec<ElementMaterial>,
    material_of: Vec<u16>,
    /// Rule of each shape: as many points as nodes, which integrate stiffness and mass in full.
    rules: [Vec<QuadraturePoint>; Shape::ALL.len()],
    /// History at the start of the step, element after element, point after point.
    pub states: Vec<f64>,
    /// Start of each element's history.
    pub state_starts: Vec<usize>,
}

/// The points of an element with the law's answers.
pub struct Answers<const D: usize, const N: usize> {
    /// Integration points.
    pub points: [Point<D, N>; N],
    /// Deformations.
    pub deformations: [Deformation; N],
    /// Stress, and tangent if wanted.
    pub responses: [Response; N],
}

impl Body {
    /// The elements of a part with the laws that its materials name.
    ///
    /// # Errors
    /// Elements without material or of another dimension, constants at fault: all together.
    pub fn new(
        part: &ModelPart,
        materials: &[BodyMaterial],
        settings: &SolverSettings,
        catalogue: &Catalogue,
        dynamic: bool,
    ) -> Result<Self, InputErrors> {
        let mut errors = InputErrors::default();
        let built: Vec<Option<ElementMaterial>> = materials
            .iter()
            .map(|m| errors.absorb(element_material(m, settings.kinematics, catalogue, dynamic)))
            .collect();
        let mut material_of = Vec::with_capacity(part.elements.len());
        for (element, shape) in part.elements.shapes.iter().enumerate() {
            let id = part.elements.ids[element];
            if shape.dimension() != settings.dimension {
                let message = format!("element {id} is a {}, which does not fit {}", shape.name(), settings.kinematics);
                let diagnostic = Diagnostic::error(settings.mesh.place(id), message);
                return Err(diagnostic.help("check domain_size and the element names").into());
            }
            let wanted = part.elements.properties[element];
            match materials.iter().position(|material| material.properties.id == wanted) {
                Some(position) => material_of.push(position as u16),
                None => {
                    let message = format!("element {id} has no material");
                    let diagnostic = Diagnostic::error(settings.mesh.place(id), message);
                    return Err(diagnostic.help("give every part a material in the materials file").into());
                }
            }
        }
        let materials: Vec<ElementMaterial> = errors.or(built)?.into_iter().flatten().collect();
        let rules = Shape::ALL.map(|shape| rule(shape, shape.node_count()).unwrap_or_default());
        let mut body = Self { materials, material_of, rules, states: Vec::new(), state_starts: vec![0] };
        for (element, &shape) in part.elements.shapes.iter().enumerate() {
            let law = &body.materials[body.material_of[element] as usize].built.law;
            let first = body.states.len();
            body.states.resize(first + body.rules[shape as usize].len() * law.state_len(), 0.0);
            law.initial_state(&mut body.states[first..]);
            body.state_starts.push(body.states.len());
        }
        Ok(body)
    }

    /// The material of an element.
    pub fn material(&self, element: usize) -> &ElementMaterial {
        &self.materials[self.material_of[element] as usize]
    }

    /// The points of an element, undeformed.
    #[inline]
    pub fn points<S: CellShape<D, N>, const D: usize, const N: usize>(
        &self,
        part: &ModelPart,
        element: usize,
    ) -> [Point<D, N>; N] {
        let ElementMaterial { built, extent, .. } = self.material(element);
        let corners = part.nodes.gather(part.elements.nodes_of(element));
        let rule = &self.rules[S::SHAPE as usize];
        std::array::from_fn(|k| Point::new::<S>(&corners, &rule[k], built.kinematics, *extent))
    }

    /// What an element answers to nodal displacements; `states` is scratch for the history and goes
    /// out as that of the end of the step.
    ///
    /// # Errors
    /// An element turned inside out, or a law without an answer.
    #[inline]
    pub fn answers<S: CellShape<D, N>, const D: usize, const N: usize>(
        &self,
        part: &ModelPart,
        element: usize,
        [previous, displacements]: [&[[f64; D]; N]; 2],
        time_step: f64,
        want: Want,
        states: &mut Vec<f64>,
    ) -> Result<Answers<D, N>, Failure> {
        let BuiltLaw { law, kinematics, .. } = &self.material(element).built;
        let points = self.points::<S, D, N>(part, element);
        let deformations = points.map(|point| Deformation {
            previous: point.gradient(*kinematics, previous),
            time_step,
            ..Deformation::from_gradient(point.gradient(*kinematics, displacements))
        });
        for (deformation, point) in deformations.iter().zip(&points) {
            let jacobian = deformation.gradient.determinant();
            if jacobian.is_nan() || jacobian <= 0.0 {
                let what = "the displacement turns an element inside out";
                let advice = "smaller steps of load or time, or a finer mesh";
                return Err(located(
                    Failure::new(what, advice),
                    part,
                    element,
                    &point.functions,
                    &deformation.gradient,
                ));
            }
        }
        states.clear();
        states.extend_from_slice(&self.states[self.state_starts[element]..self.state_starts[element + 1]]);
        let mut responses = [Response::default(); N];
        law.respond(&deformations, states, &mut responses, want).map_err(|(k, error)| {
            let what = format!("the law {} has no answer: {error}", law.name());
            let failure = Failure::new(what, "a smaller time step or smaller loads");
            located(failure, part, element, &points[k].functions, &deformations[k].gradient)
        })?;
        Ok(Answers { points, deformations, responses })
    }
}

/// Adds element, place in the undeformed body and deformation to a failure.
fn located(failure: Failure, part: &ModelPart, element: usize, functions: &[f64], gradient: &Matrix3<f64>) -> Failure {
    let corners = part.corners(&part.elements, element);
    let position = std::array::from_fn(|a| functions.iter().zip(&corners).map(|(n, x)| n * x[a]).sum());
    failure
        .at(format!("element {}", part.elements.ids[element]), position)
        .detail(format!("deformation gradient: {:?}", gradient.transpose().as_slice()))
        .detail(format!("J = {:e}", gradient.determinant()))
}

fn element_material(
    material: &BodyMaterial,
    kinematics: Kinematics,
    catalogue: &Catalogue,
    dynamic: bool,
) -> Result<ElementMaterial, InputErrors> {
    let mut errors = InputErrors::default();
    let entry = material.properties.law.as_deref().and_then(|name| catalogue.find(name));
    let of_law = |name: &str| entry.is_some_and(|entry| entry.variables.iter().any(|variable| variable.name == name));
    let density = match of_law("DENSITY") {
        true => material.properties.number("DENSITY"),
        false => errors.absorb(material.positive("DENSITY", dynamic)).flatten(),
    };
    let extent = match kinematics {
        Kinematics::ThreeDimensional | Kinematics::Axisymmetric => None,
        Kinematics::UniaxialStrain => errors.absorb(material.positive("CROSS_AREA", false)).flatten(),
        _ => errors.absorb(material.positive("THICKNESS", false)).flatten(),
    };
    match errors.absorb(material.law(catalogue, kinematics, &Options::default())) {
        Some(built) if !errors.any_error() => {
            Ok(ElementMaterial { built, density: density.unwrap_or(0.0), extent: extent.unwrap_or(1.0) })
        }
        _ => Err(errors),
    }
}
