//! Whether bytes arrived as they were sent: S3's name for an object that was put as a whole (its ETag) usually is the MD5 of its
//! bytes. Over plain HTTP nothing else would tell a bit that was turned on the way.

use std::sync::atomic::{AtomicBool, Ordering};

use md5::{Digest, Md5};

/// Set once a store gives the same bytes twice under a name that is not their MD5: some encrypt.
static NAMES_ARE_OTHERS: AtomicBool = AtomicBool::new(false);

/// Whether a store's name for bytes looks like their MD5.
pub(super) fn is_checksum(etag: &str) -> bool {
    let etag = etag.trim_matches('"');
    etag.len() == 32
        && etag.bytes().all(|b| b.is_ascii_hexdigit())
        && !NAMES_ARE_OTHERS.load(Ordering::Relaxed)
}

/// Whether bytes are others than their name says; `false` where the name says nothing.
pub(super) fn differs(etag: Option<&str>, bytes: &[u8]) -> bool {
    let Some(etag) = etag.filter(|etag| is_checksum(etag)) else { return false };
    let sum: String = Md5::digest(bytes).iter().map(|b| format!("{b:02x}")).collect();
    !etag.trim_matches('"').eq_ignore_ascii_case(&sum)
}

/// This store's names are no checksums.
pub(super) fn names_are_others() {
    NAMES_ARE_OTHERS.store(true, Ordering::Relaxed);
}

/// Whether requests go over plain HTTP, as to a store in the own house.
pub(super) fn is_plain() -> bool {
    ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"]
        .iter()
        .find_map(std::env::var_os)
        .is_some_and(|url| url.to_string_lossy().to_lowercase().starts_with("http://"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_bit_is_noticed_where_the_name_is_a_checksum() {
        // RFC 1321, appendix A.5
        let name = "\"900150983cd24fb0d6963f7d28e17f72\"";
        assert!(!differs(Some(name), b"abc") && differs(Some(name), b"abb"));
        // in parts, or none
        for name in [Some("900150983cd24fb0d6963f7d28e17f72-3"), Some("0x8DC"), None] {
            assert!(!differs(name, b"abb"), "{name:?}");
        }
    }
}
