//! The sites of a tile.

use bytes::Bytes;

use crate::geometry::VertexIndex;
use crate::store::format::damage::Damage;
use crate::store::format::generated::tile as schema;
use crate::store::format::packed::{Packed, partition_point};

/// A site: a vertex that queries search for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Site<'t> {
    /// The vertex of the tile at which the site is.
    pub vertex: VertexIndex,
    /// The number of the site, from 0 across all inputs.
    pub number: u64,
    /// The id of the site, if the input has one.
    pub id: Option<&'t str>,
}

/// The sites of a tile, ordered by vertex.
#[derive(Clone)]
pub(crate) struct Sites {
    /// The vertex and the number of each site.
    pairs: Packed,
    /// The concatenated ids, and the end offset of each.
    ids: Option<(Bytes, Packed)>,
}

impl Sites {
    /// Opens the sites in a verified buffer. `vertices` is the number of vertices of the tile.
    pub(crate) fn open(core: &Bytes, table: schema::Core<'_>, vertices: u64) -> Result<Option<Self>, Damage> {
        let (pairs, ids) = match (table.sites(), table.site_ids(), table.site_id_ends()) {
            (None, None, None) => return Ok(None),
            (Some(pairs), None, None) => (Packed::open(core, pairs)?, None),
            (Some(pairs), Some(text), Some(ends)) => {
                (Packed::open(core, pairs)?, Some((text, Packed::open(core, ends)?)))
            }
            _ => return Err(Damage::new("sites lack their ids, or ids their sites")),
        };
        let entries = (0..pairs.len() / 2).map(|i| (pairs.get(2 * i), pairs.get(2 * i + 1)));
        let in_range = entries.clone().all(|(vertex, _)| vertex < vertices);
        if pairs.len() % 2 != 0 || !in_range || !entries.is_sorted() {
            return Err(Damage::new("a site is out of range or out of order"));
        }
        if let Some((text, ends)) = &ids {
            let complete = ends.len() == pairs.len() / 2 && ends.iter().last().unwrap_or(0) == text.len() as u64;
            // The ends ascend up to the length, so all of them are within the text.
            if !complete || !ends.iter().is_sorted() || !ends.iter().all(|end| text.is_char_boundary(end as usize)) {
                return Err(Damage::new("the end offsets of the ids of the sites are wrong"));
            }
        }
        Ok(Some(Self {
            ids: ids.map(|(text, ends)| (core.slice_ref(text.as_bytes()), ends)),
            pairs,
        }))
    }

    pub(crate) fn len(&self) -> usize {
        self.pairs.len() / 2
    }

    pub(crate) fn get(&self, index: usize) -> Site<'_> {
        Site {
            vertex: VertexIndex(self.pairs.get(2 * index) as u32),
            number: self.pairs.get(2 * index + 1),
            id: self.id(index).filter(|id| !id.is_empty()),
        }
    }

    /// Returns the sites at a vertex.
    pub(crate) fn at(&self, vertex: VertexIndex) -> impl Iterator<Item = Site<'_>> {
        let first = self.first_at(vertex.0.into());
        let sites = (first..self.len()).map(|index| self.get(index));
        sites.take_while(move |site| site.vertex == vertex)
    }

    /// Returns the index of the first site at this vertex or at a later one.
    fn first_at(&self, vertex: u64) -> usize {
        partition_point(self.len(), |index| self.pairs.get(2 * index) < vertex)
    }

    fn id(&self, index: usize) -> Option<&str> {
        let (text, ends) = self.ids.as_ref()?;
        let start = index.checked_sub(1).map_or(0, |before| ends.get(before));
        // UTF-8 was checked when the tile was opened.
        std::str::from_utf8(&text[start as usize..ends.get(index) as usize]).ok()
    }

    pub(crate) fn is_site(&self, vertex: VertexIndex) -> bool {
        let vertex = u64::from(vertex.0);
        let index = self.first_at(vertex);
        index < self.len() && self.pairs.get(2 * index) == vertex
    }

    pub(crate) fn byte_size(&self) -> usize {
        let ids = self.ids.as_ref();
        self.pairs.byte_size() + ids.map_or(0, |(text, ends)| text.len() + ends.byte_size())
    }
}
