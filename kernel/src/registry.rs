//! The registry: every component an input file can name. Applications add theirs explicitly, one
//! line each; nothing registers itself.

use crate::diagnostic::{Diagnostic, InputErrors, nearest};
use crate::geometry::Shape;
use crate::io::mdpa::{Category, CellNames};
use crate::model::Model;
use crate::parameters::{Key, Parameters, Settings};
use crate::processes::{Location, Process, RunOptions};
use crate::solving::solver::Solver;
use crate::variables::{Rank, Variable};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::path::PathBuf;

/// What a component is built from.
pub struct Building<'a> {
    /// Its checked settings.
    pub settings: Settings,
    /// All components, for names that the settings mention.
    pub registry: &'a Registry,
    /// Choices of the run.
    pub options: &'a RunOptions,
    /// The whole project, for the few components that look beside their own settings.
    pub project: &'a Parameters,
}

impl Building<'_> {
    /// A result file, refused where it would take the place of an input file.
    ///
    /// # Errors
    /// The file is the project, its materials or a mesh.
    pub fn result_file(&self, path: PathBuf) -> Result<PathBuf, InputErrors> {
        match self.project.is_input(&path) {
            true => {
                let message = format!("the result {} would overwrite an input file", path.display());
                Err(self.settings.parameters().error(message).help("choose another name or folder").into())
            }
            false => Ok(path),
        }
    }
}

/// A process and how to build it.
#[derive(Clone, Copy)]
pub struct ProcessEntry {
    /// Its `python_module`.
    pub name: &'static str,
    /// Older names.
    pub aliases: &'static [&'static str],
    /// The application it belongs to; none for the kernel.
    pub application: Option<&'static str>,
    /// Keys of its `Parameters`.
    pub keys: &'static [Key],
    /// What it does.
    pub help: &'static str,
    /// Builds it.
    pub build: fn(Building) -> Result<Box<dyn Process>, InputErrors>,
}

/// Makes or changes model parts before the solver sees them.
pub trait Modeler: Send {
    /// Creates model parts and reads or makes their meshes.
    ///
    /// # Errors
    /// Faults of the input, all together.
    fn setup_geometry(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors>;

    /// Turns geometries into elements and conditions.
    ///
    /// # Errors
    /// Faults of the input, all together.
    #[allow(unused_variables)]
    fn setup_model_part(&mut self, model: &mut Model, registry: &Registry) -> Result<(), InputErrors> {
        Ok(())
    }
}

/// A modeler and how to build it.
#[derive(Clone, Copy)]
pub struct ModelerEntry {
    /// Its name; leading module names are ignored in the input.
    pub name: &'static str,
    /// Keys of its `parameters`.
    pub keys: &'static [Key],
    /// Keys of the objects in its lists, with words for which they are.
    pub lists: fn() -> Vec<(String, &'static [Key])>,
    /// What it does.
    pub help: &'static str,
    /// Builds it.
    pub build: fn(Building) -> Result<Box<dyn Modeler>, InputErrors>,
}

/// Builds a solver from `solver_settings`.
pub type BuildSolver = fn(&Parameters, &Registry, &RunOptions) -> Result<Box<dyn Solver>, InputErrors>;

/// A solver and how to build it.
#[derive(Clone, Copy)]
pub struct SolverEntry {
    /// Values of `solver_type` that choose it (compared without regard to case, `-` and `_`).
    pub types: &'static [&'static str],
    /// Keys of `solver_settings`.
    pub keys: &'static [Key],
    /// What it does.
    pub help: &'static str,
    /// Builds it from `solver_settings`.
    pub build: BuildSolver,
}

/// A component of an application's own kind, such as a constitutive law, as a user may ask for it.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Description {
    /// Its name.
    pub name: String,
    /// Other names.
    pub aliases: Vec<String>,
    /// What it is.
    pub help: String,
    /// What it takes: name, unit, range, meaning.
    pub values: Vec<[String; 4]>,
}

/// A kind of components that an application keeps in a catalogue of its own.
#[derive(Clone, Copy)]
pub struct Kinds {
    /// What they are called together, such as "laws".
    pub title: &'static str,
    /// Describes them.
    pub describe: fn(&Registry) -> Vec<Description>,
}

/// What a kind of solver can show, so that who asks another one for it learns where it is.
#[derive(Debug, Clone, Copy)]
pub struct Provider {
    /// The solver in words, such as "structural solvers".
    pub who: &'static str,
    /// Where the variables are.
    pub location: Location,
    /// Their names.
    pub variables: fn() -> Vec<&'static str>,
}

/// All components.
#[derive(Default)]
pub struct Registry {
    variables: Vec<Variable>,
    cells: Vec<(Category, &'static str, Shape)>,
    processes: Vec<ProcessEntry>,
    modelers: Vec<ModelerEntry>,
    solvers: Vec<SolverEntry>,
    body_mesh: Option<(&'static str, &'static str)>,
    catalogues: HashMap<TypeId, Box<dyn Any + Send + Sync>>,
    kinds: Vec<Kinds>,
    providers: Vec<Provider>,
}

impl Registry {
    /// A registry with the kernel's own components.
    pub fn with_kernel() -> Self {
        let mut registry = Self::default();
        crate::processes::assign::register(&mut registry);
        crate::processes::json::register(&mut registry);
        crate::processes::measure::register(&mut registry);
        crate::processes::vtk::register(&mut registry);
        crate::modelers::register(&mut registry);
        crate::reference::register(&mut registry);
        registry
    }

    /// Adds a variable; a name that is there already is kept.
    pub fn variable(&mut self, variable: Variable) {
        if !self.variables.iter().any(|v| v.name == variable.name) {
            self.variables.push(variable);
        }
    }

    /// Adds an element or condition name with its shape.
    pub fn cell(&mut self, category: Category, name: &'static str, shape: Shape) {
        self.cells.push((category, name, shape));
    }

    /// Adds a process.
    pub fn process(&mut self, entry: ProcessEntry) {
        self.processes.push(entry);
    }

    /// Says which root part holds body meshes, and how their element names begin, unless the input
    /// says otherwise. The first application that says so rules.
    pub fn body_mesh(&mut self, part: &'static str, element: &'static str) {
        self.body_mesh.get_or_insert((part, element));
    }

    /// Root part and beginning of element names of body meshes, if an application has named them.
    pub fn body_mesh_names(&self) -> Option<(&'static str, &'static str)> {
        self.body_mesh
    }

    /// How the names of a root part's elements begin unless the input says otherwise.
    pub fn element_prefix(&self, part: &str) -> &'static str {
        self.body_mesh.filter(|(root, _)| *root == part).map_or("Element", |(_, prefix)| prefix)
    }

    /// Adds a modeler.
    pub fn modeler(&mut self, entry: ModelerEntry) {
        self.modelers.push(entry);
    }

    /// Adds a solver.
    pub fn solver(&mut self, entry: SolverEntry) {
        self.solvers.push(entry);
    }

    /// An application's own list of components, such as its constitutive laws; made empty at first.
    pub fn catalogue_mut<T: Any + Default + Send + Sync>(&mut self) -> &mut T {
        let entry = self.catalogues.entry(TypeId::of::<T>()).or_insert_with(|| Box::new(T::default()));
        match entry.downcast_mut() {
            Some(catalogue) => catalogue,
            None => unreachable!("catalogues are stored under their own type"),
        }
    }

    /// An application's own list of components, if it has one.
    pub fn catalogue<T: Any>(&self) -> Option<&T> {
        self.catalogues.get(&TypeId::of::<T>()).and_then(|catalogue| catalogue.downcast_ref())
    }

    /// Adds a kind of components that an application describes itself; a title that is there is kept.
    pub fn kind(&mut self, kind: Kinds) {
        if !self.kinds.iter().any(|known| known.title == kind.title) {
            self.kinds.push(kind);
        }
    }

    /// Says what a kind of solver can show.
    pub fn provider(&mut self, provider: Provider) {
        self.providers.push(provider);
    }

    /// What the solvers can show.
    pub fn providers(&self) -> &[Provider] {
        &self.providers
    }

    /// The kinds of components that applications describe themselves.
    pub fn kinds(&self) -> &[Kinds] {
        &self.kinds
    }

    /// Names and shapes of elements or conditions.
    pub fn cells(&self, category: Category) -> impl Iterator<Item = (&'static str, Shape)> {
        self.cells.iter().filter(move |(c, _, _)| *c == category).map(|(_, name, shape)| (*name, *shape))
    }

    /// All variables.
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// All processes.
    pub fn processes(&self) -> &[ProcessEntry] {
        &self.processes
    }

    /// All modelers.
    pub fn modelers(&self) -> &[ModelerEntry] {
        &self.modelers
    }

    /// All solvers.
    pub fn solvers(&self) -> &[SolverEntry] {
        &self.solvers
    }

    /// The variable of this name.
    pub fn find_variable(&self, name: &str) -> Option<Variable> {
        self.variables.iter().find(|v| v.name == name).copied()
    }

    /// The variable that `settings[key]` names, with the component if the name ends in _X, _Y or _Z.
    ///
    /// # Errors
    /// An unknown name, or a variable of another rank.
    pub fn variable_of(
        &self,
        settings: &Settings,
        key: &str,
        rank: Rank,
    ) -> Result<(Variable, Option<usize>), InputErrors> {
        let name = settings.text(key);
        let component = ["_X", "_Y", "_Z"].iter().position(|suffix| name.ends_with(suffix));
        let fits = |v: &Variable| v.rank == rank;
        match (self.find_variable(name), component) {
            (Some(variable), _) if fits(&variable) => Ok((variable, None)),
            (Some(variable), _) => {
                let message = format!("{name:?} is a {}, must be a {}", rank_name(variable.rank), rank_name(rank));
                let names = self.variables.iter().filter(|v| fits(v)).map(|v| v.name);
                Err(settings
                    .error(key, message)
                    .help(format!("fitting: {}", names.collect::<Vec<_>>().join(", ")))
                    .into())
            }
            (None, Some(component)) if rank == Rank::Scalar => match self.find_variable(&name[..name.len() - 2]) {
                Some(variable) if variable.rank == Rank::Vector => Ok((variable, Some(component))),
                _ => Err(self.unknown_variable(settings.error(key, format!("the variable {name:?} is unknown")), name)),
            },
            _ => Err(self.unknown_variable(settings.error(key, format!("the variable {name:?} is unknown")), name)),
        }
    }

    /// Adds the nearest variable name to a diagnostic.
    pub fn unknown_variable(&self, diagnostic: Diagnostic, name: &str) -> InputErrors {
        diagnostic.allowed(name, self.variables.iter().map(|v| v.name)).into()
    }

    /// The process of a block: `{"python_module": …, "kratos_module": …, "Parameters": {…}}`.
    ///
    /// # Errors
    /// An unknown module, or faults of its parameters.
    pub fn build_process(
        &self,
        block: &Parameters,
        project: &Parameters,
        options: &RunOptions,
    ) -> Result<Box<dyn Process>, InputErrors> {
        check_block(block)?;
        let name = block.text("python_module")?;
        let last = name.rsplit('.').next().unwrap_or(&name);
        let Some(entry) = self.process_named(&name) else {
            let place = block.child("python_module").unwrap_or_else(|| block.clone());
            let message = format!("there is no process {name:?}");
            return Err(place.error(message).allowed(last, self.processes.iter().map(|e| e.name)).into());
        };
        let Some(parameters) = block.child("Parameters") else {
            return Err(block.error("the key \"Parameters\" is missing").into());
        };
        let settings = parameters.read(entry.keys)?;
        (entry.build)(Building { settings, registry: self, options, project })
    }

    /// The modeler of a block, in the new (`name`, `parameters`) or old (`modeler_name`,
    /// `Parameters`) form.
    ///
    /// # Errors
    /// An unknown name, or faults of its parameters.
    pub fn build_modeler(
        &self,
        block: &Parameters,
        project: &Parameters,
        options: &RunOptions,
    ) -> Result<Box<dyn Modeler>, InputErrors> {
        let key = if block.child("name").is_some() { "name" } else { "modeler_name" };
        let name = block.text(key)?;
        let last = name.rsplit('.').next().unwrap_or(&name);
        let Some(entry) = self.modelers.iter().find(|e| e.name == last) else {
            let place = block.child(key).unwrap_or_else(|| block.clone());
            let message = format!("there is no modeler {name:?}");
            return Err(place.error(message).allowed(last, self.modelers.iter().map(|e| e.name)).into());
        };
        let Some(parameters) = block.child("parameters").or_else(|| block.child("Parameters")) else {
            return Err(block.error("the key \"parameters\" is missing").into());
        };
        let settings = parameters.read(entry.keys)?;
        (entry.build)(Building { settings, registry: self, options, project })
    }

    /// The solver that `solver_settings.solver_type` names.
    ///
    /// # Errors
    /// An unknown type, or faults of the settings.
    pub fn build_solver(&self, settings: &Parameters, options: &RunOptions) -> Result<Box<dyn Solver>, InputErrors> {
        let names = || self.solvers.iter().flat_map(|e| e.types.iter().copied());
        if settings.value().is_object() && settings.child("solver_type").is_none() {
            let list = names().collect::<Vec<_>>().join(", ");
            return Err(settings.error("\"solver_type\" is missing").help(format!("allowed: {list}")).into());
        }
        let name = settings.text("solver_type")?;
        match self.solver_of_type(&name) {
            Some(entry) => (entry.build)(settings, self, options),
            None => {
                let place = settings.child("solver_type").unwrap_or_else(|| settings.clone());
                Err(place.error(format!("there is no solver type {name:?}")).allowed(&name, names()).into())
            }
        }
    }

    /// The process of this name or old name; leading module names are ignored.
    pub fn process_named(&self, name: &str) -> Option<&ProcessEntry> {
        let last = name.rsplit('.').next().unwrap_or(name);
        self.processes.iter().find(|entry| entry.name == last || entry.aliases.contains(&last))
    }

    /// The keys of the solver that these settings choose; none if they choose none.
    pub fn solver_keys(&self, settings: &Parameters) -> &'static [Key] {
        let entry = settings.text("solver_type").ok().and_then(|name| self.solver_of_type(&name));
        entry.map_or(&[], |entry| entry.keys)
    }

    fn solver_of_type(&self, name: &str) -> Option<&SolverEntry> {
        let plain = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
        self.solvers.iter().find(|entry| entry.types.iter().any(|known| plain(known) == plain(name)))
    }
}

impl CellNames for Registry {
    fn shape(&self, category: Category, name: &str) -> Option<Shape> {
        self.cells.iter().find(|(c, n, _)| *c == category && *n == name).map(|(_, _, shape)| *shape)
    }

    fn names(&self, category: Category) -> Vec<String> {
        self.cells.iter().filter(|(c, _, _)| *c == category).map(|(_, name, _)| (*name).to_string()).collect()
    }
}

/// Members of a block of a process.
const BLOCK: &[&str] = &[
    "python_module",
    "kratos_module",
    "Parameters",
    "process_name",
    "help",
    "check",
    "implemented_in_file",
    "implemented_in_module",
];

/// Refuses members of a block that look like a slip of a known one.
fn check_block(block: &Parameters) -> Result<(), InputErrors> {
    let mut errors = InputErrors::default();
    for (name, value) in block.members() {
        if !BLOCK.contains(&name.as_str()) && nearest(&name, BLOCK.iter().copied()).is_some() {
            errors.push(value.error(format!("the key {name:?} is unknown")).allowed(&name, BLOCK.iter().copied()));
        }
    }
    errors.or(())
}

fn rank_name(rank: Rank) -> &'static str {
    match rank {
        Rank::Scalar => "scalar",
        Rank::Vector => "vector",
        Rank::Voigt => "symmetric tensor",
        Rank::Tensor => "tensor",
    }
}
