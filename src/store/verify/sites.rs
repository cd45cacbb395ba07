//! The file against its sites: every site of the input is one of its vertex, with its id, and there are no others.
//!
//! A site is told from others by a hash of place, number and id. They are looked up in parts, like points, by the tile that
//! must have them; each site of the file gets a bit when it is found, so of sites that are alike there are as many in both.

use std::sync::Arc;

use futures::stream::StreamExt;
use xxhash_rust::xxh3::Xxh3;

use crate::geometry::Point;
use crate::input::{SiteBatch, SiteId};
use crate::store::error::ReadError;
use crate::store::format::tile::Tile;
use crate::store::format::tile::sites::Site;
use crate::store::pass::{Needs, PassPlan, Workspaces, by_tile, list_for, spawn};
use crate::store::reader::TileReader;
use crate::store::verify::error::{VerifyError, VerifyReport};
use crate::store::verify::marks::Marks;

/// Sites that are looked up at once, at least.
const LEAST_SITES: u64 = 1 << 15;

/// A site of the input, by the tile that must have it.
struct Sought {
    hash: u128,
    /// Its place in the input.
    site: u64,
    point: Point,
    tile: u32,
}

/// The sites of a tile by hash, with their places in it.
type Hashes = Vec<(u128, u32)>;

/// A site that is not in the file: its place in the input, and where it lies.
type Missing = (u64, Point);

/// The error for a site of the file that the input lacks.
fn not_in_input(tile: &Tile, place: usize) -> VerifyError {
    VerifyError::Sites(match tile.sites().nth(place) {
        Some(Site { vertex, number, id }) => {
            let p = tile.point(vertex);
            let id = id.map_or_else(|| number.to_string(), str::to_owned);
            format!(
                "site {id} at ({}, {}) of the file is not in the input, or not as often",
                p.x, p.y
            )
        }
        None => format!("tile {} has another number of sites than before", tile.id()),
    })
}

impl TileReader {
    /// Checks that every site of the input is in the file, at its place and with its id, and that there are no others. `next`
    /// fills batches and says whether there was one.
    ///
    /// Sites are compared by hashes of 128 bits. They are looked up in parts, as many at once as fit in the memory that the
    /// reader may use, or in 512 MiB; each part passes over the tiles that should have them. Beside them there is a bit for each site of
    /// the file. Must be awaited within a tokio runtime.
    ///
    /// # Errors
    /// The first site, in the order of the input, that is not in the file; the first of the file that is not in the input; or what
    /// `next` says; or if the memory does not suffice for the bits and a tile.
    pub async fn verify_sites<E: std::fmt::Display>(
        &self,
        next: impl FnMut(&mut SiteBatch) -> Result<bool, E>,
    ) -> Result<VerifyReport, VerifyError> {
        let counts = self.count_in_tiles(|tile| Ok(tile.site_count())).await?;
        let (plan, at_once) = self.plan_sites(&counts)?;
        self.verify_sites_in_parts(next, counts, plan, at_once).await
    }

    /// How to pass over the tiles, and how many sites to look up at once.
    fn plan_sites(&self, counts: &[u32]) -> Result<(PassPlan, usize), ReadError> {
        const BYTES: u64 = size_of::<Sought>() as u64;
        let sites = counts.iter().map(|&count| u64::from(count));
        let (total, most) = (sites.clone().sum(), sites.max().unwrap_or(0));
        let needs = |sites: u64| Needs {
            fixed: Marks::byte_size(total) + sites * BYTES,
            per_thread: most * size_of::<(u128, u32)>() as u64,
            ..Needs::default()
        };
        self.plan_lookups(needs, LEAST_SITES..total, BYTES)
    }

    /// Looks the sites up, so many at once.
    pub(super) async fn verify_sites_in_parts<E: std::fmt::Display>(
        &self,
        mut next: impl FnMut(&mut SiteBatch) -> Result<bool, E>,
        counts: Vec<u32>,
        plan: PassPlan,
        at_once: usize,
    ) -> Result<VerifyReport, VerifyError> {
        let directory = self.directory();
        let marks = Arc::new(Marks::new(counts));
        let hashes = Arc::default();
        let mut sought = list_for(at_once);
        let mut batch = SiteBatch::default();
        let (mut sites, mut end) = (0, None);
        while end.is_none() {
            batch.clear();
            match next(&mut batch) {
                Ok(true) => {}
                Ok(false) => end = Some(Ok(())),
                Err(error) => end = Some(Err(VerifyError::Input(error.to_string()))),
            }
            for (&point, id) in batch.points.iter().zip(&batch.ids) {
                let point = point.normalized();
                let Some(tile) = directory.tree.tile_at(point) else {
                    end = Some(Err(missing((sites, point))));
                    break;
                };
                // As a build numbers them.
                let (number, text) = match id {
                    SiteId::Number(number) => (*number, None),
                    SiteId::Text(text) => (sites, Some(text.as_str())),
                };
                sought.push(Sought {
                    hash: hash(point, number, text),
                    site: sites,
                    point,
                    tile: tile.0,
                });
                sites += 1;
                if sought.len() == at_once {
                    sought = self.find_sites(sought, plan, &marks, &hashes).await?;
                }
            }
        }
        // Whatever ends the input, what came before it is reported first, however the sites were parted.
        self.find_sites(sought, plan, &marks, &hashes).await?;
        end.unwrap_or(Ok(()))?;
        if let Some((tile, place)) = marks.first_unset() {
            return Err(not_in_input(&*self.tile(tile).await?, place as usize));
        }
        Ok(VerifyReport {
            tiles: directory.tiles.len() as u64,
            sites,
            ..VerifyReport::default()
        })
    }

    /// Looks the sites up, tile by tile; `hashes` is what to compute in. Returns their memory.
    async fn find_sites(
        &self,
        mut sought: Vec<Sought>,
        plan: PassPlan,
        marks: &Arc<Marks>,
        hashes: &Arc<Workspaces<Hashes>>,
    ) -> Result<Vec<Sought>, VerifyError> {
        let sorted = spawn(move || {
            sought.sort_unstable_by_key(|s| (s.tile, s.hash, s.site));
            Arc::new(sought)
        });
        let mut sought = sorted.await?;
        let groups = by_tile(&sought, |s| s.tile);
        let (of_all, marks, hashes) = (Arc::clone(&sought), Arc::clone(marks), Arc::clone(hashes));
        let mut tiles = self.for_some_tiles(groups, plan, move |tile, group| {
            hashes.with(|hashes| find_in_tile(&tile, &of_all[group], &marks, hashes))
        });
        let mut first_missing: Option<Missing> = None;
        while let Some(found) = tiles.next().await {
            if let Some(other) = found?
                && first_missing.is_none_or(|(first, _)| other.0 < first)
            {
                first_missing = Some(other);
            }
        }
        drop(tiles);
        if let Some(site) = first_missing {
            return Err(missing(site));
        }
        // Tasks that are done hold it no more.
        let mut sought = Arc::get_mut(&mut sought).map(std::mem::take).unwrap_or_default();
        sought.clear();
        Ok(sought)
    }
}

/// Looks up the sites that a tile must have, and marks them. Returns the first that is missing.
fn find_in_tile(tile: &Tile, group: &[Sought], marks: &Marks, hashes: &mut Hashes) -> Option<Missing> {
    hashes.clear();
    let of_site = |site: Site<'_>| hash(tile.point(site.vertex), site.number, site.id);
    hashes.extend(tile.sites().map(of_site).zip(0..));
    hashes.sort_unstable();
    let missing = group.chunk_by(|a, b| a.hash == b.hash).filter_map(|alike| {
        let hash = alike[0].hash;
        let start = hashes.partition_point(|&(other, _)| other < hash);
        let its = hashes[start..].iter().take_while(|&&(other, _)| other == hash);
        let found = marks.set_more(tile.id(), its.map(|&(_, place)| place), alike.len());
        alike.get(found).map(|sought| (sought.site, sought.point))
    });
    missing.min_by_key(|&(site, _)| site)
}

/// What tells a site from others.
fn hash(p: Point, number: u64, text: Option<&str>) -> u128 {
    let mut hasher = Xxh3::new();
    for bits in [p.x.to_bits(), p.y.to_bits(), number] {
        hasher.update(&bits.to_le_bytes());
    }
    hasher.update(text.unwrap_or_default().as_bytes());
    hasher.digest128()
}

fn missing((site, p): Missing) -> VerifyError {
    VerifyError::Sites(format!(
        "site {site} of the input (counted from 0) at ({}, {}) is not in the file, or not as often, or has another id",
        p.x, p.y
    ))
}
