//! Tests of all drives.

mod survey;
