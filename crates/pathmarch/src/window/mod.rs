//! Files, recovery and preferences of the window.
#![allow(dead_code)]

mod age;
mod chooser;
mod export;
mod places;
mod preferences;
mod recovery;
mod saving;
mod watch;
