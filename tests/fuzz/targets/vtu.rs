#![no_main]

use bia_kernel::io::vtu_read::parse_vtu;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    if let Err(errors) = parse_vtu(content, Path::new("mesh.vtu")) {
        assert!(errors.any_error());
    }
});
