//! A signal's bits in a frame.

/// Up to 64 bits of a frame, unsigned; `None` if the frame is too short.
///
/// `start` counts as DBC files do: bit 0 is the least of the first byte, and a big-endian signal
/// starts at its most significant bit, a little-endian one at its least.
pub(super) fn extract(data: &[u8], start: usize, size: usize, big_endian: bool) -> Option<u64> {
    if !(1..=64).contains(&size) {
        return None;
    }
    // the first bit in the order in which the bits are read
    let first = if big_endian { start / 8 * 8 + 7 - start % 8 } else { start };
    let bytes = data.get(first / 8..(first + size).div_ceil(8))?;
    let mut wide: u128 = 0;
    if big_endian {
        bytes.iter().for_each(|b| wide = wide << 8 | u128::from(*b));
        wide >>= bytes.len() * 8 - first % 8 - size;
    } else {
        bytes.iter().rev().for_each(|b| wide = wide << 8 | u128::from(*b));
        wide >>= first % 8;
    }
    let mask = u64::MAX >> (64 - size);
    Some(wide as u64 & mask)
}

/// The same bits as a two's complement number.
pub(super) fn signed(raw: u64, size: usize) -> i64 {
    let shift = 64 - size;
    (raw << shift) as i64 >> shift
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_of_both_orders() {
        let data = [0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0xF0, 0x11];
        assert_eq!(extract(&data, 0, 16, false), Some(0x3412));
        assert_eq!(extract(&data, 7, 16, true), Some(0x1234));
        assert_eq!(extract(&data, 4, 8, false), Some(0x41));
        assert_eq!(extract(&data, 3, 8, true), Some(0x23));
        assert_eq!(extract(&data, 0, 64, false), Some(0xF0DE_BC9A_7856_3412));
        assert_eq!(extract(&data, 3, 64, true), Some(0x2345_6789_ABCD_EF01));
        assert_eq!(extract(&data, 0, 1, false), Some(0));
        assert_eq!(extract(&data, 65, 8, false), None, "beyond the end");
        assert_eq!(extract(&data, 0, 0, false), None);
        assert_eq!(signed(0xF, 4), -1);
        assert_eq!(signed(0x7, 4), 7);
        assert_eq!(signed(u64::MAX, 64), -1);
    }
}
