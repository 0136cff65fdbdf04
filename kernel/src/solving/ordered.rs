//! Parallel work whose results are added one after the other, in a fixed order.

use rayon::prelude::*;
use std::ops::Range;

/// Items that each thread computes before they are added: enough to keep threads busy, few enough for
/// the second-level cache.
const ITEMS: usize = 6;

/// Computes items `0..count` in parallel, a batch at a time, each into a buffer, and adds the buffers
/// one after the other while the next batch is computed: sums have the same bits for every number of
/// threads. `buffers` is kept by the caller so that nothing is allocated again.
///
/// # Errors
/// The error of the first item, in their order, that fails.
pub fn in_order<B: Default + Send, E: Send>(
    count: usize,
    buffers: &mut Vec<B>,
    compute: impl Fn(usize, &mut B) -> Result<(), E> + Sync,
    mut add: impl FnMut(usize, &B) + Send,
) -> Result<(), E> {
    let threads = rayon::current_num_threads();
    let batch = if threads > 1 { ITEMS * threads } else { 1 }.min(count);
    if buffers.len() < 2 * batch {
        buffers.resize_with(2 * batch, B::default);
    }
    if threads == 1 {
        // What was just computed is still in the first cache.
        return (0..count).try_for_each(|i| {
            compute(i, &mut buffers[0])?;
            add(i, &buffers[0]);
            Ok(())
        });
    }
    let fill = |items: Range<usize>, buffers: &mut [B]| {
        let computed = buffers[..items.len()].par_iter_mut().enumerate();
        computed.map(|(i, buffer)| compute(items.start + i, buffer)).find_map_first(Result::err).map_or(Ok(()), Err)
    };
    let (mut present, mut next) = buffers.split_at_mut(batch);
    fill(0..batch, present)?;
    for first in (0..count).step_by(batch.max(1)) {
        let end = count.min(first + batch);
        let add_all = || present.iter_mut().zip(first..end).for_each(|(buffer, i)| add(i, buffer));
        let ((), filled) = rayon::join(add_all, || fill(end..count.min(end + batch), next));
        filled?;
        std::mem::swap(&mut present, &mut next);
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
