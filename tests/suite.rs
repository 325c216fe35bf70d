//! The tests of camdrive from outside: its rules of structure, its C interface, its commands, the descriptions of its FMUs and its
//! messages. One program, since each links the whole tool.

mod architecture;
mod c_interface;
mod cli;
mod live;
mod model_description;
mod scenes;
