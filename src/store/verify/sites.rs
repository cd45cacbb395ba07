//! Compares the file with its sites: every site of the input is at one of the file's vertices, with
//! its id, and the file has no others.
//!
//! Sites are distinguished by a hash of point and id. They are looked up in parts, like
//! points, in the tile that must have them. Each site of the file has a bit that is set when it is
//! found, so the file and the input must contain identical sites equally often.

use std::sync::Arc;

use futures::stream::StreamExt;
use xxhash_rust::xxh3::Xxh3;

use crate::geometry::Point;
use crate::input::{SiteBatch, SiteId};
use crate::store::error::ReadError;
use crate::store::format::tile::Tile;
use crate::store::format::tile::sites::Site;
use crate::store::pass::{Needs, PassPlan, PassReader, Workspaces, by_tile, list_for, spawn};
use crate::store::reader::TileReader;
use crate::store::verify::error::{VerifyError, VerifyReport};
use crate::store::verify::tile_bits::TileBits;

/// The minimum number of sites that are looked up at once.
const LEAST_SITES: u64 = 1 << 15;

/// A site of the input, and the tile that must have it.
struct SoughtSite {
    hash: u128,
    /// Its index in the input.
    site: u64,
    point: Point,
    tile: u32,
}

/// The hashes of a tile's sites, each with the index of the site in the tile.
type SiteHashes = Vec<(u128, u32)>;

/// A site that is not in the file: its index in the input, and its point.
type MissingSite = (u64, Point);

/// Returns the error for a site of the file that the input lacks.
fn not_in_input(tile: &Tile, index: usize) -> VerifyError {
    VerifyError::Sites(match tile.sites().nth(index) {
        Some(Site { vertex, number, id }) => {
            let p = tile.point(vertex);
            let id = id.map_or_else(|| number.to_string(), str::to_owned);
            format!(
                "site {id} at ({}, {}) of the file is not in the input, or not as often",
                p.x, p.y
            )
        }
        None => format!("the number of sites of tile {} changed between two reads", tile.id()),
    })
}

impl TileReader {
    /// Checks that every site of the input is in the file, at its point and with its id, and that
    /// the file has no others. `next` fills a batch and returns whether there was one.
    ///
    /// Sites are compared by hashes of 128 bits. They are looked up in parts, with as many sites as
    /// fit into the memory that the reader may use, or into 512 MiB. Each part passes over the
    /// tiles that should have its sites. The check also keeps one bit per site of the file. Must be
    /// awaited within a tokio runtime.
    ///
    /// # Errors
    ///
    /// Returns an error for the first site, in the order of the input, that is not in the file; for
    /// the first site of the file that is not in the input; if `next` fails; or if the memory does
    /// not suffice for the bits and a tile.
    pub async fn verify_sites<E: std::fmt::Display>(
        &self,
        next: impl FnMut(&mut SiteBatch) -> Result<bool, E>,
    ) -> Result<VerifyReport, VerifyError> {
        let passes = self.for_passes().await?;
        let counts = passes.count_in_tiles(|tile| Ok(tile.site_count())).await?;
        let (plan, at_once) = passes.plan_sites(&counts)?;
        passes.verify_sites_in_parts(next, counts, plan, at_once).await
    }
}

impl PassReader {
    /// Returns the plan of a pass, and the number of sites to look up at once.
    fn plan_sites(&self, counts: &[u32]) -> Result<(PassPlan, usize), ReadError> {
        const BYTES: u64 = size_of::<SoughtSite>() as u64;
        let sites = counts.iter().map(|&count| u64::from(count));
        let (total, most) = (sites.clone().sum(), sites.max().unwrap_or(0));
        let needs = |sites: u64| Needs {
            fixed: TileBits::byte_size(total) + sites * BYTES,
            per_thread: most * size_of::<(u128, u32)>() as u64,
            ..Needs::default()
        };
        self.plan_lookups(needs, LEAST_SITES..total, BYTES)
    }

    /// Looks the sites up, `at_once` at a time.
    pub(super) async fn verify_sites_in_parts<E: std::fmt::Display>(
        &self,
        mut next: impl FnMut(&mut SiteBatch) -> Result<bool, E>,
        counts: Vec<u32>,
        plan: PassPlan,
        at_once: usize,
    ) -> Result<VerifyReport, VerifyError> {
        let directory = self.directory();
        let found_bits = Arc::new(TileBits::new(counts));
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
                sought.push(SoughtSite {
                    hash: match id {
                        SiteId::Number(number) => hash(point, *number, None),
                        SiteId::Text(text) => hash(point, 0, Some(text)),
                    },
                    site: sites,
                    point,
                    tile: tile.0,
                });
                sites += 1;
                if sought.len() == at_once {
                    sought = self.find_sites(sought, plan, &found_bits, &hashes).await?;
                }
            }
        }
        // Whatever ends the input, a fault before the end is reported first, regardless of the
        // parts.
        self.find_sites(sought, plan, &found_bits, &hashes).await?;
        end.unwrap_or(Ok(()))?;
        if let Some((tile, index)) = found_bits.first_unset() {
            return Err(not_in_input(&*self.tile(tile).await?, index as usize));
        }
        Ok(VerifyReport {
            tiles: directory.tiles.len() as u64,
            sites,
            ..VerifyReport::default()
        })
    }

    /// Looks the sites up, tile by tile. `hashes` provides workspaces. Returns the memory of
    /// `sought`.
    async fn find_sites(
        &self,
        mut sought: Vec<SoughtSite>,
        plan: PassPlan,
        found_bits: &Arc<TileBits>,
        hashes: &Arc<Workspaces<SiteHashes>>,
    ) -> Result<Vec<SoughtSite>, VerifyError> {
        let sorted = spawn(move || {
            sought.sort_unstable_by_key(|s| (s.tile, s.hash, s.site));
            Arc::new(sought)
        });
        let mut sought = sorted.await?;
        let groups = by_tile(&sought, |s| s.tile);
        let (of_all, found_bits, hashes) = (Arc::clone(&sought), Arc::clone(found_bits), Arc::clone(hashes));
        let mut tiles = self.for_some_tiles(groups, plan, move |tile, group| {
            let of_site = |site: Site<'_>| {
                let number = if site.id.is_none() { site.number } else { 0 };
                hash(tile.point(site.vertex), number, site.id)
            };
            hashes.with(|hashes| {
                hashes.clear();
                hashes.extend(tile.sites().map(of_site).zip(0..));
                hashes.sort_unstable();
                find_in_tile(&tile, &of_all[group], &found_bits, hashes)
            })
        });
        let mut first_missing: Option<MissingSite> = None;
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
        // Finished tasks no longer hold a reference.
        let mut sought = Arc::get_mut(&mut sought).map(std::mem::take).unwrap_or_default();
        sought.clear();
        Ok(sought)
    }
}

/// Looks up the sites that a tile must have, and sets their bits. `hashes` are those of the tile's
/// sites, in order. Returns the first that is missing.
fn find_in_tile(
    tile: &Tile,
    group: &[SoughtSite],
    found_bits: &TileBits,
    hashes: &[(u128, u32)],
) -> Option<MissingSite> {
    let missing = group.chunk_by(|a, b| a.hash == b.hash).filter_map(|alike| {
        let hash = alike[0].hash;
        let start = hashes.partition_point(|&(other, _)| other < hash);
        let same_hash = hashes[start..].iter().take_while(|&&(other, _)| other == hash);
        let found = found_bits.set_more(tile.id(), same_hash.map(|&(_, index)| index), alike.len());
        alike.get(found).map(|sought| (sought.site, sought.point))
    });
    missing.min_by_key(|&(site, _)| site)
}

/// Returns the hash that distinguishes sites. `number` is 0 where there is a text: the number of
/// such a site only counts, and edits count anew.
fn hash(p: Point, number: u64, text: Option<&str>) -> u128 {
    let mut hasher = Xxh3::new();
    for bits in [p.x.to_bits(), p.y.to_bits(), number] {
        hasher.update(&bits.to_le_bytes());
    }
    hasher.update(text.unwrap_or_default().as_bytes());
    hasher.digest128()
}

fn missing((site, p): MissingSite) -> VerifyError {
    VerifyError::Sites(format!(
        "site {site} of the input (counted from 0) at ({}, {}) is not in the file, or not as often, or has another id",
        p.x, p.y
    ))
}
