//! Timings on boxes of cells, for the thresholds in `automatic`; run with `--ignored --nocapture`.

use crate::test_systems::{MixedBox, elastic_box, vector};
use crate::{BlockMatrix, BlockPattern, IterativeSettings, LinearSolver, Method, Preconditioner, solver};
use std::time::Instant;

fn milliseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e3
}

/// Reads a list of numbers from the environment.
fn numbers(name: &str, default: &[usize]) -> Vec<usize> {
    let parse = |list: String| list.split(',').filter_map(|item| item.parse().ok()).collect();
    std::env::var(name).map_or(default.to_vec(), parse)
}

/// `NODES` along an edge and `THREADS` may be given in the environment.
#[test]
#[ignore = "measures, asserts nothing"]
fn timings() {
    for threads in numbers("THREADS", &[1]) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for nodes in numbers("NODES", &[7, 10, 13, 17]) {
            println!("{threads} threads, {nodes}^3 nodes");
            pool.install(|| elastic(nodes));
        }
    }
}

fn elastic(nodes: usize) {
    for courant in [1.0, 3.0, 10.0, 100.0] {
        let mut a = elastic_box(nodes, courant);
        let mut b = vector(a.pattern.order(), 3);
        let fixed: Vec<bool> = (0..b.len()).map(|dof| courant > 10.0 && dof < 3 * nodes * nodes).collect();
        a.constrain(&fixed, &mut b);
        let mut x = vec![0.0; b.len()];
        let product = (0..5).map(|_| milliseconds(|| a.multiply(&b, &mut x))).fold(f64::INFINITY, f64::min);
        println!(" courant {courant}: product {product:.3} ms, {} blocks", a.pattern.entries());
        for kind in [Preconditioner::BlockJacobi, Preconditioner::DiagonalIncomplete, Preconditioner::Incomplete] {
            let settings = IterativeSettings { preconditioner: kind, ..IterativeSettings::new(1e-9) };
            for method in [Method::ConjugateGradient(settings.clone()), Method::BiCgStab(settings)] {
                report(&mut *solver(method), &a, &b, &mut x);
            }
        }
        if courant == 1.0 {
            let methods = [Method::Cholesky, Method::Ldlt, Method::Lu];
            for method in methods.into_iter().filter(|method| nodes < 14 || *method != Method::Lu) {
                report(&mut *solver(method), &a, &b, &mut x);
            }
        }
    }
}

fn report(solver: &mut dyn LinearSolver, a: &BlockMatrix, b: &[f64], x: &mut [f64]) {
    let first = milliseconds(|| drop(solver.solve(a, b, x)));
    let mut best = f64::INFINITY;
    let mut result = solver.solve(a, b, x);
    for _ in 0..3 {
        best = best.min(milliseconds(|| result = solver.solve(a, b, x)));
    }
    let result = result.map(|report| (report.iterations, report.residual));
    println!("  {:<85} first {first:8.2} then {best:8.2} ms  {result:?}", solver.name());
}

#[test]
#[ignore = "measures, asserts nothing"]
fn pattern() {
    let node = |i: usize, j: usize, k: usize| ((i * 17 + j) * 17 + k) as u32;
    let corners = |c: usize| {
        let (i, j, k) = (c / 256, c / 16 % 16, c % 16);
        [0, 1, 2, 3, 4, 5, 6, 7].map(|n| node(i + (n >> 2), j + (n >> 1 & 1), k + (n & 1)))
    };
    let cells: Vec<[u32; 8]> = (0..4096).map(corners).collect();
    for _ in 0..5 {
        let work = || drop(BlockPattern::from_cliques(3, 4913, cells.iter().map(|cell| &cell[..])));
        println!("pattern of 4096 hexahedra: {:.2} ms", milliseconds(work));
    }
}

/// Displacement-pressure systems of `CELLS` cells along an edge, in `DIMENSION` dimensions.
#[test]
#[ignore = "measures, asserts nothing"]
fn mixed() {
    for dimension in numbers("DIMENSION", &[2, 3]) {
        for cells in numbers("CELLS", if dimension == 2 { &[32, 100] } else { &[8, 16] }) {
            for (bulk, inertia, skew) in [1.0, 1e3, f64::INFINITY]
                .into_iter()
                .flat_map(|bulk| [(bulk, 0.0, 0.0), (bulk, 0.0, 0.1), (bulk, 1.0, 0.1)])
            {
                // Density over the square of the step, in units of shear modulus over the square of the cell.
                let inertia = inertia * (cells * cells) as f64;
                let (a, b) = MixedBox { bulk, inertia, skew, ..MixedBox::new(dimension, cells) }.system();
                println!(" {dimension}D, {} unknowns, bulk {bulk}, inertia {inertia}, skew {skew}", b.len());
                let mut x = vec![0.0; b.len()];
                let preconditioner = Preconditioner::Incomplete;
                let settings = IterativeSettings { preconditioner, ..IterativeSettings::new(1e-9) };
                let direct = if skew == 0.0 { Method::Ldlt } else { Method::Lu };
                for method in [Method::Gmres(settings), direct] {
                    report(&mut *solver(method), &a, &b, &mut x);
                }
            }
        }
    }
}
