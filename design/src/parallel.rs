//! Independent pieces of work over the cores.

use crate::work;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// `work` of every item, in their order, as many at once as there are cores; `done` is told after each. They share
/// the budget of the caller.
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync, done: &(dyn Fn() + Sync)) -> Vec<R> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(items.len());
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::with_capacity(items.len()));
    let left = work::left();
    let share = || {
        while let Some((i, item)) = Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|i| Some((i, items.get(i)?))) {
            let result = work(item);
            results.lock().unwrap_or_else(PoisonError::into_inner).push((i, result));
            done();
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(|| work::taken(left, share))).collect();
        for thread in threads {
            match thread.join() {
                Ok(taken) => work::draw(taken),
                Err(panic) => std::panic::resume_unwind(panic),
            };
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_the_order_of_the_items() {
        let count = AtomicUsize::new(0);
        let items: Vec<usize> = (0..1000).collect();
        let squares = map(&items, |i| i * i, &|| {
            count.fetch_add(1, Ordering::Relaxed);
        });
        assert!(squares.iter().enumerate().all(|(i, square)| *square == i * i));
        assert_eq!((squares.len(), count.into_inner()), (1000, 1000));
        assert!(map(&[] as &[u8], |_| 0, &|| ()).is_empty());
        let drawn = |budget: f64| work::within(budget, "", &|_| (), |_| map(&items, |_| work::draw(1.0), &|| ()).len());
        assert!(drawn(1000.0) == Ok(1000) && drawn(999.0).is_err() && work::left() == f64::INFINITY);
    }
}
