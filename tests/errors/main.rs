//! Errors as a user meets them: each fault of an input ends the built program with exit code 2, a
//! message that says where, what was found and what is allowed, and not one file written; a run
//! that fails ends with exit code 3 and its state for ParaView.

mod base;
mod command_line;
mod failures;
mod materials;
mod meshes;
mod mutations;
mod old_names;
mod policies;
mod processes;
mod project;
mod rendering;
mod solver_settings;
mod variants;
