#![no_main]

use bia_kernel::io::checkpoint::file;

// With the right check sum behind it: else that would be all that is ever found wrong.
libfuzzer_sys::fuzz_target!(|content: &[u8]| {
    let path = tempfile::NamedTempFile::new().expect("a file for the content");
    let whole = [content, &crc32fast::hash(content).to_le_bytes()].concat();
    std::fs::write(path.path(), whole).expect("a file for the content");
    drop(file::read(path.path()));
});
