//! The program from outside: exit codes, streams, files, options in files, signals, and samples bit for bit.
#![forbid(unsafe_code)]

mod again;
mod analogies;
mod animate;
mod blending;
mod config;
mod course;
mod degenerate;
mod exit_codes;
mod ffmpeg;
mod files;
mod fill;
mod graphcut;
mod hybrid;
mod merge;
mod merge_clips;
mod merge_clips_given;
mod merge_clips_seams;
mod optimize;
mod order;
mod over;
mod planes;
mod program;
mod safety;
mod samples;
mod score;
#[cfg(unix)]
mod signals;
mod streams;
mod synthesize;
mod transfer;
mod turns;
mod video;
mod video_begun;
mod video_read_again;
mod video_told;
mod video_windows;
mod words;
