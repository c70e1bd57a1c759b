//! A session as a comparison takes it.

use crate::fleet::evidence::Piece;

/// A session of one side.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Session {
    pub bike: String,
    pub session: String,
    /// 0 is A, 1 is B; 2 is neither: another session of a motorcycle, which tells how much its sessions differ.
    pub side: usize,
    /// Models of front and rear tyre, where they are known.
    pub tyres: [Option<String>; 2],
    /// Its values, error by error.
    pub pieces: Vec<Piece>,
}
