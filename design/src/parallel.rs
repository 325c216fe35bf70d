//! Independent pieces of work over the cores.

use crate::work;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// `work` of every item, in their order, as many at once as there are cores; `done` is called after each. They share the budget
/// of the caller.
pub fn map<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync, done: &(dyn Fn() + Sync)) -> Vec<R> {
    let results: Vec<Mutex<Option<R>>> = items.iter().map(|_| Mutex::new(None)).collect();
    each(items.len(), &|i| {
        let result = work(&items[i]);
        *results[i].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
        done();
    });
    results.into_iter().filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// `work` of every number below `count`. (Not generic: it is compiled once.)
fn each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(count);
    let next = AtomicUsize::new(0);
    let left = work::left();
    let share = || {
        while let Some(i) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|i| *i < count) {
            work(i);
        }
    };
    if cores < 2 {
        // A browser's thread starts no others.
        return share();
    }
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(|| work::taken(left, share))).collect();
        for thread in threads {
            match thread.join() {
                Ok(taken) => work::draw(taken),
                Err(panic) => std::panic::resume_unwind(panic),
            };
        }
    });
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
