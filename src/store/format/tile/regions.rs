//! The components of a tile's triangles, and the regions of these.

use bytes::Bytes;

use crate::store::format::component_table::{Component, ComponentRecord, decode, decode_with};
use crate::store::format::damage::Damage;
use crate::store::format::generated::tile as schema;
use crate::store::format::ids::TileId;
use crate::store::format::packed::Packed;

/// The components of a tile.
#[derive(Clone)]
pub(crate) struct Regions {
    core_triangles: usize,
    /// The components of the triangles of the core, and of the border. Absent: all are of component
    /// 0.
    of_triangles: [Option<Packed>; 2],
    /// At least one.
    components: Vec<Component>,
    /// The component table, or nothing.
    table: Bytes,
}

impl Regions {
    /// Opens the components in verified buffers. `table` is the component table, empty if there is
    /// none. `triangles` contains the numbers of triangles of core and border.
    pub(crate) fn open(
        tile: TileId,
        (core, core_table): (&Bytes, schema::Core<'_>),
        (border, border_table): (&Bytes, schema::Border<'_>),
        table: Bytes,
        triangles: [usize; 2],
    ) -> Result<Self, Damage> {
        let open = |buffer: &Bytes, table: Option<_>| table.map(|table| Packed::open(buffer, table)).transpose();
        let components = match table.is_empty() {
            true => vec![Component::default()],
            false => decode_with(tile, &table, |record| record.component)?,
        };
        let this = Self {
            core_triangles: triangles[0],
            of_triangles: [
                open(core, core_table.components())?,
                open(border, border_table.components())?,
            ],
            components,
            table,
        };
        this.check(triangles)?;
        Ok(this)
    }

    fn check(&self, triangles: [usize; 2]) -> Result<(), Damage> {
        for (components, triangles) in self.of_triangles.iter().zip(triangles) {
            let Some(components) = components else { continue };
            if components.len() != triangles {
                return Err(Damage::new(format!(
                    "{triangles} triangles have {} components",
                    components.len()
                )));
            }
            let count = self.count() as u64;
            if let Some(component) = components.find_within(count..=u64::MAX) {
                return Err(Damage::new(format!("component {component} is not below {count}")));
            }
        }
        Ok(())
    }

    /// Returns what the component table says, or nothing if there is none.
    pub(crate) fn records(&self, tile: TileId) -> Vec<ComponentRecord> {
        // It was decoded before, so there is no error.
        decode(tile, &self.table).unwrap_or_default()
    }

    /// Returns the number of components of the tile.
    pub(crate) fn count(&self) -> usize {
        self.components.len()
    }

    /// Returns the number of the component of a triangle.
    pub(crate) fn number(&self, triangle: usize) -> usize {
        let (components, triangle) = match triangle.checked_sub(self.core_triangles) {
            None => (&self.of_triangles[0], triangle),
            Some(triangle) => (&self.of_triangles[1], triangle),
        };
        components
            .as_ref()
            .map_or(0, |components| components.get(triangle) as usize)
    }

    /// Returns the properties of a component by its number.
    pub(crate) fn component(&self, number: usize) -> Component {
        self.components[number]
    }

    pub(crate) fn byte_size(&self) -> usize {
        let packed = self.of_triangles.iter().flatten().map(Packed::byte_size);
        self.table.len() + size_of_val(&*self.components) + packed.sum::<usize>()
    }
}
