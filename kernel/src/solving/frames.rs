//! Motion held along directions that are not those of the axes: the dofs of such nodes are turned into
//! frames of their own, in which held directions are components (Bathe 2014, section 4.2.2).
//!
//! With R the frame of node i, its rows unit vectors of which the first are held, the system
//! K u = r becomes (R_i K_ij R_jᵀ) (R_j u_j) = R_i r_i: symmetry stays, and what holds components holds
//! directions. Dofs of a node beyond the dimension of space, such as a pressure, are not turned.

use super::{ActiveDofs, Field, Newton, NonlinearSystem, StepReport, System};
use crate::error::Error;
use crate::variables::Slide;
use bia_linalg::LinearSolver;

/// Square of the sine of the angle below which a wall counts as held by others already.
const PARALLEL: f64 = 1e-12;

/// The frames of the nodes that slide along walls.
#[derive(Debug, Clone, Default)]
pub struct NodalFrames {
    dimension: usize,
    /// Dofs a node.
    block: usize,
    frames: Vec<Frame>,
    /// Held dofs, in frames where nodes have one.
    fixed: Vec<bool>,
}

#[derive(Debug, Clone)]
struct Frame {
    /// Number of the node among the active ones.
    number: usize,
    /// Orthonormal rows, held ones first.
    axes: [[f64; 3]; 3],
    /// How many directions are held.
    held: usize,
    /// The walls: unit normal n, and the direction n′ along which the node gives way to it, which is n
    /// without what is held before it.
    walls: Vec<([f64; 3], [f64; 3])>,
}

impl NodalFrames {
    /// Frames of the active nodes among `slides`, which lists the walls of a node next to each other or
    /// not; `dofs` has `dimension` components and possibly more on each node, and tells which are fixed.
    /// The walls of one node may be several, in a corner.
    pub fn new(dimension: usize, dofs: &ActiveDofs, slides: &[Slide]) -> Self {
        let mut numbered: Vec<(usize, [f64; 3])> =
            slides.iter().filter_map(|slide| Some((dofs.number(slide.node)?, slide.normal))).collect();
        if numbered.is_empty() {
            return Self::default();
        }
        numbered.sort_by_key(|(number, _)| *number);
        let (block, mut fixed) = (dofs.block(), dofs.fixed().to_vec());
        let frames: Vec<Frame> = numbered
            .chunk_by(|a, b| a.0 == b.0)
            .map(|walls| {
                let components = &mut fixed[walls[0].0 * block..][..dimension];
                let frame = Frame::new(walls, components);
                components.iter_mut().enumerate().for_each(|(a, fixed)| *fixed = a < frame.held);
                frame
            })
            .collect();
        Self { dimension, block, frames, fixed }
    }

    /// True where no node has a frame, so that nothing needs to be turned.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Which dofs are fixed, in frames; `dofs` are those that the frames were made of.
    pub fn fixed<'a>(&'a self, dofs: &'a ActiveDofs) -> &'a [bool] {
        if self.is_empty() { dofs.fixed() } else { &self.fixed }
    }

    /// Lets a motion slide along the walls: takes the normal components away. Fixed components keep
    /// what they have, so that a node that is moved along one axis gives way along the others.
    pub fn slide(&self, motion: &mut [f64]) {
        for frame in &self.frames {
            let motion = self.of(frame, motion);
            for (normal, way) in &frame.walls {
                let share = dot(normal, motion) / dot(way, way);
                motion.iter_mut().zip(way).for_each(|(v, w)| *v -= share * w);
            }
        }
    }

    /// From components along the axes to components in the frames.
    pub fn turn(&self, values: &mut [f64]) {
        for frame in &self.frames {
            let values = self.of(frame, values);
            let turned = frame.axes.map(|axis| dot(&axis, values));
            values.copy_from_slice(&turned[..self.dimension]);
        }
    }

    /// From components in the frames to components along the axes.
    pub fn turn_back(&self, values: &mut [f64]) {
        for frame in &self.frames {
            let values = self.of(frame, values);
            let sum = |a: usize| frame.axes.iter().zip(&*values).map(|(axis, value)| axis[a] * value).sum::<f64>();
            let back: [f64; 3] = std::array::from_fn(sum);
            values.copy_from_slice(&back[..self.dimension]);
        }
    }

    /// Leaves of a force (along the axes) what acts along held directions.
    pub fn keep_held(&self, dofs: &ActiveDofs, force: &mut [f64]) {
        self.turn(force);
        force.iter_mut().zip(self.fixed(dofs)).filter(|(_, fixed)| !**fixed).for_each(|(force, _)| *force = 0.0);
        self.turn_back(force);
    }

    /// Turns the system, and its matrix if wanted.
    pub fn turn_system(&self, system: &mut System, with_matrix: bool) {
        self.turn(&mut system.rhs);
        if !with_matrix {
            return;
        }
        let pattern = system.matrix.pattern.clone();
        let size = pattern.block();
        for frame in &self.frames {
            for entry in pattern.row(frame.number) {
                let rows = &mut system.matrix.values[entry * size * size..][..size * size];
                (0..size).for_each(|column| frame.turn(self.dimension, rows, column, size));
                let column = pattern.columns()[entry] as usize;
                // The pattern is symmetric.
                let Some(mirror) = pattern.position(column, frame.number) else { continue };
                let rows = &mut system.matrix.values[mirror as usize * size * size..][..size * size];
                (0..size).for_each(|row| frame.turn(self.dimension, rows, row * size, 1));
            }
        }
    }

    /// Solves one step with the held directions held: `problem` itself knows nothing of frames. Its
    /// predicted unknowns slide already ([`NodalFrames::slide`]).
    ///
    /// # Errors
    /// Those of [`Newton::solve`].
    pub fn solve(
        &self,
        newton: &Newton,
        problem: &mut dyn NonlinearSystem,
        system: &mut System,
        solver: &mut dyn LinearSolver,
    ) -> Result<StepReport, Error> {
        if self.is_empty() {
            return newton.solve(problem, system, solver);
        }
        let mut dofs = problem.dofs().clone();
        dofs.fixed_mut().copy_from_slice(&self.fixed);
        let mut unknowns = problem.unknowns().to_vec();
        self.turn(&mut unknowns);
        newton.solve(&mut InFrames { problem, frames: self, dofs, unknowns }, system, solver)
    }

    fn of<'a>(&self, frame: &Frame, values: &'a mut [f64]) -> &'a mut [f64] {
        &mut values[frame.number * self.block..][..self.dimension]
    }
}

impl Frame {
    /// The frame of a node with these walls and fixed components.
    fn new(walls: &[(usize, [f64; 3])], fixed: &[bool]) -> Self {
        let dimension = fixed.len();
        let unit = |a: usize| std::array::from_fn(|b| if a == b { 1.0 } else { 0.0 });
        let mut axes: Vec<[f64; 3]> = (0..dimension).filter(|&a| fixed[a]).map(unit).collect();
        let mut given_way = Vec::new();
        for &(_, normal) in walls {
            let way = without(normal, &axes, dimension);
            let square = dot(&way, &way);
            if square > PARALLEL {
                axes.push(way.map(|w| w / square.sqrt()));
                given_way.push((normal, way));
            }
        }
        let held = axes.len();
        while axes.len() < dimension {
            // The axis of space that is furthest from those taken.
            let rests = (0..dimension).map(|a| without(unit(a), &axes, dimension));
            let rest = rests.max_by(|p, q| dot(p, p).total_cmp(&dot(q, q))).unwrap_or([0.0; 3]);
            let size = dot(&rest, &rest).sqrt();
            axes.push(rest.map(|r| r / size));
        }
        let axes = std::array::from_fn(|k| axes.get(k).copied().unwrap_or([0.0; 3]));
        Self { number: walls[0].0, axes, held, walls: given_way }
    }

    /// Turns the vector whose entries stand at `first`, `first + stride`, …
    fn turn(&self, dimension: usize, values: &mut [f64], first: usize, stride: usize) {
        let mut old = [0.0; 3];
        (0..dimension).for_each(|a| old[a] = values[first + a * stride]);
        (0..dimension).for_each(|k| values[first + k * stride] = dot(&self.axes[k], &old));
    }
}

/// A vector without its parts along orthonormal axes and beyond the dimension of space.
fn without(mut vector: [f64; 3], axes: &[[f64; 3]], dimension: usize) -> [f64; 3] {
    vector[dimension..].fill(0.0);
    for axis in axes {
        let share = dot(axis, &vector);
        (0..3).for_each(|a| vector[a] -= share * axis[a]);
    }
    vector
}

/// Over the components that both have.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// A problem whose dofs are those of the frames.
struct InFrames<'a> {
    problem: &'a mut dyn NonlinearSystem,
    frames: &'a NodalFrames,
    dofs: ActiveDofs,
    unknowns: Vec<f64>,
}

impl NonlinearSystem for InFrames<'_> {
    fn dofs(&self) -> &ActiveDofs {
        &self.dofs
    }

    fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error> {
        self.problem.assemble(system, with_matrix)?;
        self.frames.turn_system(system, with_matrix);
        Ok(())
    }

    fn correct(&mut self, correction: &[f64]) {
        let mut back = correction.to_vec();
        self.frames.turn_back(&mut back);
        self.problem.correct(&back);
        self.unknowns.copy_from_slice(self.problem.unknowns());
        self.frames.turn(&mut self.unknowns);
    }

    fn unknowns(&self) -> &[f64] {
        &self.unknowns
    }

    fn describe_dof(&self, dof: usize) -> (String, [f64; 3]) {
        self.problem.describe_dof(dof)
    }

    fn fields(&self) -> &[Field] {
        self.problem.fields()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solving::{CellBuffer, Criterion, Tolerances};
    use bia_linalg::{Method, solver};

    /// Springs on two nodes of three dofs each (two of motion, one of another kind): K u = load.
    struct Springs {
        dofs: ActiveDofs,
        u: Vec<f64>,
        stiffness: Vec<f64>,
        load: Vec<f64>,
    }

    impl Springs {
        /// A symmetric matrix without zeros that is dominated by its diagonal.
        fn new(fixed: &[usize]) -> Self {
            let mut dofs = ActiveDofs::new(3, &[true, true]);
            fixed.iter().for_each(|&dof| dofs.fixed_mut()[dof] = true);
            let entry = |i: usize, j: usize| if i == j { 9.0 + i as f64 } else { 1.0 / (1 + i + j) as f64 };
            let stiffness = (0..36).map(|k| entry(k / 6, k % 6)).collect();
            Self { dofs, u: vec![0.0; 6], stiffness, load: vec![1.0, -2.0, 3.0, 4.0, 5.0, -6.0] }
        }

        fn residual(&self, dof: usize) -> f64 {
            self.load[dof] - (0..6).map(|j| self.stiffness[6 * dof + j] * self.u[j]).sum::<f64>()
        }
    }

    impl NonlinearSystem for Springs {
        fn dofs(&self) -> &ActiveDofs {
            &self.dofs
        }
        fn assemble(&mut self, system: &mut System, with_matrix: bool) -> Result<(), Error> {
            system.clear(with_matrix);
            system.add_cells(with_matrix, |_, buffer: &mut CellBuffer| {
                for i in 0..6 {
                    buffer.vector[i] = self.residual(i);
                    for j in (0..6).filter(|_| with_matrix) {
                        // Columns are ordered by component.
                        buffer.matrix[6 * i + j % 3 * 2 + j / 3] = self.stiffness[6 * i + j];
                    }
                }
                Ok::<(), Error>(())
            })
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

    fn solved(fixed: &[usize], imposed: &[(usize, f64)], slides: &[Slide]) -> (Springs, NodalFrames) {
        let mut springs = Springs::new(fixed);
        imposed.iter().for_each(|&(dof, value)| springs.u[dof] = value);
        let frames = NodalFrames::new(2, &springs.dofs, slides);
        frames.slide(&mut springs.u);
        let mut system = System::new(3, 2, vec![0, 1], vec![0, 2]);
        let tolerances = Tolerances { relative: 1e-13, absolute: 0.0 };
        let newton = Newton { max_iterations: 3, criterion: Some(Criterion::Residual(tolerances)) };
        let report = frames.solve(&newton, &mut springs, &mut system, solver(Method::Cholesky).as_mut()).unwrap();
        assert!(report.converged && report.iterations == 1, "{report:?}");
        (springs, frames)
    }

    /// At the solution the normal component is zero and so are the residuals of all other directions:
    /// the conditions of the constrained minimum.
    #[test]
    fn a_node_slides_along_a_tilted_wall() {
        let normal = [0.6, 0.8, 0.0];
        let (springs, frames) = solved(&[], &[], &[Slide { node: 1, normal }]);
        let u = &springs.u;
        assert!((0.6 * u[3] + 0.8 * u[4]).abs() < 1e-15 && u[3].abs() > 0.01, "{u:?}");
        let rest: Vec<f64> = (0..6).map(|dof| springs.residual(dof)).collect();
        assert!((-0.8 * rest[3] + 0.6 * rest[4]).abs() < 1e-13);
        assert!([0, 1, 2, 5].iter().all(|&dof| rest[dof].abs() < 1e-13), "{rest:?}");
        let mut reaction: Vec<f64> = rest.iter().map(|r| -r).collect();
        frames.keep_held(&springs.dofs, &mut reaction);
        assert!((0.6 * reaction[3] + 0.8 * reaction[4]).abs() > 1.0, "the wall pushes");
        assert!(reaction.iter().zip(&rest).all(|(reaction, rest)| (reaction + rest).abs() < 1e-13));
    }

    /// Two walls hold a corner; a wall along a fixed component adds nothing; and a component that is
    /// moved pushes its node along the wall.
    #[test]
    fn corners_are_held_and_moved_components_keep_their_motion() {
        let slide = |normal| Slide { node: 0, normal };
        let corner = [slide([0.0, 1.0, 0.0]), Slide { node: 1, normal: [1.0, 0.0, 0.0] }, slide([0.6, 0.8, 0.0])];
        let (springs, frames) = solved(&[], &[], &corner);
        assert!(springs.u[0].abs() < 1e-15 && springs.u[1].abs() < 1e-15 && springs.u[3].abs() < 1e-15);
        assert_eq!(frames.fixed(&springs.dofs), [true, true, false, true, false, false]);

        let (springs, _) = solved(&[1], &[(1, 0.25)], &[slide([0.0, -1.0, 0.0])]);
        assert!(springs.u[1] == 0.25 && springs.residual(0).abs() < 1e-13, "{:?}", springs.u);

        let (springs, _) = solved(&[0], &[(0, 0.3)], &[slide([0.6, 0.8, 0.0])]);
        assert!(springs.u[0] == 0.3 && (springs.u[1] + 0.225).abs() < 1e-15, "{:?}", springs.u);
    }

    #[test]
    fn turning_back_undoes_turning() {
        let dofs = ActiveDofs::new(3, &[true; 3]);
        let third = (1.0f64 / 3.0).sqrt();
        let slides = [Slide { node: 2, normal: [third; 3] }, Slide { node: 0, normal: [0.0, 0.6, -0.8] }];
        let frames = NodalFrames::new(3, &dofs, &slides);
        let start: Vec<f64> = (0..9).map(|i| f64::from(i) - 3.5).collect();
        let mut values = start.clone();
        frames.turn(&mut values);
        assert!((values[0] - (0.6 * start[1] - 0.8 * start[2])).abs() < 1e-15);
        assert!((values[6] - third * (start[6] + start[7] + start[8])).abs() < 1e-14);
        assert_eq!(values[3..6], start[3..6]);
        frames.turn_back(&mut values);
        assert!(values.iter().zip(&start).all(|(a, b)| (a - b).abs() < 1e-14), "{values:?}");
        assert!(NodalFrames::new(3, &dofs, &[]).is_empty());
    }
}
