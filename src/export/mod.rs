//! From a validated scene to an FMU: description, documentation, archive.
