//! The regions of a tile's triangles, stored by component.

use bytes::Bytes;

use crate::store::format::damage::Damage;
use crate::store::format::generated::tile as schema;
use crate::store::format::packed::Packed;
use crate::store::format::tile::edge_bits::is_set;

/// The properties that all triangles of a component of a tile share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Component {
    /// The number of the region.
    pub(crate) region: u64,
    /// The number of obstacles that cover the component.
    pub(crate) depth: i32,
    /// Whether the region is a hole.
    pub(crate) is_hole: bool,
}

/// The components of a tile. Absent data means 0, or no hole.
#[derive(Clone)]
pub(crate) struct Regions {
    core_triangles: usize,
    /// The components of the triangles of the core, and of the border.
    components: [Option<Packed>; 2],
    /// The regions of the components.
    regions: Option<Packed>,
    depths: Option<Packed>,
    holes: Bytes,
}

impl Regions {
    /// Opens the components in verified buffers. `triangles` contains the numbers of triangles of
    /// core and border.
    pub(crate) fn open(
        (core, core_table): (&Bytes, schema::Core<'_>),
        (border, border_table): (&Bytes, schema::Border<'_>),
        triangles: [usize; 2],
    ) -> Result<Self, Damage> {
        let open = |buffer: &Bytes, table: Option<_>| table.map(|table| Packed::open(buffer, table)).transpose();
        let this = Self {
            core_triangles: triangles[0],
            components: [
                open(core, core_table.components())?,
                open(border, border_table.components())?,
            ],
            regions: open(border, border_table.regions())?,
            depths: open(border, border_table.depths())?,
            holes: border_table
                .holes()
                .map_or_else(Bytes::new, |bits| border.slice_ref(bits.bytes())),
        };
        this.check(triangles)?;
        Ok(this)
    }

    fn check(&self, triangles: [usize; 2]) -> Result<(), Damage> {
        for (components, triangles) in self.components.iter().zip(triangles) {
            let Some(components) = components else { continue };
            if components.len() != triangles {
                return Err(Damage::new(format!(
                    "{triangles} triangles have {} components",
                    components.len()
                )));
            }
            let count = self.count() as u64;
            if let Some(component) = components.iter().find(|&component| component >= count) {
                return Err(Damage::new(format!("component {component} is not below {count}")));
            }
        }
        let Some(regions) = &self.regions else {
            return match self.depths.is_some() || !self.holes.is_empty() {
                true => Err(Damage::new("there are depths or holes, but no regions")),
                false => Ok(()),
            };
        };
        let count = regions.len();
        if count == 0 {
            return Err(Damage::new("there are no regions"));
        }
        if !self.holes.is_empty() && self.holes.len() != count.div_ceil(8) {
            return Err(Damage::new(format!(
                "there are {} bytes of holes for {count} components",
                self.holes.len()
            )));
        }
        if let Some(depths) = &self.depths
            && (depths.len() != count || depths.iter().any(|depth| u32::try_from(depth).is_err()))
        {
            return Err(Damage::new(format!("there are not {count} depths of 32 bits")));
        }
        Ok(())
    }

    /// Returns the number of components of the tile.
    pub(crate) fn count(&self) -> usize {
        self.regions.as_ref().map_or(1, Packed::len)
    }

    /// Returns the number of the component of a triangle.
    pub(crate) fn number(&self, triangle: usize) -> usize {
        let (components, triangle) = match triangle.checked_sub(self.core_triangles) {
            None => (&self.components[0], triangle),
            Some(triangle) => (&self.components[1], triangle),
        };
        components
            .as_ref()
            .map_or(0, |components| components.get(triangle) as usize)
    }

    /// Returns the properties of a component by its number.
    pub(crate) fn component(&self, number: usize) -> Component {
        Component {
            region: self.regions.as_ref().map_or(0, |regions| regions.get(number)),
            depth: self.depths.as_ref().map_or(0, |depths| unzigzag(depths.get(number))),
            is_hole: is_set(&self.holes, number),
        }
    }

    pub(crate) fn byte_size(&self) -> usize {
        let packed = self.components.iter().chain([&self.regions, &self.depths]);
        self.holes.len() + packed.flatten().map(Packed::byte_size).sum::<usize>()
    }
}

/// Decodes a zigzag number of 32 bits: 0, 1, 2, 3 stand for 0, −1, 1, −2.
fn unzigzag(value: u64) -> i32 {
    let value = value as u32;
    (value >> 1) as i32 ^ -((value & 1) as i32)
}
