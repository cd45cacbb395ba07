//! Definitions of EPSG codes, which `build.rs` has packed.

use std::io::Read;

use flate2::read::DeflateDecoder;

const PACKS: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/epsg.bin"));
/// The first code of each pack, and where it begins.
const BEGINS: &[(u16, usize)] = include!(concat!(env!("OUT_DIR"), "/epsg.rs"));

/// The definition of a code.
pub struct Definition {
    pub wkt: String,
    /// As PROJ.4 has it; empty if it has none.
    #[cfg_attr(not(feature = "map-tiles"), expect(dead_code, reason = "only maps are projected"))]
    pub proj4: String,
}

/// Returns the definition of a code.
pub fn definition(code: u32) -> Option<Definition> {
    let code = u16::try_from(code).ok()?;
    let pack = BEGINS.partition_point(|&(first, _)| first <= code).checked_sub(1)?;
    let end = BEGINS.get(pack + 1).map_or(PACKS.len(), |&(_, begin)| begin);
    let mut lines = String::new();
    let mut decoder = DeflateDecoder::new(&PACKS[BEGINS[pack].1..end]);
    decoder.read_to_string(&mut lines).ok()?;
    lines.lines().find_map(|line| {
        let (its, rest) = line.split_once('\t')?;
        let (wkt, proj4) = rest.split_once('\t').filter(|_| its.parse() == Ok(code))?;
        Some(Definition {
            wkt: wkt.to_owned(),
            proj4: proj4.to_owned(),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_and_the_last_code_of_each_pack_have_their_definitions() {
        for (code, _) in BEGINS {
            let found = definition(u32::from(*code)).unwrap();
            assert!(
                found.wkt.contains(&format!(r#"AUTHORITY["EPSG","{code}"]"#)),
                "{code}: {}",
                found.wkt
            );
        }
        let geographic = definition(4326).unwrap();
        assert!(geographic.wkt.starts_with(r#"GEOGCS["WGS 84",DATUM["WGS_1984","#) && geographic.wkt.ends_with("]]"));
        assert_eq!(geographic.proj4, "+proj=longlat +datum=WGS84 +no_defs");
    }

    #[test]
    fn other_codes_have_none() {
        for code in [0, 1, 1999, 4_999_999, 65_535, 65_536, u32::MAX] {
            assert!(definition(code).is_none(), "{code}");
        }
    }
}
