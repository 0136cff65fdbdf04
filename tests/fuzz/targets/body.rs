#![no_main]

libfuzzer_sys::fuzz_target!(|content: &[u8]| bia_fuzz::read_with("Body.mdpa", content));
