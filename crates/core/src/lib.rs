//! Domains, grids, exemplars, source maps and seeds: what every method of Selvedge shares.
#![forbid(unsafe_code)]
