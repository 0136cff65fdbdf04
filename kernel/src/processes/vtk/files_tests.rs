use super::*;
use crate::parameters::{Document, Parameters};

const KEYS: &[Key] = &Key::join::<14, 1, 15>(FILES, [Key::new("output_path", Kind::Text, "\"VTK\"", "folder")]);

fn settings(text: &str) -> Settings {
    Parameters::root(Document::parse(Path::new("p.json"), text.into()).unwrap()).read(KEYS).unwrap()
}

fn files(folder: &Path, text: &str) -> (VtkFiles, Settings) {
    let settings = settings(text);
    let options = RunOptions { folder: folder.into(), output: folder.into(), kratos_exact: false };
    (VtkFiles::read(&settings, &options).unwrap(), settings)
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn the_folder_is_emptied_of_vtk_files_only_when_the_run_starts() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("VTK");
    fs::create_dir(&own).unwrap();
    for name in ["a_0_1.vtk", "a.pvd", "a.vtk.series", ".a_0_2.vtu.77.tmp"] {
        fs::write(own.join(name), "").unwrap();
    }
    let (files, settings) = files(folder.path(), "{}");
    assert!(files.check_folder(&settings).is_ok());
    assert_eq!(names(&own).len(), 4, "checking changes nothing");
    files.prepare().unwrap();
    assert!(names(&own).is_empty());
}

#[test]
fn a_folder_with_anything_else_is_refused_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("VTK");
    fs::create_dir_all(own.join("below.vtk")).unwrap();
    fs::write(own.join("thesis.tex"), "").unwrap();
    let refused = |text: &str| {
        let (files, settings) = files(folder.path(), text);
        files.check_folder(&settings).unwrap_err().to_string()
    };
    let message = refused("{}");
    assert!(message.contains("below.vtk, thesis.tex") && message.contains("at /output_path"), "{message}");
    for path in [r#"{"output_path": "."}"#, r#"{"output_path": ""}"#, r#"{"output_path": "VTK/.."}"#] {
        assert!(refused(path).contains("the folder of the project"), "{path}");
    }
    assert!(refused(r#"{"output_path": "/"}"#).contains("other things than VTK"));
    assert!(
        refused(r#"{"folder_nam": 1}"#.replace("folder_nam\": 1", "output_path\": \"VTK/thesis.tex\"").as_str())
            .contains("listed")
    );
    let (files, settings) = files(folder.path(), r#"{"save_output_files_in_folder": false}"#);
    assert!(files.check_folder(&settings).is_ok(), "without a folder of its own it removes nothing");
    files.prepare().unwrap();
    assert_eq!(names(folder.path()), ["VTK"]);
}

/// Names that Kratos 10.4.4 gave.
#[test]
fn files_are_named_as_kratos_names_them() {
    let folder = tempfile::tempdir().unwrap();
    let clock = Clock { step: 2, time: 0.02, ..Clock::default() };
    let written = |text: &str| {
        let (mut files, _) = files(folder.path(), text);
        files.prepare().unwrap();
        let name = files.name("Body");
        files.write(&name, &clock, &Dataset::vertices(vec![[0.0; 3]]), true).unwrap();
        names(&folder.path().join("VTK"))
    };
    assert_eq!(written("{}"), ["Body_0_2.vtk"]);
    assert_eq!(written(r#"{"output_control_type": "time"}"#), ["Body_0_0.0200000.vtk"]);
    let text = r#"{"output_control_type": "time", "output_precision": 3, "custom_name_prefix": "pre_",
        "custom_name_postfix": "_post"}"#;
    assert_eq!(written(text), ["pre_Body_post_0_0.020.vtk"]);
    assert_eq!(written(r#"{"file_format": "vtu"}"#), ["Body.pvd", "Body_0_2.vtu"]);
}

/// Times closer than the digits tell apart get more digits, and the others those of the settings.
#[test]
fn no_file_takes_the_place_of_another() {
    let (times, data) = ([0.0, 0.02, 0.04, 0.06, 0.08, 0.1], Dataset::vertices(vec![[0.0; 3]]));
    let expected = ["0.0", "0.02", "0.04", "0.06", "0.08", "0.1", "0.10"];
    for (format, extension) in [("ascii", "vtk"), ("binary", "vtk"), ("vtu", "vtu")] {
        let folder = tempfile::tempdir().unwrap();
        let text = r#"{"output_control_type": "time", "output_precision": 1, "file_format": "FORMAT"}"#;
        let (mut files, _) = files(folder.path(), &text.replace("FORMAT", format));
        files.prepare().unwrap();
        for (step, time) in times.into_iter().enumerate() {
            for name in ["Body", "Grid"] {
                files.write(name, &Clock { step, time, ..Clock::default() }, &data, true).unwrap();
            }
        }
        let names = names(&folder.path().join("VTK"));
        for name in ["Body", "Grid"] {
            let labels: Vec<&str> = names
                .iter()
                .filter_map(|file| file.strip_prefix(name)?.strip_prefix("_0_")?.strip_suffix(extension))
                .map(|label| label.trim_end_matches('.'))
                .collect();
            assert_eq!(labels.len(), times.len(), "{names:?}");
            assert!(labels.iter().all(|label| expected.contains(label)), "{labels:?}");
        }
    }
}

#[test]
fn a_vtu_series_is_complete_after_every_step() {
    let folder = tempfile::tempdir().unwrap();
    let (mut files, _) = files(folder.path(), r#"{"file_format": "vtu"}"#);
    files.prepare().unwrap();
    let data = Dataset::vertices(vec![[0.0; 3]]);
    for step in 1..=3 {
        let clock = Clock { step, time: 0.5 * step as f64, ..Clock::default() };
        files.write("Body", &clock, &data, true).unwrap();
        let series = fs::read_to_string(folder.path().join("VTK/Body.pvd")).unwrap();
        assert_eq!(series.matches("<DataSet").count(), step);
        assert!(series.contains(&format!("timestep=\"{:?}\"", clock.time)) && series.contains("</VTKFile>"));
        assert!(folder.path().join(format!("VTK/Body_0_{step}.vtu")).is_file());
    }
    assert_eq!(files.written().len(), 4);
}

#[test]
fn flags_and_absurd_digits_are_refused() {
    for text in [r#"{"element_flags": ["ACTIVE"]}"#, r#"{"output_precision": 99}"#] {
        assert!(VtkFiles::read(&settings(text), &RunOptions::default()).is_err(), "{text}");
    }
}
