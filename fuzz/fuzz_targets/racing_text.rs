#![no_main]
//! Text exports of racing loggers: the first byte says whose, the others follow the line that such
//! a text is known by.

mod log;

const BEGIN: [&[u8]; 5] = [
    b"Format,MoTeC CSV File\n",
    b"Format,AiM CSV File\n",
    b"This file is created using RaceChrono\n",
    b"// Update Rate: 100.0Hz\nPacketCounter\t",
    b"Format,RaceBox CSV\n",
];

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Some((&who, rest)) = bytes.split_first() else { return };
    log::read(&[BEGIN[usize::from(who) % 5], rest].concat(), ".csv");
});
