//! What can go wrong, with the numbers.

/// Everything this crate can refuse, carrying the numbers that broke the rule.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MaxflowError {
    /// A grid with a zero side, more than three axes, or more nodes than 32-bit indices can number.
    #[error("a grid of shape {shape:?} is not supported: 1 to 3 axes, each side at least 1, at most {max} nodes")]
    Shape {
        /// The shape asked for, slowest axis first.
        shape: Vec<usize>,
        /// The largest number of nodes.
        max: usize,
    },
    /// A graph of any form with more nodes or arcs than 32-bit indices can number.
    #[error("{nodes} nodes and {arcs} arcs are too many: at most {max} of each are supported")]
    TooLarge {
        /// Number of nodes.
        nodes: usize,
        /// Number of arcs.
        arcs: usize,
        /// The largest number of either.
        max: usize,
    },
    /// The name of an arc of another graph.
    #[error("arc {arc} does not exist: the graph has {arcs} arcs")]
    NoSuchArc {
        /// Number of the arc.
        arc: usize,
        /// Number of arcs.
        arcs: usize,
    },
    /// An arc's name was given to a graph that it is not of. Noticed in debug builds; elsewhere only as
    /// [`NoSuchArc`](Self::NoSuchArc), if at all.
    #[error("arc {arc} is one of another graph")]
    ForeignArc {
        /// Number of the arc.
        arc: usize,
    },
    /// A node index beyond the graph.
    #[error("node {node} is out of range: the graph has {len} nodes")]
    NodeOutOfRange {
        /// The index given.
        node: usize,
        /// Number of nodes.
        len: usize,
    },
    /// A link that would leave the grid, or along an axis or diagonal that it does not have.
    #[error("node {node} has no neighbour along {along}")]
    NoNeighbour {
        /// The node the link starts from.
        node: usize,
        /// The axis or diagonal asked for.
        along: String,
    },
    /// A negative capacity, or a change that takes back more than was given.
    #[error("capacity {value} at node {node} is negative")]
    NegativeCapacity {
        /// The node (for an arc: its tail).
        node: usize,
        /// The value that is too small.
        value: i64,
    },
    /// A capacity, or a sum of capacities at one place, beyond the documented headroom.
    #[error("capacity {value} at node {node} exceeds the limit of {max}")]
    CapacityTooLarge {
        /// The node (for an arc: its tail).
        node: usize,
        /// The value, or the sum, that is too large.
        value: i64,
        /// The limit.
        max: i64,
    },
    /// A floating-point cost that is NaN, negative, infinite, or too large after scaling.
    #[error("cost {cost} at scale {scale} is not a capacity between 0 and {max}")]
    Cost {
        /// The cost given.
        cost: f64,
        /// The scale it is multiplied by.
        scale: f64,
        /// The largest capacity.
        max: i64,
    },
    /// A node was masked after capacities or pins were set; masks belong to the shape of the graph and come first.
    #[error("node {node} cannot be masked any more: masks come before links, terminals, pins and solves")]
    MaskTooLate {
        /// The node.
        node: usize,
    },
    /// A cut or a labelling of another size than the graph.
    #[error("a labelling of {given} nodes does not fit a graph of {len}")]
    LabellingSize {
        /// Number of labels given.
        given: usize,
        /// Number of nodes.
        len: usize,
    },
    /// Not one value for each node.
    #[error("{given} values do not fit a graph of {len} nodes")]
    Count {
        /// Number of values given.
        given: usize,
        /// Number of nodes.
        len: usize,
    },
    /// The flow of a graph that was not solved since it was changed.
    #[error("there is no flow to ask for: the graph is not solved")]
    NotSolved,
    /// A DIMACS file that cannot be read.
    #[error("line {line}: {reason}")]
    Dimacs {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// Memory for the graph could not be had.
    #[error("no memory for a graph of {nodes} nodes and {links} links")]
    OutOfMemory {
        /// Number of nodes.
        nodes: usize,
        /// Number of links (for a grid: of places for them).
        links: usize,
    },
    /// The caller's `cancelled` said so. The graph keeps the flow found so far: the next solve goes on from there.
    #[error("cancelled")]
    Cancelled,
}

/// Who can mend an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An argument is wrong by itself.
    Option,
    /// The data are wrong.
    Input,
    /// Not enough memory.
    Memory,
    /// The caller asked to stop.
    Cancelled,
    /// A defect of this crate.
    Internal,
}

impl MaxflowError {
    /// What to do about it.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::Shape { .. } => "use one to three axes, none of them empty",
            Self::TooLarge { .. } => "solve it in parts",
            Self::NoSuchArc { .. } | Self::ForeignArc { .. } => {
                "use a name that this graph gave: from `arc`, `arc_id` or `arc_ids`"
            }
            Self::NodeOutOfRange { .. } => "count nodes from 0",
            Self::NoNeighbour { .. } => {
                "link along the axes and diagonals that the grid was made with, inside of it; of many at once, give 0 at the end of an open axis"
            }
            Self::NegativeCapacity { .. } => "give capacities of at least 0, and take back no more than there is",
            Self::CapacityTooLarge { .. } => "scale all capacities down alike",
            Self::Cost { cost, .. } if !(0.0..f64::INFINITY).contains(cost) => {
                "give a cost of at least 0 that is finite"
            }
            Self::Cost { scale, .. } if scale.is_nan() || *scale <= 0.0 => "give a scale above 0",
            Self::Cost { .. } => "scale all costs down alike",
            Self::MaskTooLate { .. } => "mask nodes first",
            Self::LabellingSize { .. } | Self::Count { .. } => "give one value a node",
            Self::NotSolved => "solve it first",
            Self::Dimacs { .. } => "mend that line",
            Self::OutOfMemory { .. } => "solve a smaller graph, or allow more memory",
            Self::Cancelled => "solve again to go on",
        }
    }

    /// Who can mend it.
    pub fn kind(&self) -> ErrorKind {
        match self {
            Self::OutOfMemory { .. } => ErrorKind::Memory,
            Self::Cancelled => ErrorKind::Cancelled,
            Self::Shape { .. } | Self::TooLarge { .. } | Self::MaskTooLate { .. } => ErrorKind::Option,
            _ => ErrorKind::Input,
        }
    }
}

/// Shorthand for this crate's results.
pub type Result<T, E = MaxflowError> = std::result::Result<T, E>;

/// A vector of `len` copies of a value, or [`MaxflowError::OutOfMemory`] in the name of the graph.
pub(crate) fn filled<T: Clone>(value: T, len: usize, nodes: usize, links: usize) -> Result<Vec<T>> {
    let mut values = Vec::new();
    if refill(&mut values, value, len) { Ok(values) } else { Err(MaxflowError::OutOfMemory { nodes, links }) }
}

/// Makes a vector `len` copies of a value. Returns whether there was memory.
#[must_use]
pub(crate) fn refill<T: Clone>(values: &mut Vec<T>, value: T, len: usize) -> bool {
    values.clear();
    let fits = values.try_reserve_exact(len).is_ok();
    if fits {
        values.resize(len, value);
    }
    fits
}

/// Adds a value to a vector. Returns whether there was memory.
#[inline]
#[must_use]
pub(crate) fn push<T>(values: &mut Vec<T>, value: T) -> bool {
    let fits = values.len() < values.capacity() || values.try_reserve(1).is_ok();
    if fits {
        values.push(value);
    }
    fits
}
