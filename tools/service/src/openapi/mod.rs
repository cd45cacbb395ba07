//! The description of all paths, as OpenAPI.
pub fn document(_: &[&str], _: &crate::options::Options) -> serde_json::Value { serde_json::Value::Null }
