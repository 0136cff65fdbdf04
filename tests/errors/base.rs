//! A small scene that is right, and the ways in which the tests spoil it.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use tempfile::TempDir;

pub const PROJECT: &str = "ProjectParameters.json";
pub const MATERIALS: &str = "ParticleMaterials.json";
pub const GRID: &str = "Grid.mdpa";
pub const BODY: &str = "Body.mdpa";

/// A body on a floor, two steps of Newmark dynamics, a table of energies.
const PROJECT_TEXT: &str = r#"{
    "problem_data": {
        "problem_name": "base",
        "parallel_type": "OpenMP",
        "start_time": 0.0,
        "end_time": 0.02
    },
    "solver_settings": {
        "solver_type": "dynamic",
        "scheme_type": "newmark",
        "model_part_name": "MPM_Material",
        "domain_size": 2,
        "axis_symmetric_flag": false,
        "pressure_dofs": false,
        "stabilization": "ppp",
        "convergence_criterion": "residual_criterion",
        "max_iteration": 20,
        "time_stepping": {"time_step": 0.01},
        "model_import_settings": {"input_type": "mdpa", "input_filename": "Body"},
        "grid_model_import_settings": {"input_type": "mdpa", "input_filename": "Grid"},
        "material_import_settings": {"materials_filename": "ParticleMaterials.json"},
        "linear_solver_settings": {"solver_type": "LinearSolversApplication.sparse_lu"}
    },
    "processes": {
        "constraints": [{
            "python_module": "assign_vector_variable_process",
            "kratos_module": "KratosMultiphysics",
            "Parameters": {
                "model_part_name": "Background_Grid.Floor",
                "variable_name": "DISPLACEMENT",
                "constrained": [true, true, true],
                "value": [0.0, "0.0*t", 0.0],
                "interval": [0.0, "End"]
            }
        }],
        "gravity": [{
            "python_module": "assign_gravity_to_material_point_process",
            "kratos_module": "KratosMultiphysics.MPMApplication",
            "Parameters": {
                "model_part_name": "MPM_Material",
                "modulus": 9.81,
                "direction": [0.0, -1.0, 0.0]
            }
        }]
    },
    "output_processes": {
        "energy": [{
            "python_module": "mpm_write_energy_output_process",
            "kratos_module": "KratosMultiphysics.MPMApplication",
            "Parameters": {"model_part_name": "MPM_Material"}
        }]
    }
}
"#;

const MATERIALS_TEXT: &str = r#"{
    "properties": [{
        "model_part_name": "Initial_MPM_Material.Cube",
        "properties_id": 1,
        "Material": {
            "constitutive_law": {"name": "HyperElasticNeoHookeanPlaneStrain2DLaw"},
            "Variables": {
                "THICKNESS": 1.0,
                "MATERIAL_POINTS_PER_ELEMENT": 4,
                "DENSITY": 1000.0,
                "YOUNG_MODULUS": 1e6,
                "POISSON_RATIO": 0.3
            }
        }
    }]
}
"#;

/// The files of a project.
#[derive(Clone)]
pub struct Scene {
    files: BTreeMap<String, Vec<u8>>,
}

/// What the program did with a scene.
pub struct Outcome {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
    /// Files that were not there before.
    pub new_files: Vec<String>,
}

impl Scene {
    /// The scene that is right: a grid of 4 x 4 cells on the unit square (nodes 1 to 25, elements 1
    /// to 16), a body of 2 x 2 cells that stands on its floor (ids from 101).
    pub fn base() -> Self {
        let floor: String = (1..=5).map(|id| format!("{id}\n")).collect();
        let grid = mesh("Element2D4N", 0, 4, [0.0, 0.0], 0.25)
            + &format!(
                "Begin SubModelPart Floor\nBegin SubModelPartNodes\n{floor}End SubModelPartNodes\nEnd SubModelPart\n"
            );
        let body = mesh("MPMUpdatedLagrangian2D4N", 100, 2, [0.25, 0.0], 0.25) + &part("Cube", 101..=109, 101..=104);
        let texts = [(PROJECT, PROJECT_TEXT.into()), (MATERIALS, MATERIALS_TEXT.into()), (GRID, grid), (BODY, body)];
        Self { files: texts.into_iter().map(|(name, text): (&str, String)| (name.into(), text.into_bytes())).collect() }
    }

    pub fn text(&self, file: &str) -> String {
        String::from_utf8(self.files[file].clone()).unwrap()
    }

    /// Replaces a text that stands exactly once.
    #[must_use]
    pub fn replace(self, file: &str, from: &str, to: &str) -> Self {
        let text = self.text(file);
        assert_eq!(text.matches(from).count(), 1, "{from:?} must stand once in {file}");
        self.write(file, text.replace(from, to))
    }

    #[must_use]
    pub fn write(mut self, file: &str, content: impl Into<Vec<u8>>) -> Self {
        self.files.insert(file.into(), content.into());
        self
    }

    #[must_use]
    pub fn remove(mut self, file: &str) -> Self {
        assert!(self.files.remove(file).is_some());
        self
    }

    #[must_use]
    pub fn append(self, file: &str, more: &str) -> Self {
        let text = self.text(file) + more;
        self.write(file, text)
    }

    pub fn write_to(&self, folder: &Path) {
        for (name, content) in &self.files {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
        }
    }

    /// Runs `bia run` in a folder of its own.
    pub fn run(&self, arguments: &[&str]) -> Outcome {
        self.command("run", &[&["--threads", "1"], arguments].concat())
    }

    /// Runs a command of the built program on the scene.
    pub fn command(&self, name: &str, arguments: &[&str]) -> Outcome {
        let folder = TempDir::new().unwrap();
        self.write_to(folder.path());
        let before = listing(folder.path());
        let mut command = Command::new(env!("CARGO_BIN_EXE_bia"));
        let output = command.current_dir(folder.path()).args([name, PROJECT]).args(arguments).output().unwrap();
        let new_files = listing(folder.path()).into_iter().filter(|file| !before.contains(file)).collect();
        for (file, content) in &self.files {
            assert_eq!(&fs::read(folder.path().join(file)).unwrap(), content, "{file} was changed");
        }
        Outcome {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
            new_files,
        }
    }
}

impl Outcome {
    /// The messages with blanks and borders squeezed, so that wrapped lines can be compared.
    pub fn words(&self) -> String {
        self.stderr.replace('|', " ").split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Why this is not a refusal with all of these words; none if it is.
    pub fn fault_as_refusal(&self, says: &[&str]) -> Option<String> {
        let words = self.words();
        let missing: Vec<&&str> = says.iter().filter(|part| !words.contains(**part)).collect();
        if self.code == Some(2) && missing.is_empty() && self.new_files.is_empty() {
            return None;
        }
        let Self { code, stderr, new_files, .. } = self;
        Some(format!("exit {code:?}, new files {new_files:?}, not said: {missing:?}\n{stderr}"))
    }
}

/// Spoils the right scene.
pub type Spoil = fn(Scene) -> Scene;

/// Checks that each row is refused with exit code 2 by `bia run`, says all its words and leaves no
/// file; all rows that fail are shown together.
pub fn refuse(rows: &[(&str, Spoil, &[&str])]) {
    let mut wrong = Vec::new();
    for (name, spoil, says) in rows {
        let outcome = spoil(Scene::base()).run(&[]);
        wrong.extend(outcome.fault_as_refusal(says).map(|fault| format!("--- {name}: {fault}")));
    }
    assert!(wrong.is_empty(), "{} of {} rows:\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}

/// `n` x `n` squares of edge `h` from a corner, ids from `first + 1`.
pub fn mesh(element: &str, first: usize, n: usize, [x, y]: [f64; 2], h: f64) -> String {
    let mut text = String::from("Begin Properties 0\nEnd Properties\nBegin Nodes\n");
    for id in 0..(n + 1) * (n + 1) {
        let (i, j) = (id % (n + 1), id / (n + 1));
        writeln!(text, "{} {:?} {:?} 0.0", first + id + 1, x + h * i as f64, y + h * j as f64).unwrap();
    }
    writeln!(text, "End Nodes\nBegin Elements {element}").unwrap();
    for cell in 0..n * n {
        let corner = first + 1 + (cell / n) * (n + 1) + cell % n;
        let [right, above] = [corner + 1, corner + n + 1];
        writeln!(text, "{} 0 {corner} {right} {} {above}", first + cell + 1, above + 1).unwrap();
    }
    text + "End Elements\n"
}

/// A sub model part of these nodes and elements.
pub fn part(name: &str, nodes: impl Iterator<Item = u32>, elements: impl Iterator<Item = u32>) -> String {
    let lines = |ids: &mut dyn Iterator<Item = u32>| ids.map(|id| format!("{id}\n")).collect::<String>();
    let (mut nodes, mut elements) = (nodes, elements);
    format!(
        "Begin SubModelPart {name}\nBegin SubModelPartNodes\n{}End SubModelPartNodes\n\
         Begin SubModelPartElements\n{}End SubModelPartElements\nEnd SubModelPart\n",
        lines(&mut nodes),
        lines(&mut elements)
    )
}

/// All files below a folder.
pub fn listing(folder: &Path) -> Vec<String> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        files.push(name.clone());
        if path.is_dir() {
            files.extend(listing(&path).into_iter().map(|below| format!("{name}/{below}")));
        }
    }
    files.sort();
    files
}
