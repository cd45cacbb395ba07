//! The sites of a tile.

use std::ops::Range;

use crate::edit::tile::EditTile;
use crate::geometry::VertexIndex;

impl EditTile {
    /// Returns whether a site is at a vertex.
    pub(crate) fn has_site(&self, vertex: VertexIndex) -> bool {
        !self.sites_at(vertex).is_empty()
    }

    /// Adds a site at a vertex. `id` is empty if the number is the id.
    pub(crate) fn add_site(&mut self, vertex: VertexIndex, number: u64, id: &str) {
        if !id.is_empty() && self.site_ids.is_empty() {
            self.site_ids = vec![String::new(); self.sites.len()];
        }
        let site = (vertex.0, number);
        let place = self.sites.partition_point(|other| *other <= site);
        self.sites.insert(place, site);
        if !id.is_empty() || !self.site_ids.is_empty() {
            self.site_ids.insert(place, id.to_owned());
        }
    }

    /// Removes the sites at a vertex. Returns their number.
    pub(crate) fn remove_sites(&mut self, vertex: VertexIndex) -> u64 {
        let places = self.sites_at(vertex);
        let removed = places.len() as u64;
        self.sites.drain(places.clone());
        if !self.site_ids.is_empty() {
            self.site_ids.drain(places);
        }
        if self.site_ids.iter().all(String::is_empty) {
            self.site_ids.clear();
        }
        removed
    }

    /// Returns the places of the sites at a vertex. Sites are in the order of their vertices.
    pub(super) fn sites_at(&self, vertex: VertexIndex) -> Range<usize> {
        let start = self.sites.partition_point(|(at, _)| *at < vertex.0);
        let end = self.sites.partition_point(|(at, _)| *at <= vertex.0);
        start..end
    }
}
