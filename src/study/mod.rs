//! Studies.
pub mod stability;
