//! Timings on an elastic block of 17^3 nodes; run with `--ignored --nocapture`.

use crate::test_systems::{elastic_box, vector};
use crate::{IterativeSettings, LinearSolver, Method, Preconditioner, solver};
use std::time::Instant;

fn milliseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

#[test]
#[ignore = "measures, asserts nothing"]
fn timings() {
    let threads: usize = std::env::var("THREADS").ok().and_then(|v| v.parse().ok()).unwrap_or(1);
    let nodes: Vec<usize> =
        std::env::var("NODES").map_or(vec![17], |v| v.split(',').map(|v| v.parse().unwrap()).collect());
    let direct = std::env::var("DIRECT").is_ok();
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
        for nodes in nodes {
            for courant in [1.0, 3.0, 10.0, 30.0, 100.0] {
                let mut a = elastic_box(nodes, courant);
                let mut b = vector(a.pattern.order(), 3);
                if courant > 29.0 {
                    let mask: Vec<bool> = (0..b.len()).map(|i| i < 3 * nodes * nodes).collect();
                    a.constrain(&mask, &mut b);
                }
                let mut x = vec![0.0; b.len()];
                let product = (0..5).map(|_| milliseconds(|| a.multiply(&b, &mut x))).fold(1e9, f64::min);
                println!("nodes {nodes} courant {courant}: product {product:.3} ms, {} blocks", a.pattern.entries());
                for preconditioner in
                    [Preconditioner::BlockJacobi, Preconditioner::DiagonalIncomplete, Preconditioner::Incomplete]
                {
                    let settings = IterativeSettings { preconditioner, ..IterativeSettings::new(1e-9) };
                    for method in [Method::ConjugateGradient(settings.clone()), Method::BiCgStab(settings)] {
                        report(&mut *solver(method), &a, &b, &mut x);
                    }
                }
                if direct && (courant == 1.0) {
                    report(&mut *solver(Method::Cholesky), &a, &b, &mut x);
                    report(&mut *solver(Method::Ldlt), &a, &b, &mut x);
                    if nodes < 14 {
                        report(&mut *solver(Method::Lu), &a, &b, &mut x);
                    }
                }
            }
        }
    });
}

fn report(solver: &mut dyn LinearSolver, a: &crate::BlockMatrix, b: &[f64], x: &mut [f64]) {
    let first = milliseconds(|| drop(solver.solve(a, b, x)));
    let mut best = f64::INFINITY;
    let mut result = None;
    for _ in 0..3 {
        best = best.min(milliseconds(|| result = Some(solver.solve(a, b, x))));
    }
    println!(
        "  {:<75} first {first:8.2} next {best:8.2} ms  {:?}",
        solver.name(),
        result.unwrap().map(|r| (r.iterations, r.residual))
    );
}
