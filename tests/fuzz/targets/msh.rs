#![no_main]

use bia_kernel::io::gmsh;
use std::path::Path;

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    if let Err(errors) = gmsh::parse(content, Path::new("mesh.msh"), "Part", "Element") {
        assert!(errors.any_error());
    }
});
