//! Parallel work whose results are added one after the other, in a fixed order.

use rayon::prelude::*;

/// Items computed together before they are added: enough to keep threads busy, few enough for the
/// second-level cache.
const BATCH: usize = 64;

/// Computes items `0..count` in parallel, a batch at a time, each into a buffer, and adds the
/// buffers one after the other: sums have the same bits for every number of threads. `buffers`
/// is kept by the caller so that nothing is allocated again.
///
/// # Errors
/// The error of the first item, in their order, that fails.
pub fn in_order<B: Default + Send, E: Send>(
    count: usize,
    buffers: &mut Vec<B>,
    compute: impl Fn(usize, &mut B) -> Result<(), E> + Sync,
    mut add: impl FnMut(usize, &B),
) -> Result<(), E> {
    if buffers.len() < BATCH.min(count) {
        buffers.resize_with(BATCH.min(count), B::default);
    }
    for first in (0..count).step_by(BATCH) {
        let batch = &mut buffers[..BATCH.min(count - first)];
        let compute_one = |(i, buffer): (usize, &mut B)| compute(first + i, buffer);
        if rayon::current_num_threads() > 1 {
            let results: Vec<Result<(), E>> = batch.par_iter_mut().enumerate().map(compute_one).collect();
            results.into_iter().collect::<Result<(), E>>()?;
        } else {
            batch.iter_mut().enumerate().try_for_each(compute_one)?;
        }
        for (i, buffer) in batch.iter().enumerate() {
            add(first + i, buffer);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_added_in_order_for_any_number_of_threads() {
        for threads in [1, 2, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let seen = pool.install(|| {
                let (mut buffers, mut seen) = (Vec::new(), Vec::new());
                let compute = |i: usize, b: &mut usize| {
                    *b = i * i;
                    Ok::<(), ()>(())
                };
                in_order(200, &mut buffers, compute, |i, b| seen.push((i, *b))).unwrap();
                seen
            });
            assert!(seen.iter().enumerate().all(|(i, &item)| item == (i, i * i)) && seen.len() == 200);
        }
    }

    #[test]
    fn the_first_failing_item_is_named() {
        let failed =
            in_order(100, &mut Vec::<()>::new(), |i, ()| if i % 30 == 29 { Err(i) } else { Ok(()) }, |_, ()| {});
        assert_eq!(failed, Err(29));
    }
}
