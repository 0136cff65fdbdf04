//! A run that is stopped, or killed, and resumed gives the same bits as one that never stopped: in its
//! record and in every file that it writes, with another number of threads too.

#[path = "../structural/body.rs"]
#[allow(dead_code)]
mod body;
#[path = "../dgmpm/scene.rs"]
#[allow(dead_code)]
mod cells;
#[path = "../common/mod.rs"]
mod common;
mod dgmpm;
mod explicit;
mod failures;
mod faults;
mod implicit;
mod kills;
mod structural;
mod trial;
mod warnings;
