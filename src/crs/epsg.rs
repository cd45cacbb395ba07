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
    #[cfg_attr(not(feature = "map-tiles"), allow(dead_code, reason = "only maps are projected"))]
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
    fn codes_at_both_ends_of_each_pack_have_their_definitions() {
        let all: Vec<_> = (0..=u16::MAX).filter_map(crs_definitions::from_code).collect();
        assert_eq!(all[0].code, BEGINS[0].0);
        let begins = |one: &crs_definitions::Def| BEGINS.iter().any(|&(first, _)| first == one.code);
        let ends = all.windows(2).filter(|pair| begins(&pair[1])).flatten();
        for expected in ends.chain(all.first()).chain(all.last()) {
            let found = definition(u32::from(expected.code)).unwrap();
            assert_eq!(
                (&*found.wkt, &*found.proj4),
                (expected.wkt, expected.proj4),
                "{}",
                expected.code
            );
        }
    }

    #[test]
    fn other_codes_have_none() {
        for code in [0, 1, 1999, 4_999_999, 65_535, 65_536, u32::MAX] {
            assert!(definition(code).is_none(), "{code}");
        }
    }
}
