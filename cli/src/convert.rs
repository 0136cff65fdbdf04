//! `bia convert`: a mesh from one format to another.

use crate::report::{complain, input, say};
use bia_kernel::diagnostic::InputErrors;
use bia_kernel::io::convert::{self, Format, Options};
use bia_kernel::io::gmsh::Version;
use bia_kernel::registry::Registry;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `bia convert`.
#[derive(Args)]
pub struct ConvertArguments {
    /// Mesh to read: .msh (Gmsh 2.2 or 4.1), .mdpa or .vtu
    input: PathBuf,
    /// Mesh to write; its end says the format
    output: PathBuf,
    /// How names of elements begin where the file gives none, such as MPMUpdatedLagrangian
    #[arg(long, default_value = "Element", value_name = "PREFIX")]
    element_prefix: String,
    /// Version of .msh files
    #[arg(long, value_enum, default_value = "4.1", value_name = "VERSION")]
    msh_version: MshVersion,
    /// Write .msh files in binary form
    #[arg(long)]
    msh_binary: bool,
    /// Write .vtu files with real numbers of 32 bits
    #[arg(long)]
    single_precision: bool,
    /// Replace the output if it is there
    #[arg(long)]
    force: bool,
}

/// Versions of Gmsh's format that are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MshVersion {
    /// The older one
    #[value(name = "2.2")]
    V2,
    /// The present one
    #[value(name = "4.1")]
    V4,
}

/// Reads and writes, and tells what the new format does not hold.
pub fn convert(arguments: &ConvertArguments, registry: &Registry) -> ExitCode {
    let options = Options {
        element_prefix: arguments.element_prefix.clone(),
        msh: if arguments.msh_version == MshVersion::V2 { Version::V2 } else { Version::V4 },
        msh_binary: arguments.msh_binary,
        single_precision: arguments.single_precision,
    };
    let (from, to) = (&arguments.input, &arguments.output);
    let mut errors = InputErrors::default();
    errors.absorb(Format::of(from));
    errors.absorb(Format::of(to));
    if let Err(errors) = errors.or(()) {
        return ExitCode::from(input(&errors));
    }
    if to.exists() && !arguments.force {
        complain!("error: {} is there already; --force replaces it", to.display());
        return ExitCode::from(2);
    }
    let converted = convert::read(from, registry, &options)
        .and_then(|part| convert::write(&part, to, &options).map(|written| (part, written)));
    let (part, written) = match converted {
        Ok(converted) => converted,
        Err(errors) => return ExitCode::from(input(&errors)),
    };
    say!(
        "{}: {} nodes, {} elements, {} conditions, {} geometries, {} sub model parts; {} bytes",
        to.display(),
        part.nodes.len(),
        part.elements.len(),
        part.conditions.len(),
        part.geometries.len(),
        part.paths().len(),
        written.bytes
    );
    for loss in &written.losses {
        complain!("warning: the format does not hold: {loss}");
    }
    ExitCode::SUCCESS
}
