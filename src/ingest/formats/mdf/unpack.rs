//! Packed blocks.

use std::io::Read as _;

use falcon_mdf::Mf4Error;
use falcon_mdf::blocks::CompressionType;
use libdeflater::Decompressor;

/// How a block's bytes are packed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Method {
    /// zlib.
    Deflate,
    /// Zstandard.
    Zstd,
    /// LZ4 frames.
    Lz4,
}

impl Method {
    /// The method, and whether rows were turned into columns before; `None` of unknown ones.
    pub(super) fn of(algorithm: CompressionType) -> Option<(Method, bool)> {
        let method = match algorithm {
            CompressionType::Deflate | CompressionType::TransposedDeflate => Method::Deflate,
            CompressionType::Zstd | CompressionType::TransposedZstd => Method::Zstd,
            CompressionType::Lz4 | CompressionType::TransposedLz4 => Method::Lz4,
            CompressionType::Unknown(_) => return None,
        };
        Some((method, algorithm.is_transposed()))
    }
}

/// Unpacks one block after the other into the same memory.
pub(super) struct Unpacker {
    inflater: Decompressor,
    bytes: Vec<u8>,
}

impl Default for Unpacker {
    fn default() -> Self {
        Unpacker { inflater: Decompressor::new(), bytes: Vec::new() }
    }
}

impl Unpacker {
    /// The `len` bytes of a block.
    ///
    /// # Errors
    /// It is damaged.
    pub(super) fn unpack(
        &mut self,
        method: Method,
        packed: &[u8],
        len: usize,
    ) -> Result<&[u8], Mf4Error> {
        let damaged = |e: &dyn std::fmt::Display| Mf4Error::Decompression(e.to_string());
        let got = match method {
            Method::Deflate => {
                self.bytes.resize(len, 0);
                let unpacked = self.inflater.zlib_decompress(packed, &mut self.bytes);
                unpacked.map_err(|_| damaged(&"corrupt deflate stream"))?
            }
            Method::Zstd => {
                self.bytes.resize(len, 0);
                let unpacked = zstd::bulk::Decompressor::new()
                    .and_then(|mut d| d.decompress_to_buffer(packed, &mut self.bytes[..]));
                unpacked.map_err(|e| damaged(&e))?
            }
            Method::Lz4 => {
                self.bytes.clear();
                let reader = lz4_flex::frame::FrameDecoder::new(packed);
                let mut reader = reader.take(len as u64 + 1);
                reader.read_to_end(&mut self.bytes).map_err(|e| damaged(&e))?
            }
        };
        if got != len {
            return Err(damaged(&format!("the block has {got} bytes instead of {len}")));
        }
        Ok(&self.bytes)
    }
}
