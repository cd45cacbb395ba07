//! Finds the arrays of a core or a border in its FlatBuffer.

use std::ops::Range;

use crate::store::format::generated::tile as schema;

/// What an array holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
    /// Rows of integers of `width` bytes.
    Integers { width: usize, columns: usize },
    /// Rows of floating-point numbers.
    Floats { columns: usize },
    /// Vertices of other tiles.
    Foreign,
    /// Three corners for each triangle.
    Corners { width: usize },
    /// The neighbours of the half-edges of a core.
    Twins { width: usize },
    /// For each vertex a half-edge of the core.
    Starts { width: usize },
}

/// An array, and where its rows are in the buffer.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub(super) range: Range<usize>,
    pub(super) content: Content,
}

/// The fields that were found, in the order of the schema.
struct Fields<'a> {
    buffer: &'a [u8],
    found: Vec<Field>,
}

impl Fields<'_> {
    fn put(&mut self, bytes: &[u8], content: Content) {
        let start = bytes.as_ptr() as usize - self.buffer.as_ptr() as usize;
        let range = start..start + bytes.len();
        self.found.push(Field { range, content });
    }

    /// Adds packed integers without their padding.
    fn packed(&mut self, packed: Option<schema::Packed<'_>>, content: impl Fn(usize) -> Content) {
        let Some(packed) = packed else { return };
        let width = usize::from(packed.width());
        let data = packed.data().map_or(&[][..], |data| data.bytes());
        if let (1..=8, Some(end)) = (width, data.len().checked_sub(8usize.saturating_sub(width))) {
            self.put(&data[..end], content(width));
        }
    }

    fn integers(&mut self, packed: Option<schema::Packed<'_>>, columns: usize) {
        self.packed(packed, |width| Content::Integers { width, columns });
    }

    /// Returns the fields in the order of their positions, if they are disjoint.
    fn sorted(mut self) -> Option<Vec<Field>> {
        self.found.retain(|field| !field.range.is_empty());
        self.found.sort_by_key(|field| field.range.start);
        let are_disjoint = self.found.is_sorted_by(|a, b| a.range.end <= b.range.start);
        are_disjoint.then_some(self.found)
    }
}

/// Returns the arrays of a core, or `None` if it is none.
pub(super) fn of_core(buffer: &[u8]) -> Option<Vec<Field>> {
    let core = flatbuffers::root::<schema::Core<'_>>(buffer).ok()?;
    let found = Vec::new();
    let mut fields = Fields { buffer, found };
    fields.put(core.coordinates().bytes(), Content::Floats { columns: 2 });
    if let Some(z) = core.z() {
        fields.put(z.bytes(), Content::Floats { columns: 1 });
    }
    fields.packed(Some(core.triangles()), |width| Content::Corners { width });
    fields.packed(Some(core.neighbours()), |width| Content::Twins { width });
    fields.packed(Some(core.vertex_sides()), |width| Content::Starts { width });
    for (packed, columns) in [
        (Some(core.records()), 1),
        (core.components(), 1),
        (core.edge_sides(), 1),
        (core.edge_sources(), 1),
        (core.sites(), 2),
        (core.site_id_ends(), 1),
    ] {
        fields.integers(packed, columns);
    }
    fields.sorted()
}

/// Returns the arrays of a border, or `None` if it is none.
pub(super) fn of_border(buffer: &[u8]) -> Option<Vec<Field>> {
    let border = flatbuffers::root::<schema::Border<'_>>(buffer).ok()?;
    let found = Vec::new();
    let mut fields = Fields { buffer, found };
    fields.put(border.foreign().bytes(), Content::Foreign);
    if let Some(z) = border.foreign_z() {
        fields.put(z.bytes(), Content::Floats { columns: 1 });
    }
    fields.packed(Some(border.triangles()), |width| Content::Corners { width });
    for (packed, columns) in [
        (Some(border.neighbours()), 3),
        (Some(border.core_links()), 2),
        (Some(border.vertex_sides()), 2),
        (border.regions(), 1),
        (border.components(), 1),
        (border.depths(), 1),
        (border.edge_sides(), 1),
        (border.edge_sources(), 1),
        (border.edges(), 2),
    ] {
        fields.integers(packed, columns);
    }
    fields.sorted()
}
