//! Tests of the service: in this process, and over connections.

mod connections;
mod descriptions;
mod files;
mod limits;
mod maps;
mod queries;
mod raw;
mod routes;
mod support;
mod tags;
