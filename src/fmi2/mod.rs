//! The FMI 2.0 Co-Simulation interface.
