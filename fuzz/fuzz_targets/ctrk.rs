#![no_main]
//! Yamaha Y-Trac `.CTRK` logs; the header is what such a log is known by.

mod log;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let mut file = b"HEAD".to_vec();
    file.resize(0x34, 0);
    file.extend(bytes);
    log::read(&file, ".CTRK");
});
