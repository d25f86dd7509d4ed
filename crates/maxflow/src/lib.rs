//! s-t minimum cuts on 2-D and 3-D grids and general sparse graphs, in integers.
#![forbid(unsafe_code)]
