//! A guide whose code is not the code would lead astray: the blocks of CONTRIBUTING.md stand in
//! `examples/extension`, a crate outside of the framework whose own tests compile and run them.

use std::fs::read_to_string;
use std::path::Path;

#[test]
fn the_guide_shows_the_code_of_the_extension() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let guide = read_to_string(root.join("CONTRIBUTING.md")).unwrap();
    for (file, name) in
        [("law", "law"), ("process", "process"), ("element", "element"), ("solver", "solver"), ("lib", "application")]
    {
        let source = read_to_string(root.join(format!("examples/extension/src/{file}.rs"))).unwrap();
        let (_, rest) = source.split_once(&format!("// [{name}]\n")).unwrap();
        let (code, _) = rest.split_once(&format!("// [/{name}]\n")).unwrap();
        assert!(guide.contains(&format!("```rust\n{code}```")), "CONTRIBUTING.md and {file}.rs differ");
    }
}
