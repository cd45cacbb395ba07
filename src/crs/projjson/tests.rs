//! Systems of all kinds. Whether PROJ takes them for the right ones is checked by
//! `tools/readers/check`.

use serde_json::{Value, json};

use crate::crs::Crs;

const GEOGRAPHIC: &str = r#"GEOGCS["NTF (Paris)",DATUM["NTF",SPHEROID["Clarke 1880 (IGN)",6378249.2,293.4660212936269]],PRIMEM["Paris",2.33722917],UNIT["grad",0.01570796326794897]]"#;

fn of(text: &str) -> Option<Value> {
    Crs::new(text).projjson()
}

/// Returns a projected system of WKT 1 with a method and parameters.
fn projected(method: &str, parameters: &[(&str, f64)], rest: &str) -> String {
    let parameters: String = parameters
        .iter()
        .map(|(name, value)| format!(r#"PARAMETER["{name}",{value}],"#))
        .collect();
    format!(r#"PROJCS["p",{GEOGRAPHIC},PROJECTION["{method}"],{parameters}UNIT["foot",0.3048]{rest}]"#)
}

const SCALED: [(&str, f64); 5] = [
    ("latitude_of_origin", 1.0),
    ("central_meridian", 2.0),
    ("scale_factor", 0.5),
    ("false_easting", 3.0),
    ("false_northing", 4.0),
];

#[test]
fn values_have_the_units_of_the_system() {
    let system = of(&projected("Transverse_Mercator", &SCALED, "")).unwrap();
    let grad = json!({"type": "AngularUnit", "name": "grad", "conversion_factor": 0.01570796326794897});
    let foot = json!({"type": "LinearUnit", "name": "foot", "conversion_factor": 0.3048});
    assert_eq!(system["type"], "ProjectedCRS");
    let conversion = &system["conversion"];
    assert_eq!(
        conversion["method"],
        json!({"name": "Transverse Mercator", "id": {"authority": "EPSG", "code": 9807}})
    );
    let found: Vec<_> = conversion["parameters"].as_array().unwrap().iter().collect();
    let parts = |part: &str| {
        found
            .iter()
            .map(|parameter| parameter[part].clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(
        parts("value"),
        [json!(1.0), json!(2.0), json!(0.5), json!(3.0), json!(4.0)]
    );
    assert_eq!(
        parts("unit"),
        [grad.clone(), grad.clone(), json!("unity"), foot.clone(), foot.clone()]
    );
    // The longitude of Paris is written in degrees where all other angles are grads.
    let datum = &system["base_crs"]["datum"];
    assert_eq!(
        datum["prime_meridian"],
        json!({"name": "Paris", "longitude": 2.33722917})
    );
    assert_eq!(system["base_crs"]["coordinate_system"]["axis"][0]["unit"], grad);
    assert_eq!(system["coordinate_system"]["axis"][1]["unit"], foot);
}

#[test]
fn what_cannot_be_said_faithfully_is_not_said() {
    assert!(of(&projected("Transverse_Mercator", &SCALED, "")).is_some());
    let more = |name, value| [&SCALED[..], &[(name, value)]].concat();
    assert!(of(&projected("Transverse_Mercator", &more("azimuth", 0.0), "")).is_some());
    assert!(of(&projected("Transverse_Mercator", &more("azimuth", 1.0), "")).is_none());
    assert!(
        of(&projected("Transverse_Mercator", &SCALED[2..], "")).is_none(),
        "no meridian"
    );
    assert!(of(&projected("Method_Of_My_Own", &SCALED, "")).is_none());
    let extension = r#",EXTENSION["PROJ4","+proj=tmerc +nadgrids=mine"]"#;
    assert!(of(&projected("Transverse_Mercator", &SCALED, extension)).is_none());
    let axes = r#",AXIS["x",DIAGONAL],AXIS["y",NORTH]"#;
    assert!(of(&projected("Transverse_Mercator", &SCALED, axes)).is_none());
    for text in [
        "PROJCS[\"x\"]",
        "GEOGCS[]",
        "GEOGCS[\"x\",DATUM[]]",
        "COMPD_CS[\"x\"]",
        "BOUNDCRS[SOURCECRS[]]",
        "GEOCCS[\"x\"]",
        &GEOGRAPHIC.replace("6378249.2", "-1"),
        &GEOGRAPHIC.replace("6378249.2", "nan"),
        &GEOGRAPHIC.replace("0.01570796326794897", "0"),
    ] {
        assert!(of(text).is_none(), "{text}");
    }
}

#[test]
fn one_name_of_a_method_may_mean_several() {
    let code = |method: &str, latitude: f64, scale: f64, rest: &str| {
        let parameters = [
            ("latitude_of_origin", latitude),
            ("central_meridian", 0.0),
            ("scale_factor", scale),
        ];
        of(&projected(method, &parameters, rest)).map(|system| system["conversion"]["method"]["id"]["code"].clone())
    };
    let web = r#",EXTENSION["PROJ4","+proj=merc +a=6378137 +b=6378137 +lat_ts=0 +nadgrids=@null"]"#;
    assert_eq!(code("Mercator_1SP", 0.0, 1.0, ""), Some(json!(9804)));
    assert_eq!(code("Mercator_1SP", 0.0, 1.0, web), Some(json!(1024)));
    assert_eq!(code("Polar_Stereographic", 90.0, 0.994, ""), Some(json!(9810)));
    assert_eq!(code("Polar_Stereographic", -71.0, 1.0, ""), Some(json!(9829)));
    assert_eq!(code("Polar_Stereographic", -71.0, 0.9, ""), Some(json!(9810)));
}

#[test]
fn axes_about_a_pole_point_along_meridians() {
    let degrees = |text: String| text.replace("0.01570796326794897", "0.0174532925199433");
    let axes = |latitude: f64| {
        let parameters = [
            ("latitude_of_origin", latitude),
            ("central_meridian", 70.0),
            ("scale_factor", 1.0),
        ];
        let system = of(&degrees(projected("Polar_Stereographic", &parameters, ""))).unwrap();
        let axis = |at: usize| {
            let axis = &system["coordinate_system"]["axis"][at];
            (
                axis["direction"].as_str().unwrap().to_owned(),
                axis["meridian"]["longitude"].as_f64().unwrap(),
            )
        };
        [axis(0), axis(1)]
    };
    assert_eq!(axes(-71.0), [("north".to_owned(), 160.0), ("north".to_owned(), 70.0)]);
    assert_eq!(axes(71.0), [("south".to_owned(), 160.0), ("south".to_owned(), -110.0)]);
}

#[test]
fn the_second_version_keeps_its_words() {
    let text = r#"PROJCRS["p",BASEGEOGCRS["b",ENSEMBLE["e",MEMBER["m",ID["EPSG",1]],ELLIPSOID["s",6378137,298.25,LENGTHUNIT["metre",1]],ENSEMBLEACCURACY[2.0]],ID["EPSG",4326]],CONVERSION["c",METHOD["Some Method",ID["EPSG",1]],PARAMETER["Some angle",9,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",2]]],CS[Cartesian,2],AXIS["easting (X)",east,ORDER[1]],AXIS["(Y)",north,ORDER[2]],LENGTHUNIT["metre",1],ID["EPSG",9]]"#;
    let system = of(text).unwrap();
    assert_eq!(
        system["base_crs"]["datum_ensemble"]["members"],
        json!([{"name": "m", "id": {"authority": "EPSG", "code": 1}}])
    );
    assert_eq!(system["conversion"]["method"]["name"], "Some Method");
    let parameter =
        json!({"name": "Some angle", "value": 9.0, "unit": "degree", "id": {"authority": "EPSG", "code": 2}});
    assert_eq!(system["conversion"]["parameters"], json!([parameter]));
    let axis = |name, abbreviation, direction| json!({"name": name, "abbreviation": abbreviation, "direction": direction, "unit": "metre"});
    assert_eq!(
        system["coordinate_system"]["axis"],
        json!([axis("easting", "X", "east"), axis("Northing", "Y", "north")])
    );
    assert_eq!(system["id"]["code"], 9);
    assert!(
        of(&text.replace(r#"ANGLEUNIT["degree",0.0174532925199433],"#, "")).is_none(),
        "no unit"
    );
}

#[test]
fn compound_systems_keep_heights_that_are_a_system() {
    let compound = |datum: u32| {
        let heights = format!(r#"VERT_CS["h",VERT_DATUM["d",{datum}],UNIT["metre",1],AXIS["Up",UP]]"#);
        of(&format!(r#"COMPD_CS["both",{GEOGRAPHIC},{heights}]"#)).unwrap()
    };
    let both = compound(2005);
    assert_eq!(both["type"], "CompoundCRS");
    assert_eq!(
        both["components"][1]["coordinate_system"]["axis"][0]["name"],
        "Gravity-related height"
    );
    // Heights above the ellipsoid.
    assert_eq!(compound(2002)["type"], "GeographicCRS");
}
