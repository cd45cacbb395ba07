#![no_main]

use fuzz::{Place, run};

libfuzzer_sys::fuzz_target!(|data: &[u8]| run(data, Place::Superblock));
