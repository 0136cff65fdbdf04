//! A few messages as a whole, as they are read where standard error is no terminal.
