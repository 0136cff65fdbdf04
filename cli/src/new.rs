//! `bia new`: a project to begin with.

use crate::report;
use clap::{Args, ValueEnum};
use report::{complain, say};
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `bia new`.
#[derive(Args)]
pub struct NewArguments {
    /// Folder to make
    folder: PathBuf,
    /// What the project shall be like
    #[arg(long, value_enum, default_value = "falling-disc")]
    template: Template,
}

/// Declares the templates: each is an example of the repository in one file.
macro_rules! templates {
    ($($(#[$help:meta])* $name:ident $folder:literal;)*) => {
        /// Scenes to begin with.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
        enum Template { $($(#[$help])* $name,)* }

        impl Template {
            fn project(self) -> &'static str {
                match self {
                    $(Self::$name => include_str!(concat!("../../examples/", $folder, "/ProjectParameters.json")),)*
                }
            }
        }
    };
}

templates! {
    /// An elastic disc falls on a floor: implicit MPM
    FallingDisc "falling_disc";
    /// Two elastic discs collide: explicit MPM
    CollidingDiscs "colliding_discs";
    /// A body turns a hundred times: total-Lagrangian explicit MPM
    RotatingBody "rotating_body";
    /// A bar under a sudden load: total-Lagrangian MPM in one dimension
    StepBar "tlmpm_step_bar";
}

/// Writes the project; never over one that is there.
pub fn new(arguments: &NewArguments) -> ExitCode {
    let file = arguments.folder.join("ProjectParameters.json");
    if file.exists() {
        complain!("error: {} is there already", file.display());
        return ExitCode::from(2);
    }
    let written =
        std::fs::create_dir_all(&arguments.folder).and_then(|()| std::fs::write(&file, arguments.template.project()));
    match written {
        Ok(()) => {
            say!("{} is written. Next:\n  bia run {}", file.display(), file.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            complain!("error: {} cannot be written: {error}", file.display());
            ExitCode::from(2)
        }
    }
}
