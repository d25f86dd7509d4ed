//! Inside, everything has three axes: a picture is a clip of one frame. So the engines are compiled once.

/// Samples along t, y, x.
pub(crate) type Shape = [usize; 3];

/// Refuses other numbers of axes than are searched. Where it stands in a function that users call, the compiler names
/// the line that called it.
pub(crate) const fn supported(axes: usize) {
    assert!(1 <= axes && axes <= 3, "searches are written for one to three axes");
}

/// Puts the axes of a picture or clip last, and `fill` before them.
pub(crate) fn lift<T: Copy, const D: usize>(axes: [T; D], fill: T) -> [T; 3] {
    const { supported(D) };
    let mut lifted = [fill; 3];
    lifted[3 - D..].copy_from_slice(&axes);
    lifted
}

/// The last `D` of three axes: the inverse of [`lift`].
pub(crate) fn lower<T: Copy, const D: usize>(axes: [T; 3]) -> [T; D] {
    std::array::from_fn(|axis| axes[3 - D + axis])
}

/// Position of a place in a row-major buffer.
#[inline]
pub(crate) fn position(shape: Shape, index: usize) -> Shape {
    [index / (shape[1] * shape[2]), index / shape[2] % shape[1], index % shape[2]]
}
