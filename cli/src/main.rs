//! The `bia` command: parse arguments, register applications, run, show progress and errors.

mod convert;
mod info;
mod log;
mod new;
mod progress;
mod reference;
mod report;
mod run;
mod signal;
mod study;
mod summary;

use bia_kernel::registry::Registry;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// A modular multiphysics framework: runs Kratos MPM projects as they stand.
#[derive(Parser)]
#[command(name = "bia", version, about, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "Examples:
  bia run ProjectParameters.json                 run a project, results beside it
  bia check ProjectParameters.json               read and check all input, run nothing
  bia explain ProjectParameters.json             stages and memory, and what the scene does without
  bia new scene --template falling-disc          write a project to begin with
  bia info Dynamic                               the keys of a solver, process, modeler or law
  bia info --markdown                            the same of everything, as a page
  bia convert plate.msh plate.mdpa               a mesh from one format to another, groups and parts kept
  bia schema > bia.schema.json                   for editors, in a member $schema of the project
  bia study STUDY.json                           compare methods: error against run time, as a page
  bia run P.json --resume                        go on from the newest checkpoint of the project
  bia run P.json --threads 2 --output /tmp/out --set /problem_data/end_time=0.1

Exit codes: 0 done, 1 a check process found differences, 2 wrong input, 3 the run failed,
130 and 143 stopped by SIGINT (Ctrl-C) and SIGTERM after a whole step.";

#[derive(Subcommand)]
enum Command {
    /// Run a project
    Run(run::RunArguments),
    /// Read and check all input of a project, run nothing, print what the scene consists of
    Check(ProjectArguments),
    /// Show how a project will be computed: stages, columns and their sizes, and what it does without
    Explain(run::ExplainArguments),
    /// Run a family of projects and report their errors against their run times
    Study(study::StudyArguments),
    /// Run scenes by all methods that can, and report which stay stable
    Survey(study::StudyArguments),
    /// Write a project to begin with
    New(new::NewArguments),
    /// List all solvers, processes, modelers, laws and variables, or show one
    Info(info::InfoArguments),
    /// Convert a mesh between Gmsh's .msh, Kratos's .mdpa and VTK's .vtu
    Convert(convert::ConvertArguments),
    /// Print the JSON Schema of projects, with which editors complete and check them
    Schema,
    /// Print completions for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

/// What both commands take.
#[derive(Args)]
struct ProjectArguments {
    /// The project: ProjectParameters.json
    file: PathBuf,
    /// Replace a value of the project: a JSON pointer, =, and JSON or a plain word
    #[arg(long = "set", value_name = "POINTER=VALUE")]
    set: Vec<String>,
    /// Reproduce Kratos 10.4.4 to round-off, its faults included
    #[arg(long)]
    kratos_exact: bool,
}

/// All applications that this program was built with.
fn registry() -> Registry {
    let mut registry = Registry::with_kernel();
    #[cfg(feature = "mpm")]
    bia_mpm::register(&mut registry);
    #[cfg(feature = "structural")]
    bia_structural::register(&mut registry);
    #[cfg(feature = "dgmpm")]
    bia_dgmpm::register(&mut registry);
    registry
}

fn main() -> ExitCode {
    match Cli::parse().command {
        Command::Run(arguments) => run::run(&arguments, &registry()),
        Command::Check(arguments) => run::check(&arguments, &registry()),
        Command::Explain(arguments) => run::explain(&arguments, &registry()),
        Command::Study(arguments) => study::study(&arguments),
        Command::Survey(arguments) => study::survey(&arguments),
        Command::New(arguments) => new::new(&arguments),
        Command::Info(arguments) => info::info(&arguments, &registry()),
        Command::Convert(arguments) => convert::convert(&arguments, &registry()),
        Command::Schema => info::schema(&registry()),
        Command::Completions { shell } => info::completions(shell),
    }
}
