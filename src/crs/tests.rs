//! Texts as programs write them.

use super::*;

const UTM: &str = r#"PROJCS["WGS 84 / UTM zone 32N",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",9],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1,AUTHORITY["EPSG","9001"]],AXIS["Easting",EAST]]"#;
const LCC2: &str = r#"PROJCRS["ETRS89 / LCC",BASEGEOGCRS["ETRS89",DATUM["d",ELLIPSOID["GRS 1980",6378137,298.257,LENGTHUNIT["metre",1]]],PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],CONVERSION["c",METHOD["m"],PARAMETER["False easting",0,LENGTHUNIT["metre",1]]],CS[Cartesian,2],AXIS["easting (E)",east,ORDER[1],LENGTHUNIT["kilometre",1000]],AXIS["northing (N)",north,LENGTHUNIT["kilometre",1000]],ID["EPSG",3034]]"#;
/// What ESRI's programs write beside shapefiles.
const ESRI: &str = r#"PROJCS["NAD_1983_UTM_Zone_17N",GEOGCS["GCS_North_American_1983",DATUM["D_North_American_1983",SPHEROID["GRS_1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["Degree",0.017453292519943295]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",-81],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["Meter",1]]"#;

fn unit(text: &str) -> Unit {
    Crs::new(text).unit()
}

#[test]
fn wkt_of_both_versions_names_the_horizontal_unit() {
    assert_eq!(unit(UTM), Unit::Metre);
    assert_eq!(
        unit(&UTM.replace(r#""metre",1,"#, r#""Foot_US", 0.304800609601219,"#)),
        Unit::UsSurveyFoot
    );
    assert_eq!(unit(&UTM.replace(r#""metre",1,"#, r#""foot",0.3048,"#)), Unit::Foot);
    assert_eq!(
        unit(&UTM.replace(r#""metre",1,"#, r#""link",0.201168,"#)),
        Unit::Unknown
    );
    let with_height = format!(
        r#"COMPD_CS["both, [and]",{UTM},VERT_CS["height",VERT_DATUM["d",2005],UNIT["US survey foot",0.3048006096]]]"#
    );
    assert_eq!(unit(&with_height), Unit::Metre);
    assert_eq!(unit(&UTM.replace('[', "(").replace(']', ")")), Unit::Metre);
    let geographic =
        r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.25]],UNIT["degree",0.0174532925199433]]"#;
    assert_eq!(unit(geographic), Unit::Degree);
    assert_eq!(Crs::new(geographic).is_geographic(), Some(true));
    assert_eq!(unit(LCC2), Unit::Kilometre);
    assert_eq!(
        (Crs::new(LCC2).epsg(), Crs::new(LCC2).name()),
        (Some(3034), Some("ETRS89 / LCC"))
    );
    let geodetic = r#"GEOGCRS["WGS 84 3D", DATUM["d",ELLIPSOID["e",6378137,298.25,LENGTHUNIT["metre",1.0]]], CS[ellipsoidal,3], AXIS["lat",north], AXIS["h",up,LENGTHUNIT["metre",1]], ANGLEUNIT["degree",0.0174532925199433]]"#;
    assert_eq!(unit(geodetic), Unit::Degree);
    let bound = format!("BOUNDCRS[SOURCECRS[{LCC2}],TARGETCRS[{geographic}]]");
    assert_eq!(Crs::new(&bound).epsg(), Some(3034));
    for broken in [
        "[",
        "]]",
        "UNIT[\"metre\",1]",
        "PROJCS[\"x\"]",
        "PROJCS[\"x",
        "PROJCS[\"x\"] and more",
        "GEOCCS[\"x\",UNIT[\"metre\",1]]",
        &"A[".repeat(100_000),
    ] {
        assert_eq!(unit(broken), Unit::Unknown, "{broken:.40}");
    }
}

#[test]
fn codes_are_found_in_names_of_all_forms() {
    for (name, epsg, unit) in [
        ("urn:ogc:def:crs:OGC:1.3:CRS84", Some(4326), Unit::Degree),
        ("http://www.opengis.net/def/crs/OGC/1.3/CRS84", Some(4326), Unit::Degree),
        ("OGC:CRS84", Some(4326), Unit::Degree),
        (" EPSG:4326\n", Some(4326), Unit::Degree),
        ("urn:ogc:def:crs:EPSG::25832", Some(25832), Unit::Metre),
        (
            "http://www.opengis.net/gml/srs/epsg.xml#25832",
            Some(25832),
            Unit::Metre,
        ),
        ("epsg:32733", Some(32733), Unit::Metre),
        ("EPSG:900913", Some(3857), Unit::Metre),
        ("EPSG:65000", Some(65000), Unit::Unknown),
        ("EPSG:4294967296", None, Unit::Unknown),
        ("32733", None, Unit::Unknown),
        ("my town", None, Unit::Unknown),
        ("", None, Unit::Unknown),
    ] {
        let crs = Crs::new(name);
        assert_eq!((crs.epsg(), crs.unit()), (epsg, unit), "{name}");
        assert_eq!(crs.is_known(), epsg.is_some(), "{name}");
    }
}

#[test]
fn projjson_tells_whether_coordinates_are_angles() {
    let of = |kind: &str| Crs::new(&format!(r#"{{"$schema":"x","type" : "{kind}","name":"n"}}"#)).is_geographic();
    assert_eq!(
        [of("GeographicCRS"), of("ProjectedCRS"), of("CompoundCRS")],
        [Some(true), Some(false), None]
    );
    assert!(!Crs::new("{}").is_known());
}

#[test]
fn systems_differ_only_where_that_is_certain() {
    let conflict = |a: &str, b: &str| {
        let (a, b) = (Crs::new(a), Crs::new(b));
        assert_eq!(a.conflict(&b).is_some(), b.conflict(&a).is_some(), "{a:?} {b:?}");
        a.conflict(&b)
    };
    assert_eq!(conflict("EPSG:25832", "urn:ogc:def:crs:EPSG::25832"), None);
    assert_eq!(
        conflict("EPSG:2949", "EPSG:26917").unwrap(),
        "EPSG:2949 is not EPSG:26917"
    );
    assert!(conflict(UTM, "EPSG:4326").unwrap().contains("longitudes"));
    let feet = UTM.replace(r#""metre",1,"#, r#""foot",0.3048,"#);
    assert!(conflict(UTM, &feet).unwrap().contains("ft"));
    assert_eq!(conflict(UTM, ESRI).unwrap(), "central meridian 9 is not -81");
    // False eastings in other units, and names in other words.
    let second = r#"PROJCRS["x",CONVERSION["c",METHOD["m"],PARAMETER["Longitude of natural origin",9,ANGLEUNIT["degree",0.0174532925199433]],PARAMETER["False easting",500,LENGTHUNIT["kilometre",1000]]],CS[Cartesian,2],LENGTHUNIT["metre",1]]"#;
    assert_eq!(conflict(UTM, second), None);
    // What is not known proves nothing.
    for unknown in ["my town", "EPSG:65000", "", "LOCAL_CS[\"site\"]"] {
        assert_eq!(conflict(UTM, unknown), None, "{unknown}");
    }
}

#[cfg(feature = "epsg")]
#[test]
fn codes_have_the_parameters_of_their_definition() {
    let conflict = |a: &str, b: &str| Crs::new(a).conflict(&Crs::new(b));
    assert_eq!(conflict("EPSG:32632", UTM), None);
    assert_eq!(conflict("EPSG:26917", ESRI), None);
    assert!(conflict("EPSG:2949", ESRI).is_some());
    assert_eq!(unit("EPSG:2994"), Unit::Foot);
    assert_eq!(unit("EPSG:2225"), Unit::UsSurveyFoot);
    let utm = Crs::new("EPSG:32632");
    assert_eq!(utm.name(), Some("WGS 84 / UTM zone 32N"));
    assert_eq!(utm.summary(), "EPSG:32632, WGS 84 / UTM zone 32N");
    assert_eq!(Crs::new(&utm.wkt().unwrap()).epsg(), Some(32632));
}

#[test]
fn files_agree_on_one_system_or_the_error_names_two_of_them() {
    let mut files = Agreement::default();
    let add = |files: &mut Agreement, name: &str, text: &str| files.add(name.as_ref(), Crs::new(text));
    assert_eq!(files.crs(), None);
    add(&mut files, "a.shp", UTM).unwrap();
    assert_eq!(files.crs().unwrap().text(), UTM);
    add(&mut files, "b.laz", "EPSG:32632").unwrap();
    add(&mut files, "c.geojson", "urn:ogc:def:crs:EPSG::32632").unwrap();
    assert_eq!(files.crs().unwrap().text(), "EPSG:32632");
    let error = add(&mut files, "d.fgb", "EPSG:4326").unwrap_err();
    assert_eq!(error.files, ["a.shp", "d.fgb"].map(std::path::PathBuf::from));
    let text = error.to_string();
    for part in [
        "d.fgb has another coordinate reference system than a.shp",
        "EPSG:4326",
        "WGS 84 / UTM zone 32N",
    ] {
        assert!(text.contains(part), "{text}");
    }
    let mut given = Agreement::on(Crs::new("EPSG:3857"));
    add(&mut given, "a.shp", UTM).unwrap();
    add(&mut given, "d.fgb", "EPSG:4326").unwrap();
    assert_eq!(given.crs().unwrap().epsg(), Some(3857));
}

#[test]
fn methods_of_any_name_are_compared_and_unknown_ones_are_not() {
    let of = |method: &str| Crs::new(&UTM.replace("Transverse_Mercator", method));
    let wkt2 = |method: &str| {
        Crs::new(&format!(
            r#"PROJCRS["x",CONVERSION["c",METHOD["{method}",ID["EPSG",1]],PARAMETER["Longitude of natural origin",9]],CS[Cartesian,2],LENGTHUNIT["metre",1]]"#
        ))
    };
    for same in [
        ["Transverse_Mercator", "Gauss_Kruger", "Transverse Mercator"],
        [
            "Lambert_Conformal_Conic",
            "Lambert_Conformal_Conic_2SP",
            "Lambert Conic Conformal (2SP)",
        ],
        [
            "Mercator_1SP",
            "Mercator_Auxiliary_Sphere",
            "Popular Visualisation Pseudo Mercator",
        ],
        ["Albers", "Albers_Conic_Equal_Area", "Albers Equal Area"],
        [
            "Stereographic_North_Pole",
            "Polar_Stereographic",
            "Polar Stereographic (variant B)",
        ],
    ] {
        let [a, b, c] = [of(same[0]), of(same[1]), wkt2(same[2])];
        for (this, that) in [(&a, &b), (&b, &c), (&c, &a)] {
            assert_eq!(this.conflict(that), None, "{same:?}");
        }
        if same[0] != "Albers" {
            let why = a.conflict(&wkt2("Albers Equal Area")).unwrap();
            assert!(why.ends_with(" is not Albers Equal Area"), "{why}");
        }
        assert_eq!(a.conflict(&of("Stereographic")), None);
        assert_eq!(a.conflict(&wkt2("my method")), None);
    }
}

/// The limit for a difference does not depend on which of two systems comes first.
#[test]
fn parameters_are_compared_in_both_directions_alike() {
    let of =
        |northing: &str| Crs::new(&UTM.replace(r#""false_northing",0"#, &format!(r#""false_northing",{northing}"#)));
    let [a, b, c] = [of("10000000"), of("10000009.999995"), of("10000010.1")];
    assert_eq!((a.conflict(&b), b.conflict(&a)), (None, None));
    // More than the limit of the smaller one, less than that of the larger one.
    let d = of("10000010.000005");
    assert_eq!((a.conflict(&d), d.conflict(&a)), (None, None));
    assert!(a.conflict(&c).is_some() && c.conflict(&a).is_some());
}
