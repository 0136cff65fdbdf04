//! The direction of imports: applications know the kernel and the laws, never each other, and the
//! kernel knows none of them.

use std::fs;
use std::path::Path;

/// Crates of this workspace that a crate depends on.
fn own_dependencies(folder: &Path) -> Vec<String> {
    let text = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    let names = text.lines().filter(|line| line.starts_with("bia-")).map(|line| line.split(['.', ' ', '=']).next());
    names.flatten().map(str::to_string).collect()
}

#[test]
fn applications_never_see_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_eq!(own_dependencies(&root.join("kernel")), ["bia-linalg"]);
    assert_eq!(own_dependencies(&root.join("applications/constitutive")), ["bia-kernel"]);
    let mut seen = 0;
    for entry in fs::read_dir(root.join("applications")).unwrap() {
        let folder = entry.unwrap().path();
        if folder.ends_with("constitutive") || !folder.join("Cargo.toml").exists() {
            continue;
        }
        seen += 1;
        let mut dependencies = own_dependencies(&folder);
        dependencies.sort();
        assert_eq!(dependencies, ["bia-constitutive", "bia-kernel"], "{}", folder.display());
    }
    assert!(seen >= 2, "{seen} applications");
}
