//! The analysis's part in checkpoints: what it saves, and when.

use super::Analysis;
use super::account::{Account, RecordPlan, Recorder};
use super::restart;
use crate::error::{Error, Failure};
use crate::io::checkpoint::{Archive, CheckpointError, Contents};
use crate::solving::solver::MechanicalEnergy;
use serde_json::Value;

impl Analysis {
    /// The checkpoint to go on from, if any; else those of earlier runs are removed.
    pub(super) fn choose_checkpoint(
        &mut self,
        record: Option<&RecordPlan>,
        resumes: bool,
    ) -> Result<Option<Contents>, Error> {
        if self.restart.is_none() && !resumes {
            return Ok(None);
        }
        let record = record.map_or(Value::Null, |plan| plan.states.into());
        let (sum, exact) = (self.model.mesh_sum(), self.options.kratos_exact);
        self.identity = restart::identity(&self.project, sum, exact, record);
        let (output, identity) = (&self.options.output, &self.identity);
        let found = if resumes { Some(restart::newest(output, identity, &self.adjustable)?) } else { None };
        match (&mut self.restart, &found) {
            (Some(restart), Some(_)) => restart.adopt(),
            (Some(restart), None) => restart.clear()?,
            _ => {}
        }
        let Some((path, contents)) = found else { return Ok(None) };
        tracing::info!("resumed from {}", path.display());
        // The plan of the steps to come depends on it; the rest of the clock follows with the state.
        self.clock.step = contents.head.get("step").and_then(Value::as_u64).unwrap_or(0) as usize;
        self.clock.time = contents.head.get("time").and_then(Value::as_f64).unwrap_or(self.clock.time);
        Ok(Some(contents))
    }

    /// Saves or loads all that the run keeps from step to step.
    pub(super) fn exchange(
        &mut self,
        archive: &mut Archive,
        account: &mut Account,
        recorder: &mut Option<Recorder>,
    ) -> Result<(), CheckpointError> {
        archive.section("analysis", |archive| {
            let clock = &mut self.clock;
            archive.count("step", &mut clock.step)?;
            archive.number("time", &mut clock.time)?;
            archive.number("time_step", &mut clock.time_step)?;
            archive.number("load_time", &mut clock.load_time)?;
            archive.flags("nodes reached in the first step", &mut self.reached_first)?;
            MechanicalEnergy::exchange(&mut self.energy_at_start, archive)?;
            account.exchange(archive)?;
            recorder.as_mut().map_or(Ok(()), |recorder| recorder.exchange(archive))
        })?;
        archive.section("model", |archive| self.model.exchange_state(archive, &self.variables))?;
        archive.section("solver", |archive| self.solver.exchange_state(&mut self.model, archive))?;
        for (index, process) in self.processes.iter_mut().enumerate() {
            let name = format!("process {index}: {}", process.name());
            archive.section(&name, |archive| process.exchange_state(archive))?;
        }
        Ok(())
    }

    /// Writes a checkpoint, if the project asks for any and one is due or the run stops; and keeps the
    /// state in memory for a failure to come.
    pub(super) fn save_checkpoint(
        &mut self,
        account: &mut Account,
        recorder: &mut Option<Recorder>,
        stops: bool,
    ) -> Result<(), Error> {
        let Some(mut restart) = self.restart.take() else { return Ok(()) };
        let (due, stale) = (stops || restart.is_due(&self.clock), restart.is_stale());
        if due {
            let (clock, identity) = (self.clock, std::mem::take(&mut self.identity));
            let saved = restart.save(&clock, &identity, &mut |archive| self.exchange(archive, account, recorder));
            self.identity = identity;
            saved?;
        }
        self.restart = Some(restart);
        if !stops && (due || stale) { self.keep_state(account, recorder) } else { Ok(()) }
    }

    /// Keeps the state in memory, from which a run that fails can be resumed; only with `restart`.
    pub(super) fn keep_state(&mut self, account: &mut Account, recorder: &mut Option<Recorder>) -> Result<(), Error> {
        let Some(mut restart) = self.restart.take() else { return Ok(()) };
        let clock = self.clock;
        let kept = restart.keep(&clock, &mut |archive| self.exchange(archive, account, recorder));
        self.restart = Some(restart);
        Ok(kept?)
    }

    /// Saves the last state in memory of a run that has failed, and adds to the failure where it is.
    pub(super) fn save_before(&mut self, failure: Failure) -> Failure {
        let Some(restart) = &mut self.restart else { return failure };
        match restart.save_kept(&self.identity, &failure) {
            Ok(Some((path, clock))) => failure.detail(format!(
                "the state after step {} was saved to {}: bia run --resume goes on from there, also with another time \
                 step or other settings of the solver's steps",
                clock.step,
                path.display()
            )),
            Ok(None) => failure,
            Err(error) => failure.detail(format!("no checkpoint could be written: {error}")),
        }
    }
}
