//! Strokes of a brush over two pictures or clips: each holds a block of nodes on the side where they were not, or lets
//! the block before go.

use selvedge_maxflow::Side;

use super::Instance;
use super::texture::Draw;

/// What a stroke changes: nodes, and the side that they are held on from then on, if any.
pub(crate) type Stroke = (Vec<usize>, Option<Side>);

/// Makes strokes, in a given order.
pub(crate) struct Brush {
    draw: Draw,
    /// Lengths of the block.
    block: Vec<usize>,
    number: usize,
    last: Vec<usize>,
}

impl Brush {
    /// A block of an eighth by a fiftieth of a picture's sides; of a clip's frames one.
    pub(crate) fn over(instance: &Instance) -> Self {
        let [.., rows, columns] = instance.shape[..] else { panic!("two or three axes") };
        let mut block = vec![1; instance.shape.len() - 2];
        block.extend([rows / 50 + 1, columns / 8 + 1]);
        Self { draw: Draw(1), block, number: 0, last: Vec::new() }
    }

    /// The next stroke over what shows: every fourth takes the one before back.
    pub(crate) fn next(&mut self, instance: &Instance, sides: impl Fn(usize) -> Side) -> Stroke {
        self.number += 1;
        if self.number.is_multiple_of(4) {
            return (std::mem::take(&mut self.last), None);
        }
        let axes = 0..instance.shape.len();
        let stride = |a: usize| instance.shape[a + 1..].iter().product::<usize>();
        let first: Vec<usize> = axes.clone().map(|a| self.draw.below(instance.shape[a] - self.block[a] + 1)).collect();
        let count: usize = self.block.iter().product();
        let place = |k: usize| -> usize {
            let within = |a: usize| k / self.block[a + 1..].iter().product::<usize>() % self.block[a];
            axes.clone().map(|a| (first[a] + within(a)) * stride(a)).sum()
        };
        let given = |v: &usize| instance.pins.iter().any(|(p, _)| p == v);
        self.last = (0..count).map(place).filter(|v| !given(v)).collect();
        let side = self
            .last
            .first()
            .map_or(Side::Source, |&v| if sides(v) == Side::Source { Side::Sink } else { Side::Source });
        (self.last.clone(), Some(side))
    }
}
