#![no_main]

use bia_kernel::io::checkpoint::file;

libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    let file = tempfile::NamedTempFile::new().expect("a file for the content");
    std::fs::write(file.path(), content).expect("a file for the content");
    drop(file::read(file.path()));
});
