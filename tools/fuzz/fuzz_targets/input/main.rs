#![no_main]

mod bounded;
mod files;

use bounded::Bounded;
use files::{expect_caught_panics, run};

#[global_allocator]
static ALLOCATOR: Bounded = Bounded;

libfuzzer_sys::fuzz_target!(init: expect_caught_panics(), |data: &[u8]| run(data));
