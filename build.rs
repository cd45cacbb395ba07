//! Packs the definitions of EPSG codes for `crs::epsg`: as constants they take twenty times the space.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(feature = "epsg")]
    if let Err(error) = epsg::pack() {
        panic!("the definitions of EPSG codes cannot be packed: {error}");
    }
}

#[cfg(feature = "epsg")]
mod epsg {
    use std::path::Path;
    use std::{env, fs, io};

    use miniz_oxide::deflate::compress_to_vec;

    /// The number of definitions that are unpacked to look one up.
    const PACK: usize = 64;
    const BEST: u8 = 9;

    /// Writes `epsg.bin`, packs of lines `CODE<tab>WKT<tab>PROJ`, and `epsg.rs`, the first code of each
    /// pack and where it begins.
    pub fn pack() -> io::Result<()> {
        let all: Vec<_> = (0..=u16::MAX).filter_map(crs_definitions::from_code).collect();
        let (mut packs, mut begins) = (Vec::new(), Vec::new());
        for pack in all.chunks(PACK) {
            begins.push((pack[0].code, packs.len()));
            let lines = pack
                .iter()
                .map(|one| format!("{}\t{}\t{}\n", one.code, one.wkt, one.proj4));
            packs.extend(compress_to_vec(lines.collect::<String>().as_bytes(), BEST));
        }
        let folder = env::var_os("OUT_DIR").ok_or_else(|| io::Error::other("there is no OUT_DIR"))?;
        fs::write(Path::new(&folder).join("epsg.bin"), packs)?;
        fs::write(Path::new(&folder).join("epsg.rs"), format!("&{begins:?}"))
    }
}
