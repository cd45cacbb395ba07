//! The conversion of a projected system: its method and the values of its parameters.

use serde_json::{Value, json};

use super::methods::{self, Method, Parameter, Quantity};
use super::parts::{Measure, angle, id, length, ratio, with};
use crate::crs::wkt::Node;

/// The unit of a ratio in PROJJSON.
const UNITY: &str = "unity";

/// Returns the conversion of a projected system with a base and a unit of lengths.
pub fn conversion(node: &Node, base: &Node, unit: &Measure) -> Option<Value> {
    match node.child(&["CONVERSION"]) {
        Some(conversion) => of_second_version(conversion),
        None => of_first_version(node, base, unit),
    }
}

/// Returns a conversion of WKT 2, which has the names of the EPSG dataset.
fn of_second_version(node: &Node) -> Option<Value> {
    let method = node.child(&["METHOD", "PROJECTION"])?;
    if node.child(&["PARAMETERFILE"]).is_some() {
        return None;
    }
    let parameters = node.children.iter().filter(|child| child.keyword == "PARAMETER");
    let parameters: Option<Vec<_>> = parameters
        .map(|parameter| {
            let unit = ratio(parameter).or_else(|| match parameter.child(&["ANGLEUNIT"]) {
                Some(_) => angle(parameter),
                None => length(parameter),
            });
            let parameter_object = json!({
                "name": parameter.texts.first()?,
                "value": parameter.numbers.first()?,
                "unit": unit?.json(),
            });
            Some(with(parameter_object, "id", id(parameter)))
        })
        .collect();
    let method = with(json!({"name": method.texts.first()?}), "id", id(method));
    let conversion = json!({"name": node.texts.first()?, "method": method, "parameters": parameters?});
    Some(with(conversion, "id", id(node)))
}

/// Returns the conversion of a system in WKT 1.
fn of_first_version(node: &Node, base: &Node, unit: &Measure) -> Option<Value> {
    let given: Option<Vec<(String, f64)>> = node
        .children
        .iter()
        .filter(|child| child.keyword == "PARAMETER")
        .map(|parameter| Some((methods::letters(parameter.texts.first()?), *parameter.numbers.first()?)))
        .collect();
    let given = given?;
    let method = methods::of(node, base, &given)?;
    if !has_all(method, &given) {
        return None;
    }
    let angles = angle(base)?.json();
    let parameters: Option<Vec<_>> = method
        .parameters
        .iter()
        .map(|parameter| {
            let unit = match parameter.quantity {
                Quantity::Angle => angles.clone(),
                Quantity::Length => unit.json(),
                Quantity::Ratio => json!(UNITY),
            };
            Some(json!({
                "name": parameter.name,
                "value": value(parameter, &given)?,
                "unit": unit,
                "id": {"authority": "EPSG", "code": parameter.code},
            }))
        })
        .collect();
    Some(json!({
        "name": "unnamed",
        "method": {"name": method.name, "id": {"authority": "EPSG", "code": method.code}},
        "parameters": parameters?,
    }))
}

/// Returns the value of a parameter. Some that are neutral may be omitted.
fn value(parameter: &Parameter, given: &[(String, f64)]) -> Option<f64> {
    let find = |names: &[&str]| {
        given
            .iter()
            .find(|(name, _)| names.contains(&&**name))
            .map(|&(_, value)| value)
    };
    find(parameter.first_version).or(match parameter.quantity {
        Quantity::Length => Some(0.0),
        Quantity::Ratio => Some(1.0),
        Quantity::Angle if parameter.may_be_omitted => Some(0.0),
        // ESRI's programs omit the angle of the grid, which is the azimuth then.
        Quantity::Angle if parameter.code == methods::GRID_ANGLE => find(&["azimuth"]),
        Quantity::Angle => None,
    })
}

/// Returns whether the method has all parameters that are not neutral.
fn has_all(method: &Method, given: &[(String, f64)]) -> bool {
    given.iter().all(|(name, value)| {
        let is_neutral = *value == if name.contains("scale") { 1.0 } else { 0.0 };
        is_neutral
            || method
                .parameters
                .iter()
                .any(|known| known.first_version.contains(&&**name))
    })
}
