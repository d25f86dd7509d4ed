//! Files from outside: what is written is read, what is broken is refused. One binary: each is a link.
#![forbid(unsafe_code)]

mod bad_files;
mod bombs;
mod bytes;
mod clips;
mod common;
mod containers;
mod conversions;
mod corpus;
mod damage;
mod foreign;
mod jpeg;
mod maps;
mod round_trips;
mod tags;
mod tiff;
