//! Integration tests: one binary, since each is a link.

mod memory;
