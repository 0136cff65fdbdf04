//! Newton's method on the dofs of active nodes.

use super::criteria::free_norm;
use super::lead::lead;
use super::{ActiveDofs, Criterion, Field, References, System, Tolerances};
use crate::diagnostic::InputErrors;
use crate::error::{Error, Failure};
use crate::parameters::{Key, Kind, Range, Settings};
use bia_linalg::{LinearError, LinearSolver};
use std::time::{Duration, Instant};

/// What an application solves: a residual and its tangent at the current unknowns.
pub trait NonlinearSystem {
    /// The dofs.
    fn dofs(&self) -> &ActiveDofs;

    /// Builds the residual in `system.rhs`, and the tangent (minus its derivative) in
    /// `system.matrix` if `with_matrix`.
    ///
    /// # Errors
    /// A numerical failure, such as an inverted deformation.
    fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error>;

    /// Adds a correction to the unknowns and updates what depends on them.
    fn correct(&mut self, correction: &[f64]);

    /// Sets displacements back to the start of the step and gives what has been imposed on held dofs since; none, and
    /// nothing is changed, where that is nothing or is not known.
    fn set_back(&mut self) -> Option<Vec<f64>> {
        None
    }

    /// The current unknowns, as the displacement criterion sees them.
    fn unknowns(&self) -> &[f64];

    /// Kinds of dofs whose convergence is judged apart; none to judge all together.
    fn fields(&self) -> &[Field] {
        &[]
    }

    /// Round-off of the residual of a dof, in units of ε h |K_ii|.
    fn round_off(&self) -> f64 {
        ROUND_OFF
    }

    /// Id and place of a dof, for messages.
    fn describe_dof(&self, dof: usize) -> (String, [f64; 3]);
}

/// Round-off of a residual whose forces are those of a deformation gradient, in units of ε h |K_ii|.
pub const ROUND_OFF: f64 = 64.0;

/// Keys of the method in `solver_settings`.
pub const CONVERGENCE: [Key; 8] = [
    Key::new("analysis_type", Kind::Choice(&["non_linear", "linear"]), "\"non_linear\"", "Newton, or one solve a step")
        .adjustable(),
    Key::new(
        "convergence_criterion",
        Kind::Choice(&["residual_criterion", "displacement_criterion", "and_criterion", "or_criterion"]),
        "\"residual_criterion\"",
        "when Newton stops",
    )
    .adjustable(),
    Key::new("displacement_relative_tolerance", Kind::Number(Range::NOT_NEGATIVE), "1e-4", "relative to the unknowns")
        .adjustable(),
    Key::new(
        "displacement_absolute_tolerance",
        Kind::Number(Range::NOT_NEGATIVE),
        "1e-9",
        "per root of the dofs [m]; counts where it is given, and with kratos_exact",
    )
    .adjustable(),
    Key::new(
        "residual_relative_tolerance",
        Kind::Number(Range::NOT_NEGATIVE),
        "1e-4",
        "relative to the first residual",
    )
    .adjustable(),
    Key::new(
        "residual_absolute_tolerance",
        Kind::Number(Range::NOT_NEGATIVE),
        "1e-9",
        "per dof [N]; counts where it is given, and with kratos_exact",
    )
    .adjustable(),
    Key::new("max_iteration", Kind::Integer { min: 1 }, "20", "most Newton iterations a step").adjustable(),
    Key::new(
        "on_no_convergence",
        Kind::Choice(&["continue", "cut_step", "error"]),
        "\"continue\"",
        "implicit: go on with a warning as Kratos does, take the step again in halves, or stop the run",
    )
    .adjustable(),
];

/// What becomes of a step that does not converge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OnNoConvergence {
    /// The run goes on from it, with a warning.
    #[default]
    Continue,
    /// It is taken again in halves, and so is a step that fails.
    CutStep,
    /// The run stops.
    Error,
}

impl OnNoConvergence {
    /// From settings with the keys [`CONVERGENCE`].
    pub fn of(settings: &Settings) -> Self {
        match settings.text("on_no_convergence") {
            "cut_step" => Self::CutStep,
            "error" => Self::Error,
            _ => Self::Continue,
        }
    }

    /// Refuses anything but the default where nothing is iterated.
    pub fn refuse(settings: &Settings, errors: &mut InputErrors) {
        if Self::of(settings) != Self::Continue {
            let message = format!("{:?} is for implicit runs", settings.text("on_no_convergence"));
            let help = "leave it out: an explicit step has no iterations that could fail to converge";
            errors.push(settings.error("on_no_convergence", message).help(help));
        }
    }
}

/// Settings of the method.
#[derive(Debug, Clone, PartialEq)]
pub struct Newton {
    /// Most iterations a step.
    pub max_iterations: usize,
    /// When to stop; none for a linear analysis of one solve a step.
    pub criterion: Option<Criterion>,
}

/// How a step went.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StepReport {
    /// Newton iterations; 0 for a linear analysis.
    pub iterations: usize,
    /// Iterations of the linear solver, summed.
    pub linear_iterations: usize,
    /// False when the criterion was not met.
    pub converged: bool,
    /// Norm of the residual at the end, if it was built.
    pub residual: f64,
    /// Name and place of the free dof with the largest residual, where the criterion was not met.
    pub worst: Option<(String, [f64; 3])>,
    /// How often the step was halved, at most.
    pub halvings: u32,
    /// What the linear solver had to say, such as a fall-back to another method.
    pub note: Option<String>,
    /// Time spent on building.
    pub assembly: Duration,
    /// Time spent on linear systems.
    pub linear: Duration,
}

impl StepReport {
    /// Adds a later piece of the same step.
    pub fn add(&mut self, piece: StepReport) {
        self.iterations += piece.iterations;
        self.linear_iterations += piece.linear_iterations;
        self.converged &= piece.converged;
        self.residual = piece.residual;
        self.note = self.note.take().or(piece.note);
        self.assembly += piece.assembly;
        self.linear += piece.linear;
    }
}

impl Newton {
    /// From settings with the keys [`CONVERGENCE`]. An absolute tolerance has the units of the scene, so
    /// that one which nobody gave means nothing: 1e-9 N is more than all loads on a body of a nanometre.
    pub fn read(settings: &Settings, kratos_exact: bool) -> Self {
        let tolerances = |kind: &str| {
            let (relative, absolute) = (format!("{kind}_relative_tolerance"), format!("{kind}_absolute_tolerance"));
            let counts = kratos_exact || settings.given(&absolute);
            Tolerances {
                relative: settings.number(&relative),
                absolute: if counts { settings.number(&absolute) } else { 0.0 },
            }
        };
        let (displacement, residual) = (tolerances("displacement"), tolerances("residual"));
        let criterion = match settings.text("convergence_criterion") {
            "displacement_criterion" => Criterion::Displacement(displacement),
            "and_criterion" => Criterion::And(displacement, residual),
            "or_criterion" => Criterion::Or(displacement, residual),
            _ => Criterion::Residual(residual),
        };
        let linear = settings.text("analysis_type") == "linear";
        Self { max_iterations: settings.integer("max_iteration") as usize, criterion: (!linear).then_some(criterion) }
    }

    /// Solves one step from the predicted unknowns.
    ///
    /// # Errors
    /// A failure of the application, or a singular or indefinite system, named by node and dof.
    pub fn solve(
        &self,
        problem: &mut dyn NonlinearSystem,
        system: &mut System,
        solver: &mut dyn LinearSolver,
    ) -> Result<StepReport, Error> {
        let mut report = StepReport { converged: true, ..StepReport::default() };
        let mut correction = vec![0.0; problem.dofs().order()];
        let mut initial = None;
        let mut references = References::default();
        loop {
            if let Err(inverted) = timed(&mut report.assembly, || problem.assemble(system, true)) {
                let led = initial.is_none() && timed(&mut report.linear, || lead(problem, system, solver))?;
                if !led {
                    return Err(inverted);
                }
                timed(&mut report.assembly, || problem.assemble(system, true))?;
            }
            references.note(problem.fields(), problem.dofs(), &system.rhs);
            let initial = *initial.get_or_insert_with(|| free_norm(problem.dofs(), &system.rhs));
            if !initial.is_finite() {
                return Err(not_finite(problem, &system.rhs).into());
            }
            system.matrix.constrain(problem.dofs().fixed(), &mut system.rhs);
            correction.fill(0.0);
            let solved = timed(&mut report.linear, || solver.solve(&system.matrix, &system.rhs, &mut correction));
            let solved = solved.map_err(|error| describe(problem, &error))?;
            report.linear_iterations += solved.iterations.unwrap_or(0);
            report.note = report.note.or(solved.note);
            problem.correct(&correction);
            let Some(criterion) = &self.criterion else {
                return Ok(report);
            };
            report.iterations += 1;
            let (mut cut, before) = (false, if report.iterations == 1 { initial } else { report.residual });
            if criterion.needs_residual() {
                cut = timed(&mut report.assembly, || evaluate(problem, system, &mut correction))?;
                report.residual = free_norm(problem.dofs(), &system.rhs);
                if !report.residual.is_finite() {
                    return Err(not_finite(problem, &system.rhs).into());
                }
            }
            let (fields, dofs) = (problem.fields(), problem.dofs());
            // Where a further correction would lessen it, the residual is not all round-off.
            let least = if report.residual > 0.1 * before { round_off(problem, system) } else { Vec::new() };
            let vectors = [&system.rhs, &correction, problem.unknowns()];
            report.converged = if fields.is_empty() {
                criterion.met(dofs, initial, &least, vectors)
            } else {
                criterion.met_by_fields(fields, &references, dofs, &least, vectors)
            };
            // What a part of a correction leaves is not the end, however small it is.
            report.converged &= !cut;
            if report.converged {
                return Ok(report);
            }
            if report.iterations >= self.max_iterations {
                report.worst = worst(problem, &system.rhs);
                return Ok(report);
            }
        }
    }
}

/// Most times that a correction is halved.
const MOST_CUTS: usize = 8;

/// Builds the residual after a correction. Where there is none, as the correction turns material inside
/// out, half of it is taken, and so on; gives whether less than the whole was.
fn evaluate(problem: &mut dyn NonlinearSystem, system: &mut System, correction: &mut [f64]) -> Result<bool, Error> {
    let Err(whole) = problem.assemble(system, false) else { return Ok(false) };
    for _ in 0..MOST_CUTS {
        correction.iter_mut().for_each(|value| *value *= -0.5);
        problem.correct(correction);
        correction.iter_mut().for_each(|value| *value = -*value);
        if problem.assemble(system, false).is_ok() {
            return Ok(true);
        }
    }
    Err(whole)
}

/// Name and place of the free dof with the largest residual.
fn worst(problem: &dyn NonlinearSystem, rhs: &[f64]) -> Option<(String, [f64; 3])> {
    let free = rhs.iter().zip(problem.dofs().fixed()).enumerate().filter(|(_, (_, fixed))| !**fixed);
    let (dof, _) = free.max_by(|(_, (a, _)), (_, (b, _))| a.abs().total_cmp(&b.abs()))?;
    Some(problem.describe_dof(dof))
}

/// What the residual of each dof may be by round-off alone. A deformation gradient is known to the machine's
/// precision ε, as if the nodes at the distance h of neighbours stood wrong by ε h, and a force to ε h |K_ii|:
/// with a stiffness of 1e10 times the load, no more than six digits of the residual can vanish.
fn round_off(problem: &dyn NonlinearSystem, system: &System) -> Vec<f64> {
    let (pattern, block) = (&system.matrix.pattern, system.matrix.pattern.block());
    let position = |row: usize| problem.describe_dof(row * block).1;
    let between = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let distance = match pattern.rows() {
        0 => 0.0,
        _ => {
            let neighbours = pattern.columns()[pattern.row(0)].iter().map(|&column| position(column as usize));
            neighbours.map(|x| between(x, position(0))).fold(0.0, f64::max)
        }
    };
    let scale = problem.round_off() * f64::EPSILON * distance;
    (0..pattern.order()).map(|dof| scale * system.matrix.diagonal_entry(dof).abs()).collect()
}

fn timed<T>(total: &mut Duration, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *total += start.elapsed();
    result
}

fn not_finite(problem: &dyn NonlinearSystem, rhs: &[f64]) -> Failure {
    let failure = Failure::new(
        "the residual is not finite",
        "a smaller time step, or look at the material constants and loads near this place",
    );
    match rhs.iter().position(|x| !x.is_finite()) {
        Some(dof) => {
            let (name, position) = problem.describe_dof(dof);
            failure.at(name, position)
        }
        None => failure,
    }
}

pub(super) fn describe(problem: &dyn NonlinearSystem, error: &LinearError) -> Failure {
    // The dof is named by node and component below; its number in the matrix says nothing to a user.
    let what = match error {
        LinearError::Singular { .. } => {
            "the linear system is singular: a degree of freedom is not held (missing support, or a node without stiffness)"
                .to_string()
        }
        LinearError::NotPositiveDefinite { .. } => {
            "the linear system is indefinite: the state is unstable, or a degree of freedom is not held".to_string()
        }
        LinearError::NonFinite { .. } => "an entry of the linear system is not finite".to_string(),
        other => format!("the linear system cannot be solved: {other}"),
    };
    let failure = Failure::new(
        what,
        "fix enough displacements to hold each body, look for a body that touches the grid by a corner only, \
         or choose another linear solver",
    );
    match error.dof() {
        Some(dof) => {
            let (name, position) = problem.describe_dof(dof);
            failure.at(name, position)
        }
        None => failure,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solving::CellBuffer;
    use bia_linalg::{Method, solver};

    /// Solves u + u³ = f on each of two dofs, the second of which is fixed.
    struct Cubic {
        dofs: ActiveDofs,
        u: Vec<f64>,
        load: f64,
        /// Beyond this there is no residual.
        limit: f64,
        residuals: Vec<f64>,
    }

    impl NonlinearSystem for Cubic {
        fn dofs(&self) -> &ActiveDofs {
            &self.dofs
        }
        fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error> {
            if self.u[0] > self.limit {
                return Err(Failure::new("too far", "less").into());
            }
            system.clear(with_matrix);
            let u = &self.u;
            system.add_cells(with_matrix, |_, buffer: &mut CellBuffer| {
                for i in 0..2 {
                    buffer.vector[i] = self.load - u[i] - u[i].powi(3);
                    if with_matrix {
                        buffer.matrix[3 * i] = 1.0 + 3.0 * u[i] * u[i];
                    }
                }
                Ok::<(), Error>(())
            })?;
            if !with_matrix {
                self.residuals.push(system.rhs[0].abs());
            }
            Ok(())
        }
        fn correct(&mut self, correction: &[f64]) {
            self.u.iter_mut().zip(correction).for_each(|(u, d)| *u += d);
        }
        fn unknowns(&self) -> &[f64] {
            &self.u
        }
        fn describe_dof(&self, dof: usize) -> (String, [f64; 3]) {
            (format!("dof {dof}"), [0.0; 3])
        }
    }

    fn cubic(load: f64) -> (Cubic, System) {
        let mut dofs = ActiveDofs::new(1, &[true, true]);
        dofs.fixed_mut()[1] = true;
        let system = System::new(1, 2, vec![0, 1], vec![0, 2]);
        (Cubic { dofs, u: vec![0.0, 0.5], load, limit: f64::INFINITY, residuals: Vec::new() }, system)
    }

    #[test]
    fn newton_converges_quadratically_and_keeps_fixed_dofs() {
        let (mut problem, mut system) = cubic(10.0);
        let tolerances = Tolerances { relative: 1e-14, absolute: 0.0 };
        let newton = Newton { max_iterations: 20, criterion: Some(Criterion::Residual(tolerances)) };
        let report = newton.solve(&mut problem, &mut system, solver(Method::Cholesky).as_mut()).unwrap();
        assert!(report.converged && (problem.u[0] - 2.0).abs() < 1e-13, "{}", problem.u[0]);
        assert_eq!(problem.u[1], 0.5);
        let r = &problem.residuals;
        let order = (r[r.len() - 2] / r[r.len() - 3]).ln() / (r[r.len() - 3] / r[r.len() - 4]).ln();
        assert!(order > 1.7, "order {order} from {r:?}");
    }

    /// The first correction goes to 10, where there is no residual; a quarter of it is taken.
    #[test]
    fn corrections_without_a_residual_are_halved() {
        let tolerances = Tolerances { relative: 1e-14, absolute: 0.0 };
        let newton = Newton { max_iterations: 20, criterion: Some(Criterion::Residual(tolerances)) };
        let (mut problem, mut system) = cubic(10.0);
        problem.limit = 4.0;
        let report = newton.solve(&mut problem, &mut system, solver(Method::Cholesky).as_mut()).unwrap();
        assert!(report.converged && (problem.u[0] - 2.0).abs() < 1e-13 && problem.u[1] == 0.5, "{}", problem.u[0]);
        assert!((problem.residuals[0] - (2.5 + 2.5f64.powi(3) - 10.0)).abs() < 1e-12, "{:?}", problem.residuals);
        let (mut problem, mut system) = cubic(10.0);
        problem.limit = 0.01;
        let error = newton.solve(&mut problem, &mut system, solver(Method::Cholesky).as_mut()).unwrap_err();
        assert!(error.to_string().contains("too far"), "{error}");
    }

    #[test]
    fn infinite_loads_are_failures_with_a_place() {
        let (mut problem, mut system) = cubic(f64::INFINITY);
        let newton = Newton { max_iterations: 20, criterion: None };
        let error = newton.solve(&mut problem, &mut system, solver(Method::Lu).as_mut()).unwrap_err();
        assert!(error.to_string().contains("dof 0"), "{error}");
    }
}
