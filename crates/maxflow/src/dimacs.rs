//! The DIMACS text format for maximum-flow problems: other people's instances.
//!
//! ```text
//! c a comment
//! p max NODES ARCS
//! n SOURCE s
//! n SINK t
//! a TAIL HEAD CAPACITY
//! ```
//!
//! Nodes are numbered from 1 in the file and from 0 here.
//!
//! ```
//! use selvedge_maxflow::dimacs::Problem;
//!
//! let text = "p max 3 2\nn 1 s\nn 3 t\na 1 2 5\na 2 3 4\n";
//! let problem = Problem::read(text.as_bytes())?;
//! let cut = problem.graph()?.solve()?;
//! assert_eq!((cut.flow, problem.source_side_len(&cut)), (4, 1));
//! let mut written = Vec::new();
//! problem.write(&mut written).unwrap();
//! assert_eq!(written, text.as_bytes());
//! # Ok::<(), selvedge_maxflow::MaxflowError>(())
//! ```

use std::io::{self, BufRead, Read, Write};

use crate::cut::{MinCut, Side};
use crate::error::{MaxflowError, Result, push};
use crate::sparse::Graph;

/// Longest line that is read: three numbers need less than a hundred bytes, and comments have room. A file without an
/// end of line must not fill the memory.
const MAX_LINE: usize = 1 << 16;
/// How many nodes without an arc are accepted. A file of a few bytes must not ask for gigabytes.
const MAX_LONE: usize = 1 << 20;

/// A maximum-flow problem between two nodes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// Number of nodes, source and sink included.
    pub nodes: usize,
    /// The source.
    pub source: usize,
    /// The sink; another node than the source.
    pub sink: usize,
    /// Tail, head and capacity of each arc.
    pub arcs: Vec<(usize, usize, i64)>,
}

impl Problem {
    /// Reads a problem.
    ///
    /// # Errors
    ///
    /// [`MaxflowError::Dimacs`] with the line that cannot be read, and why; [`MaxflowError::OutOfMemory`].
    pub fn read(mut reader: impl BufRead) -> Result<Self> {
        let (mut parser, mut line) = (Parser::default(), Vec::new());
        loop {
            parser.line += 1;
            line.clear();
            let mut limited = reader.by_ref().take(MAX_LINE as u64);
            limited.read_until(b'\n', &mut line).map_err(|e| parser.error(e.to_string()))?;
            match line.last() {
                None => return parser.finish(),
                Some(b'\n') => parser.read_line(&line)?,
                // A comment may go on for as long as it likes.
                Some(_) if line.len() == MAX_LINE && line[0] == b'c' => {
                    reader.skip_until(b'\n').map_err(|e| parser.error(e.to_string()))?;
                }
                Some(_) if line.len() == MAX_LINE => {
                    return Err(parser.error(format!("the line is longer than {MAX_LINE} bytes")));
                }
                Some(_) => parser.read_line(&line)?,
            }
        }
    }

    /// Writes the problem.
    ///
    /// # Errors
    ///
    /// Those of the writer.
    pub fn write(&self, mut writer: impl Write) -> io::Result<()> {
        writeln!(writer, "p max {} {}", self.nodes, self.arcs.len())?;
        writeln!(writer, "n {} s", self.source + 1)?;
        writeln!(writer, "n {} t", self.sink + 1)?;
        self.arcs
            .iter()
            .try_for_each(|(tail, head, capacity)| writeln!(writer, "a {} {} {capacity}", tail + 1, head + 1))
    }

    /// The problem as a graph: source and sink are pinned nodes.
    ///
    /// # Errors
    ///
    /// As [`Graph::new`] and [`Graph::arc`].
    pub fn graph(&self) -> Result<Graph> {
        let mut graph = Graph::new(self.nodes)?;
        graph.pin(self.source, Side::Source)?;
        graph.pin(self.sink, Side::Sink)?;
        for &(tail, head, capacity) in &self.arcs {
            graph.arc(tail, head, capacity, 0)?;
        }
        Ok(graph)
    }

    /// Size of the source's side of a cut of [`graph`](Self::graph), the source itself not counted.
    pub fn source_side_len(&self, cut: &MinCut) -> usize {
        cut.source_len().saturating_sub(1)
    }
}

/// What was read so far.
#[derive(Default)]
struct Parser {
    /// Number of the current line, from 1.
    line: usize,
    /// Nodes and arcs promised.
    size: Option<(usize, usize)>,
    source: Option<usize>,
    sink: Option<usize>,
    arcs: Vec<(usize, usize, i64)>,
}

impl Parser {
    fn error(&self, reason: impl Into<String>) -> MaxflowError {
        MaxflowError::Dimacs { line: self.line, reason: reason.into() }
    }

    fn read_line(&mut self, line: &[u8]) -> Result<()> {
        // Comments may be in any encoding.
        if line[0] == b'c' {
            return Ok(());
        }
        let line = str::from_utf8(line).map_err(|e| self.error(e.to_string()))?;
        // One word more than any line has.
        let mut words = [""; 5];
        let found = line.split_ascii_whitespace().take(5).zip(&mut words).map(|(word, place)| *place = word).count();
        match words[..found] {
            [] => Ok(()),
            ["p", "max", nodes, arcs] => self.read_size(nodes, arcs),
            ["n", node, end] => self.read_end(node, end),
            ["a", tail, head, capacity] => self.read_arc(tail, head, capacity),
            ["p", ..] => Err(self.error("expected `p max NODES ARCS`")),
            ["n", ..] => Err(self.error("expected `n NODE s` or `n NODE t`")),
            ["a", ..] => Err(self.error("expected `a TAIL HEAD CAPACITY`")),
            [word, ..] => Err(self.error(format!("expected a line of kind c, p, n or a, not {word:?}"))),
        }
    }

    fn read_size(&mut self, nodes: &str, arcs: &str) -> Result<()> {
        if self.size.is_some() {
            return Err(self.error("a second `p` line"));
        }
        let (nodes, arcs) = (self.number(nodes)?, self.number(arcs)?);
        if nodes > Graph::MAX_NODES || arcs > Graph::MAX_NODES {
            let max = Graph::MAX_NODES;
            return Err(self.error(format!("{nodes} nodes and {arcs} arcs: at most {max} of each are supported")));
        }
        self.size = Some((nodes, arcs));
        Ok(())
    }

    fn read_end(&mut self, node: &str, end: &str) -> Result<()> {
        let node = self.node(node)?;
        let place = match end {
            "s" => &mut self.source,
            "t" => &mut self.sink,
            _ => return Err(self.error(format!("a node is `s` or `t`, not {end:?}"))),
        };
        if place.replace(node).is_some() {
            return Err(self.error(format!("a second `n` line for {end:?}")));
        }
        Ok(())
    }

    fn read_arc(&mut self, tail: &str, head: &str, capacity: &str) -> Result<()> {
        let (tail, head) = (self.node(tail)?, self.node(head)?);
        let value: i64 = match capacity.parse() {
            Ok(value) if value >= 0 => value,
            _ => return Err(self.error(format!("a capacity is an integer from 0 to {}, not {capacity:?}", i64::MAX))),
        };
        let (nodes, arcs) = self.size.unwrap_or_default();
        if self.arcs.len() == arcs {
            return Err(self.error(format!("more than the {arcs} arcs that the `p` line tells of")));
        }
        if push(&mut self.arcs, (tail, head, value)) {
            Ok(())
        } else {
            Err(MaxflowError::OutOfMemory { nodes, links: arcs })
        }
    }

    fn number(&self, word: &str) -> Result<usize> {
        word.parse().map_err(|_| self.error(format!("expected a number, not {word:?}")))
    }

    fn node(&self, word: &str) -> Result<usize> {
        let Some((nodes, _)) = self.size else { return Err(self.error("the `p` line has to come first")) };
        match self.number(word)? {
            node if (1..=nodes).contains(&node) => Ok(node - 1),
            node => Err(self.error(format!("node {node} is not in 1..={nodes}"))),
        }
    }

    fn finish(self) -> Result<Problem> {
        let Some((nodes, arcs)) = self.size else { return Err(self.error("the file ends without a `p max` line")) };
        if nodes > MAX_LONE + 2 * self.arcs.len() {
            return Err(self.error(format!("{nodes} nodes for {} arcs: nearly all stand alone", self.arcs.len())));
        }
        if self.arcs.len() != arcs {
            return Err(self.error(format!("the file ends after {} of {arcs} arcs", self.arcs.len())));
        }
        match (self.source, self.sink) {
            (Some(source), Some(sink)) if source != sink => Ok(Problem { nodes, source, sink, arcs: self.arcs }),
            (Some(_), Some(_)) => Err(self.error("source and sink are the same node")),
            _ => Err(self.error("the file does not name both source and sink")),
        }
    }
}
