//! The search from outside: against its slow definition, within its memory. One binary: each is a link.
#![forbid(unsafe_code)]

mod choice;
mod largest;
mod memory;
mod nearest;
mod oracle;
mod support;
