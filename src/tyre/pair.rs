//! A value of the front wheel and one of the rear wheel.

/// Both values of a function of the wheel, 0 in front and 1 in the rear.
///
/// What [`array::map`] does, but compiled where it is used: without link-time optimisation between units, as in
/// development builds, that one is a call for every sample.
#[inline(always)]
pub(crate) fn both<T>(mut of: impl FnMut(usize) -> T) -> [T; 2] {
    let front = of(0);
    [front, of(1)]
}
