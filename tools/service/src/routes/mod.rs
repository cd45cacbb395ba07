//! The paths of the service.

mod base;
mod context;
mod facts;
mod features;
mod health;
mod input;
mod limits;
mod maps;
mod matrix;
mod measure;
mod page;
mod query;
mod raw;
mod router;
mod surface;
mod terrain;
