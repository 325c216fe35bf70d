//! The drives of the FMUs in use. The instances of one FMU share what never changes: variables and start values.
//!
//! It is locked when an instance is made or freed, never in between.

use crate::drives::{Fault, Plan, resource::Content};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

/// A drive with at least one instance; without instances its plan is gone, and [`clear`] removes the entry.
struct Entry {
    /// The content of the resource that the drive was made from.
    resource: Box<[u8]>,
    guid: Box<str>,
    plan: Weak<Plan>,
}

static ENTRIES: Mutex<Vec<Entry>> = Mutex::new(Vec::new());

/// No entry is ever half changed, so a panic elsewhere does no harm.
fn entries() -> MutexGuard<'static, Vec<Entry>> {
    ENTRIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The plan of the drive that a resource describes. Refuses a guid that differs from the resource's.
pub fn of(resource: &[u8], guid: &str) -> Result<Arc<Plan>, Fault> {
    let known = entries().iter().find(|e| *e.resource == *resource).and_then(|e| {
        let plan = e.plan.upgrade()?;
        Some((plan, e.guid.clone()))
    });
    if let Some((plan, own)) = known {
        compare(guid, &own)?;
        return Ok(plan);
    }
    let described = Content::from_bytes(resource)?;
    compare(guid, described.guid)?;
    let plan = described.build(crate::drives::MODELS)?.plan();
    let mut entries = entries();
    entries.retain(|e| *e.resource != *resource);
    entries.push(Entry { resource: resource.into(), guid: described.guid.into(), plan: Arc::downgrade(&plan) });
    Ok(plan)
}

fn compare(given: &str, own: &str) -> Result<(), Fault> {
    if given == own {
        Ok(())
    } else {
        Err(Fault::new(format!("`fmuGUID` is `{given}`, but this FMU has the guid `{own}`")))
    }
}

/// Forgets the drives without instances; after the last one no memory is left when the library is unloaded.
pub fn clear() {
    let mut entries = entries();
    entries.retain(|e| 0 < e.plan.strong_count());
    entries.shrink_to_fit();
}
