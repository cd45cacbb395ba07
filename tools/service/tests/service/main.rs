//! Tests of the service: in this process, and over connections.

#![allow(clippy::too_many_lines, reason = "some tests are lists of cases")]

mod connections;
mod descriptions;
mod files;
mod limits;
mod maps;
mod page;
mod queries;
mod raw;
mod routes;
mod support;
mod tags;
