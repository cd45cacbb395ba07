#![no_main]

use fuzz::bounded::Bounded;
use fuzz::input::{expect_caught_panics, run};

#[global_allocator]
static ALLOCATOR: Bounded = Bounded;

libfuzzer_sys::fuzz_target!(init: expect_caught_panics(), |data: &[u8]| run(data));
