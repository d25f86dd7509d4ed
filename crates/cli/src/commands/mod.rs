//! The commands, a file each.

pub(crate) mod again;
pub(crate) mod analogies;
pub(crate) mod animate;
pub(crate) mod apply;
pub(crate) mod compare;
pub(crate) mod completions;
pub(crate) mod extend;
pub(crate) mod fill;
pub(crate) mod graphcut;
pub(crate) mod hybrid;
pub(crate) mod info;
pub(crate) mod inspect;
pub(crate) mod man;
pub(crate) mod merge;
pub(crate) mod optimize;
pub(crate) mod quilt;
#[cfg(test)]
pub(crate) mod random_labels;
pub(crate) mod score;
pub(crate) mod synthesize;
pub(crate) mod tile;
pub(crate) mod transfer;
pub(crate) mod video;
