//! One step of the loop, whole or in pieces.

use super::Analysis;
use crate::error::{Error, Failure};
use crate::io::checkpoint::{Archive, CheckpointError, Contents, file};
use crate::processes::{Clock, Context};
use crate::solving::newton::{OnNoConvergence, StepReport};
use std::time::Instant;

/// Most times that a step is halved: pieces are at least 1/256 of it.
const MOST_HALVINGS: u32 = 8;

/// A piece of a step, as shares of it.
#[derive(Clone, Copy)]
struct Piece {
    begin: f64,
    end: f64,
    halvings: u32,
}

impl Analysis {
    /// Takes a step of this size, whose end the clock shows then: in one piece, unless it does not converge
    /// and may be cut.
    pub(super) fn take_step(&mut self, size: f64) -> Result<StepReport, Error> {
        let start = self.clock;
        self.clock.step += 1;
        let policy = self.solver.on_no_convergence();
        let whole = Piece { begin: 0.0, end: 1.0, halvings: 0 };
        if policy != OnNoConvergence::CutStep {
            let report = self.attempt(&start, size, whole, policy)?;
            self.end_attempt()?;
            return Ok(report);
        }
        let (mut total, mut pieces) = (StepReport { converged: true, ..StepReport::default() }, vec![whole]);
        while let Some(piece) = pieces.pop() {
            if piece.begin > 0.0 {
                self.all(0, |process, context| process.execute_between_pieces(context))?;
            }
            let kept = self.keep()?;
            // What goes wrong in the transfer to the points is a reason to cut, too.
            let done = self.attempt(&start, size, piece, policy).and_then(|report| self.end_attempt().map(|()| report));
            match done {
                Ok(report) => total.add(report),
                Err(Error::Failure(failure)) if piece.halvings == MOST_HALVINGS => {
                    let line = format!("the step was halved {MOST_HALVINGS} times, to {:e} s", self.clock.time_step);
                    return Err(failure.detail(line).into());
                }
                Err(Error::Failure(failure)) => {
                    tracing::debug!("step {} is cut: {}", self.clock.step, failure.report().what);
                    self.exchange_kept(&mut Archive::loading(&kept))?;
                    let halvings = piece.halvings + 1;
                    total.halvings = total.halvings.max(halvings);
                    let middle = 0.5 * (piece.begin + piece.end);
                    pieces.push(Piece { begin: middle, halvings, ..piece });
                    pieces.push(Piece { end: middle, halvings, ..piece });
                }
                Err(other) => return Err(other),
            }
        }
        self.clock.time_step = size;
        self.clock.share = 1.0;
        Ok(total)
    }

    /// Solves a piece of a step.
    fn attempt(
        &mut self,
        start: &Clock,
        size: f64,
        piece: Piece,
        policy: OnNoConvergence,
    ) -> Result<StepReport, Error> {
        let share = piece.end - piece.begin;
        self.clock.share = share;
        self.clock.time_step = share * size;
        self.clock.time = start.time + piece.end * size;
        self.clock.load_time = self.clock.time - (1.0 - self.solver.load_time()) * self.clock.time_step;
        self.all(0, |process, context| process.execute_initialize_solution_step(context))?;
        let begin = Instant::now();
        let mut context = Context { model: &mut self.model, clock: &self.clock, options: &self.options };
        self.solver.predict(&mut context)?;
        let report = self.solver.solve_solution_step(&mut context)?;
        self.stages[1].1 += begin.elapsed();
        match report.converged || policy == OnNoConvergence::Continue {
            true => Ok(report),
            false => Err(not_converged(&report).into()),
        }
    }

    /// Brings the solution to the points.
    fn end_attempt(&mut self) -> Result<(), Error> {
        let begin = Instant::now();
        let mut context = Context { model: &mut self.model, clock: &self.clock, options: &self.options };
        self.solver.finalize_solution_step(&mut context)?;
        self.stages[1].1 += begin.elapsed();
        Ok(())
    }

    /// The state from which a piece starts.
    fn keep(&mut self) -> Result<Contents, CheckpointError> {
        file::keep(Contents::default(), &mut |archive| self.exchange_kept(archive))
    }

    /// Processes keep nothing that a step that is taken back would change: they act at its end.
    fn exchange_kept(&mut self, archive: &mut Archive) -> Result<(), CheckpointError> {
        archive.section("model", |archive| self.model.exchange_state(archive, &self.variables))?;
        archive.section("solver", |archive| self.solver.exchange_state(&mut self.model, archive))
    }
}

fn not_converged(report: &StepReport) -> Failure {
    let what = format!(
        "the step did not converge: after {} iterations the residual is {:e}",
        report.iterations, report.residual
    );
    let advice = "a smaller time step, a larger max_iteration, looser tolerances, or \"on_no_convergence\": \
                  \"cut_step\" (halve the step) or \"continue\" (go on as Kratos does)";
    let failure = Failure::new(what, advice);
    match &report.worst {
        Some((name, position)) => failure.at(name, *position),
        None => failure,
    }
}
