//! The components of a tile: of its core, and of the late triangles around it.

use std::collections::HashMap;

use crate::collections::union_find::UnionFind;
use crate::pipeline::finish::border_mesh::{BorderMesh, KeyedHalfEdge};
use crate::pipeline::records::TileState;

/// The components of a tile, those of the core first.
#[derive(Debug)]
pub(crate) struct TileComponents {
    /// The component of each late triangle.
    pub(crate) of_late: Vec<u32>,
    /// For each component, the first component that it is connected with within the tile: itself,
    /// or an earlier one.
    pub(crate) first: Vec<u32>,
}

impl TileComponents {
    /// Returns the one component of a tile in a build that does not distinguish regions.
    pub(crate) fn one(mesh: &BorderMesh) -> Self {
        Self {
            of_late: vec![0; mesh.late.len()],
            first: vec![0],
        }
    }

    /// Finds the components. A late triangle that is connected with the core within the tile is of
    /// a component of the core.
    pub(crate) fn of(mesh: &BorderMesh, state: &TileState) -> Self {
        let open = state.open_components;
        let node = |keyed: &KeyedHalfEdge| match mesh.late_within(keyed) {
            Ok(late) => open + late as u32,
            Err(component) => component,
        };
        let mut sets = UnionFind::new(open + mesh.late.len() as u32);
        for on_edge in mesh.edges() {
            if let [one, other] = on_edge
                && !mesh.is_constraint(one)
            {
                sets.union(node(one), node(other));
            }
        }
        let mut first: Vec<u32> = (0..state.components).collect();
        let mut of_sets: HashMap<u32, u32> = HashMap::new();
        for component in 0..open {
            first[component as usize] = *of_sets.entry(sets.find(component)).or_insert(component);
        }
        let mut of_late = Vec::with_capacity(mesh.late.len());
        for late in 0..mesh.late.len() as u32 {
            let of_set = of_sets.entry(sets.find(open + late)).or_insert_with(|| {
                let new = first.len() as u32;
                first.push(new);
                new
            });
            of_late.push(*of_set);
        }
        if first.is_empty() {
            first.push(0);
        }
        Self { of_late, first }
    }

    /// Returns the number of components.
    pub(crate) fn count(&self) -> usize {
        self.first.len()
    }
}
