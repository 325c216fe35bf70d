//! Scene files: TOML → validated SI parameters.
