#![no_main]
//! Logs of lines of several kinds; the first lines are what such a log is known by.

mod log;

const KNOWN: &[u8] = b"susp 500,480,0\nsusp 501,481,100\nsusp 502,482,200\n";

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| log::read(&[KNOWN, bytes].concat(), ".txt"));
