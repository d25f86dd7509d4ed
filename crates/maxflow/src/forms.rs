//! The forms in which an answer is asked for, written once for grids and for graphs in lists: at once, until the caller
//! says stop, and into memory that was used before.

/// `solve`, `solve_until` and `solve_into`, over the graph's own `find`. What is told of `solve` is the graph's.
macro_rules! solves {
    ($(#[$told:meta])*) => {
        $(#[$told])*
        ///
        /// # Errors
        ///
        /// [`MaxflowError::OutOfMemory`]; the flow found so far is kept.
        pub fn solve(&mut self) -> Result<MinCut> {
            self.solve_until(&|| false)
        }

        /// [`solve`](Self::solve), unless `cancelled`, which is asked now and then.
        ///
        /// # Errors
        ///
        /// As [`solve`](Self::solve), and [`MaxflowError::Cancelled`]; the flow found so far is kept.
        pub fn solve_until(&mut self, cancelled: &dyn Fn() -> bool) -> Result<MinCut> {
            let mut cut = MinCut::default();
            self.solve_into(&mut cut, cancelled)?;
            Ok(cut)
        }

        /// [`solve_until`](Self::solve_until) into a cut whose memory is used again.
        ///
        /// # Errors
        ///
        /// As [`solve_until`](Self::solve_until); `cut` is then unspecified.
        pub fn solve_into(&mut self, cut: &mut MinCut, cancelled: &dyn Fn() -> bool) -> Result<()> {
            self.find(cut, cancelled)
        }
    };
}

/// `value` and the forms of `minimize`, over an energy's `graph` and `books`.
macro_rules! minimizes {
    () => {
        /// The energy, of the terms as they were given, of a labelling: `true` for label 0.
        ///
        /// # Errors
        ///
        /// [`MaxflowError::LabellingSize`].
        pub fn value(&self, is_zero: &[bool]) -> Result<i64> {
            Ok(self.graph.capacity_of(is_zero)? + self.books.beside(is_zero))
        }

        /// A labelling of least energy; of several, the one with the most labels 1.
        ///
        /// # Errors
        ///
        /// [`MaxflowError::OutOfMemory`].
        pub fn minimize(&mut self) -> Result<Minimum> {
            self.minimize_until(&|| false)
        }

        /// [`minimize`](Self::minimize), unless `cancelled`, which is asked now and then.
        ///
        /// # Errors
        ///
        /// As [`minimize`](Self::minimize), and [`MaxflowError::Cancelled`].
        pub fn minimize_until(&mut self, cancelled: &dyn Fn() -> bool) -> Result<Minimum> {
            let mut minimum = Minimum::default();
            self.minimize_into(&mut minimum, cancelled)?;
            Ok(minimum)
        }

        /// [`minimize_until`](Self::minimize_until) into a result whose memory is used again.
        ///
        /// # Errors
        ///
        /// As [`minimize_until`](Self::minimize_until); `minimum` is then unspecified.
        pub fn minimize_into(&mut self, minimum: &mut Minimum, cancelled: &dyn Fn() -> bool) -> Result<()> {
            let all_zero = self.graph.capacity_of_all_source();
            self.graph.solve_into(&mut minimum.cut, cancelled)?;
            self.books.complete(minimum, all_zero);
            Ok(())
        }
    };
}

pub(crate) use {minimizes, solves};
