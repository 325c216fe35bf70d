//! Saved FMU states: the value behind an `fmi2FMUstate`, and its bytes.
//!
//! Bytes: magic (8) · format version (4) · fingerprint of the guid (8) · length of the content (8) · content · CRC-32 of everything
//! before it (4); integers little-endian. The content is the clock and the drive in postcard's encoding.

use super::call_sequence::Mode;
use crate::drives::{AnyDrive, Fault, Snapshot};
use serde::{Deserialize, Serialize};

/// The mode and the times of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Clock {
    /// The state of the call sequence.
    pub mode: Mode,
    /// The communication point (s).
    pub time: f64,
    /// The stop time (s); without one, a number that no step reaches.
    pub stop: f64,
}

/// A saved state. An importer holds its address, and one address looks like another. The first two words, of fixed layout,
/// therefore show whether this is a living state of this very FMU before anything else is read.
#[repr(C)]
pub struct SavedState {
    /// [`ALIVE`] until the state is freed.
    pub mark: u64,
    /// The fingerprint of the guid.
    pub fingerprint: u64,
    /// The instance.
    pub clock: Clock,
    /// The drive.
    pub drive: Snapshot,
}

/// The mark of a living state.
pub const ALIVE: u64 = u64::from_le_bytes(*b"camstate");

impl SavedState {
    /// A living state.
    pub fn new(fingerprint: u64, clock: Clock, drive: Snapshot) -> Self {
        SavedState { mark: ALIVE, fingerprint, clock, drive }
    }
}

/// Distinguishes FMUs by their guid (FNV-1a of 64 bits, Fowler, Noll and Vo).
pub fn fingerprint(guid: &str) -> u64 {
    guid.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

const MAGIC: &[u8; 8] = b"camdrive";
/// Raise this when the encoding of any drive's state changes without a change of its guid.
const VERSION: u32 = 5;
const HEADER: usize = 8 + 4 + 8 + 8;
const CHECKSUM: usize = 4;

/// The bytes of a state.
pub fn to_bytes(state: &SavedState) -> Result<Vec<u8>, Fault> {
    let cannot = || Fault::new("the state cannot be serialised");
    let mut content = postcard::to_stdvec(&state.clock).map_err(|_| cannot())?;
    content.extend(state.drive.serialize().ok_or_else(cannot)?);

    let mut bytes = Vec::with_capacity(HEADER + content.len() + CHECKSUM);
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(state.fingerprint.to_le_bytes());
    bytes.extend((content.len() as u64).to_le_bytes());
    bytes.extend(content);
    bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
    Ok(bytes)
}

/// A state from its bytes; refuses damaged ones and another FMU's.
pub fn from_bytes(bytes: &[u8], fingerprint: u64, drive: &AnyDrive) -> Result<SavedState, Fault> {
    let refuse = |reason: &str| Err(Fault::new(format!("the serialised state {reason}")));
    let Some((body, checksum)) = bytes.split_last_chunk::<CHECKSUM>() else { return refuse("is cut off") };
    let Some((magic, rest)) = body.split_first_chunk::<8>() else { return refuse("is cut off") };
    if magic != MAGIC {
        return refuse("was not made by this tool");
    }
    let Some((version, rest)) = rest.split_first_chunk::<4>() else { return refuse("is cut off") };
    if u32::from_le_bytes(*version) != VERSION {
        return Err(Fault::new(format!(
            "the serialised state has the format version {}; this library reads version {VERSION}",
            u32::from_le_bytes(*version)
        )));
    }
    let Some((maker, rest)) = rest.split_first_chunk::<8>() else { return refuse("is cut off") };
    if u64::from_le_bytes(*maker) != fingerprint {
        return refuse("belongs to an FMU with another guid");
    }
    let Some((length, content)) = rest.split_first_chunk::<8>() else { return refuse("is cut off") };
    if u64::from_le_bytes(*length) != content.len() as u64 {
        return Err(Fault::new(format!(
            "the serialised state holds {} bytes of content where its header announces {}",
            content.len(),
            u64::from_le_bytes(*length)
        )));
    }
    if u32::from_le_bytes(*checksum) != crc32fast::hash(body) {
        return refuse("is damaged: its checksum is wrong");
    }
    let (clock, content): (Clock, _) = postcard::take_from_bytes(content)
        .map_err(|e| Fault::new(format!("the serialised state cannot be read: {e}")))?;
    if !clock.time.is_finite() || clock.stop.is_nan() {
        return refuse("has no time");
    }
    Ok(SavedState::new(fingerprint, clock, drive.deserialize(content)?))
}
