#![no_main]

use bia_kernel::expression::Expression;

libfuzzer_sys::fuzz_target!(|text: &str| drop(Expression::parse(text)));
