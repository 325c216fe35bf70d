"""Each drive at its limits, through the C interface: what comes out is a correct value or a clear error."""
