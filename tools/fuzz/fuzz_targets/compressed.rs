#![no_main]

use fuzz::{ChangedPart, run};

libfuzzer_sys::fuzz_target!(|data: &[u8]| run(data, ChangedPart::Compressed));
