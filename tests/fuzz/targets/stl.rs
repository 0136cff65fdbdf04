#![no_main]

use bia_kernel::io::stl;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    if let Err(errors) = stl::parse(content, Path::new("body.stl")) {
        assert!(errors.any_error());
    }
});
