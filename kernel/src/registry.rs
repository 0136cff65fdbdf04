//! The registry: every component an input file can name. Applications add theirs explicitly, one
//! line each; nothing registers itself.

mod build;
mod entries;

use crate::diagnostic::{Diagnostic, InputErrors};
use crate::geometry::Shape;
use crate::io::mdpa::{Category, CellNames};
use crate::parameters::{Key, Parameters, Settings};
use crate::variables::{Rank, Variable};
pub use entries::{
    BuildSolver, Building, Description, Kinds, Modeler, ModelerEntry, ProcessEntry, Provider, SolverEntry,
};
use std::any::{Any, TypeId};
use std::collections::HashMap;

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

fn rank_name(rank: Rank) -> &'static str {
    match rank {
        Rank::Scalar => "scalar",
        Rank::Vector => "vector",
        Rank::Voigt => "symmetric tensor",
        Rank::Tensor => "tensor",
    }
}
