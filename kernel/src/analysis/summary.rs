//! The summary of a run: one JSON object of numbers by which runs are compared (`bia run --summary`).

use super::account::{cpu_total, number, peak_memory_mb};
use super::{Account, Analysis};
use crate::solving::solver::ColumnUse;
use serde_json::{Map, Value, json};
use std::time::Duration;

impl Analysis {
    /// What the scene consists of and what its run, if there was one, took and found; the caller adds how
    /// it ended. Times are in seconds, sizes in bytes; a number that is not finite is null.
    pub fn summary(&self) -> Map<String, Value> {
        let mut summary = self.scene();
        if let Some(account) = &self.account {
            self.add_run(account, &mut summary);
        }
        let results = self.results();
        summary.insert("errors".into(), results.errors.into());
        summary.insert("values".into(), results.values.into());
        summary
    }

    fn scene(&self) -> Map<String, Value> {
        let inventory = self.solver.inventory(&self.model);
        let (used, left): (Vec<&ColumnUse>, Vec<&ColumnUse>) =
            inventory.columns.iter().partition(|column| column.bytes > 0);
        let counts = inventory.counts;
        let bytes: usize = used.iter().map(|column| column.bytes).sum();
        let per_point = (counts.points > 0).then(|| bytes as f64 / counts.points as f64);
        let scene = json!({
            "cells": counts.cells, "nodes": counts.nodes, "points": counts.points, "unknowns": counts.unknowns,
            "bytes": bytes, "bytes_per_point": per_point,
            "columns": used.iter().map(|c| json!({"name": c.name, "bytes": c.bytes})).collect::<Vec<_>>(),
            "left_out": left.iter().map(|column| column.name).collect::<Vec<_>>(),
            "stages": self.solver.stages().into_iter().map(|(name, _)| name).collect::<Vec<_>>(),
            "processes": self.pipeline(),
        });
        members(scene)
    }

    fn add_run(&self, account: &Account, summary: &mut Map<String, Value>) {
        let seconds = |time: Duration| time.as_secs_f64();
        let steps = account.iterations.len();
        let [smallest, largest] = account.time_steps;
        let mean = (account.end_time - self.clock.start) / steps as f64;
        let points = summary.get("points").and_then(Value::as_f64).unwrap_or(0.0);
        let rate = points * steps as f64 / seconds(account.wall_loop);
        let energies: Map<String, Value> =
            self.solver.energies(&self.model).into_iter().map(|(name, value)| (name.into(), number(value))).collect();
        summary.extend(members(json!({
            "steps": steps,
            "end_time": number(account.end_time),
            "time_step": {"smallest": number(smallest), "largest": number(largest), "mean": number(mean)},
            "iterations": {"total": account.iterations.iter().sum::<usize>(), "largest": account.iterations.iter().max()},
            "steps_not_converged": account.not_converged.len(),
            "cpu_s": seconds(cpu_total()),
            "loop_cpu_s": seconds(account.cpu_loop),
            "wall_s": seconds(account.wall_total()),
            "loop_wall_s": seconds(account.wall_loop),
            "peak_memory_mb": peak_memory_mb(),
            "point_steps_per_s": number(rate),
            "energy": energies,
            "solver": self.solver.account(&self.model),
        })));
        if let Some(stable) = self.solver.stable_time_step(&self.model) {
            let first = self.first_stable.map_or(Value::Null, number);
            summary.insert("stable_time_step".into(), json!({"first": first, "last": number(stable)}));
        }
    }
}

/// The members of an object that was written as a literal.
fn members(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(members) => members,
        _ => Map::new(),
    }
}
