//! What may change falls into pieces, which know nothing of each other: what is between them is held.

use selvedge_core::{Domain, Error, Window, reserve, try_vec};

/// Connected places of a domain, in their box.
pub(crate) struct Piece<const D: usize> {
    /// The places' box, and along axes that end at one side alone the samples that hold it at the other.
    pub(crate) window: Window<D>,
    /// Axes along which samples beyond both ends of the box are held.
    pub(crate) tied: [bool; D],
    /// Which places of the box are the piece's; `None` for all.
    pub(crate) free: Option<Vec<bool>>,
}

/// Pieces, in the order of their first places.
pub(crate) struct Pieces<const D: usize> {
    domain: Domain<D>,
    /// Places of no piece so far.
    left: Vec<Mark>,
    next: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Mark {
    Held,
    Left,
    /// Of the piece that is found just now.
    Taken,
}

impl<const D: usize> Piece<D> {
    /// All of a domain.
    pub(crate) fn all(domain: Domain<D>) -> Self {
        Self { window: Window::all(domain), tied: [false; D], free: None }
    }

    /// The box by itself.
    pub(crate) fn domain(&self, whole: Domain<D>) -> Domain<D> {
        let goes_around = |a: usize| whole.periodic[a] && !self.tied[a];
        Domain { shape: self.window.shape, periodic: std::array::from_fn(goes_around) }
    }

    /// Where a position of the whole domain stands in the box.
    pub(crate) fn place(&self, whole: Domain<D>, at: [u32; D]) -> Option<usize> {
        let unwrapped = self.window.unwrapped(whole, at);
        let at: [i32; D] = std::array::from_fn(|a| unwrapped[a] - self.window.start[a]);
        let is_inside = (0..D).all(|a| 0 <= at[a] && at[a] < self.window.shape[a] as i32);
        is_inside.then(|| self.window.local().index(at.map(|p| p as u32)))
    }
}

impl<const D: usize> Pieces<D> {
    pub(crate) fn new(domain: Domain<D>, free: Vec<bool>) -> Self {
        let left = free.into_iter().map(|free| if free { Mark::Left } else { Mark::Held }).collect();
        Self { domain, left, next: 0 }
    }

    /// The next piece.
    ///
    /// Time: for all pieces together that of going over the domain, and over their boxes.
    pub(crate) fn next(&mut self) -> Result<Option<Piece<D>>, Error> {
        let Some(ahead) = self.left[self.next..].iter().position(|mark| *mark == Mark::Left) else { return Ok(None) };
        self.next += ahead;
        let (around, domain) = (self.take(self.next)?, self.domain);
        let ends_inside = |a: usize| [0 < around.start[a], around.end(a) < domain.shape[a] as i32];
        let is_tied = |a: usize| {
            if domain.periodic[a] { around.shape[a] < domain.shape[a] } else { ends_inside(a) == [true; 2] }
        };
        let tied: [bool; D] = std::array::from_fn(is_tied);
        let is_beside = |a: usize, end: usize| !domain.periodic[a] && !tied[a] && ends_inside(a)[end];
        let beside = |end: usize| std::array::from_fn(|a| u32::from(is_beside(a, end)));
        let window = around.grown(domain, beside(0), beside(1));
        let mut free = try_vec(window.len(), false)?;
        for (free, place) in free.iter_mut().zip(window.places(domain).flatten()) {
            if self.left[place] == Mark::Taken {
                (*free, self.left[place]) = (true, Mark::Held);
            }
        }
        Ok(Some(Piece { window, tied, free: free.contains(&false).then_some(free) }))
    }

    /// Takes the piece that a place belongs to; answers with the box around it.
    fn take(&mut self, first: usize) -> Result<Window<D>, Error> {
        self.left[first] = Mark::Taken;
        let first = self.domain.position(first).map(|p| p as i32);
        let (mut low, mut high, mut front, mut beyond) = (first, first, vec![first], Vec::new());
        // Positions are not wrapped, so that a piece over the border has a small box. One that goes all the way around
        // meets itself a whole side away.
        while !front.is_empty() {
            for at in front.drain(..) {
                low = std::array::from_fn(|a| low[a].min(at[a]));
                high = std::array::from_fn(|a| high[a].max(at[a]));
                for (axis, by) in (0..D).flat_map(|axis| [(axis, 1), (axis, -1)]) {
                    let mut next = at;
                    next[axis] += by;
                    let place = self.domain.step([0; D], next).map(|next| self.domain.index(next));
                    if let Some(place) = place.filter(|&place| self.left[place] == Mark::Left) {
                        self.left[place] = Mark::Taken;
                        reserve(&mut beyond, 1)?;
                        beyond.push(next);
                    }
                }
            }
            std::mem::swap(&mut front, &mut beyond);
        }
        let side = |a: usize| (high[a] - low[a] + 1) as u32;
        let is_whole = |a: usize| self.domain.shape[a] <= side(a);
        Ok(Window {
            start: std::array::from_fn(|a| if is_whole(a) { 0 } else { low[a] }),
            shape: std::array::from_fn(|a| side(a).min(self.domain.shape[a])),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_core::Seed;

    #[test]
    fn every_place_is_in_one_piece_and_all_around_it_is_held() {
        let mut rng = Seed(1).rng();
        for round in 0..500 {
            let shape = [1 + rng.below(6), 1 + rng.below(8)];
            let domain = Domain { shape, periodic: [round % 2 == 0, round % 3 == 0] };
            let odds = 2 + rng.below(4);
            let free: Vec<bool> = (0..domain.len()).map(|_| rng.below(odds) != 0).collect();
            let mut seen = vec![0; domain.len()];
            let mut pieces = Pieces::new(domain, free.clone());
            while let Some(piece) = pieces.next().unwrap() {
                let of_piece = |at| piece.place(domain, at).is_some_and(|i| piece.free.as_ref().is_none_or(|f| f[i]));
                let own = piece.domain(domain);
                for at in domain.positions() {
                    let Some(i) = piece.place(domain, at).filter(|_| of_piece(at)) else { continue };
                    assert_eq!(piece.window.position(domain, own.position(i)), Some(at));
                    seen[domain.index(at)] += 1;
                    for (axis, by) in [(0, 1), (0, -1), (1, 1), (1, -1)] {
                        let step = std::array::from_fn(|a| if a == axis { by } else { 0 });
                        let Some(next) = domain.step(at, step) else { continue };
                        assert_eq!(of_piece(next), free[domain.index(next)]);
                        // What the box has no place for is beyond a tied end.
                        let beside = own.step(own.position(i), step).map(|at| own.index(at));
                        assert!(beside.is_some() || piece.tied[axis], "{domain:?} {:?}", piece.window);
                        assert!(beside.is_none() || beside == piece.place(domain, next));
                    }
                }
            }
            assert!(seen.iter().zip(&free).all(|(seen, free)| *seen == usize::from(*free)));
        }
    }

    #[test]
    fn pieces_have_small_boxes_also_over_a_border() {
        let drawn = b"#...##....##\
                      ..#.#...#...\
                      ..#.....#...";
        let domain = Domain { shape: [3, 12], periodic: [false, true] };
        let mut pieces = Pieces::new(domain, drawn.iter().map(|b| *b == b'#').collect());
        let mut next = || pieces.next().unwrap().map(|p| (p.window.start, p.window.shape, p.tied, p.free.is_none()));
        // Upper border and what holds it below.
        assert_eq!(next(), Some(([0, -2], [2, 3], [false, true], false)));
        assert_eq!(next(), Some(([0, 4], [3, 2], [false, true], false)));
        assert_eq!(next(), Some(([0, 2], [3, 1], [false, true], false)));
        assert_eq!(next(), Some(([0, 8], [3, 1], [false, true], false)));
        assert_eq!(next(), None);
        let mut whole = Pieces::new(domain, vec![true; 36]);
        let whole = whole.next().unwrap().unwrap();
        assert_eq!((whole.window, whole.tied, whole.free), (Window::all(domain), [false; 2], None));
    }
}
