//! The digest identifies a triangulation, independent of how it is cut into tiles.
//!
//! A digest contains one sum modulo 2¹²⁸ for each kind of element. Each sum adds one hash per
//! element. So a digest can be kept up to date: the hashes of elements that go are subtracted, and
//! those of elements that come are added.
//!
//! The hash is XXH3 (128 bits, seed 0) of these bytes. Coordinates and z are the bits of f64
//! values, and all numbers are little-endian.
//!
//! - Triangles and holes: x and y of each corner, counter-clockwise, starting with the
//!   lexicographically smallest corner.
//! - Vertices: x, y.
//! - Constraint edges: x and y of the lexicographically smaller end, then of the larger end.
//! - Vertices with z: x, y, z.
//! - Edge sources: as for the constraint edge, then the code of the source, a u64, as seen from the
//!   smaller end: 0 for a break line, 1 for a wall, 2 for an obstacle whose interior is on the
//!   left, 3 for one whose interior is on the right.
//! - Sites: x, y, and the id: a byte 0 and the number of the site, a u64; or a byte 1 and the id in
//!   UTF-8, if the site has one of its own.

use std::fmt;
use std::ops::{AddAssign, SubAssign};

use xxhash_rust::xxh3::xxh3_128;

use crate::geometry::Point;
use crate::store::format::edge_source::EdgeSource;
use crate::store::format::generated::directory as schema;

/// A number of elements and the sum of their hashes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DigestSum {
    /// The number of elements.
    pub count: u64,
    /// The sum of the hashes, modulo 2¹²⁸.
    pub sum: u128,
}

impl DigestSum {
    /// Adds an element by its hash.
    #[inline]
    pub(crate) fn add_hash(&mut self, hash: u128) {
        self.count = self.count.wrapping_add(1);
        self.sum = self.sum.wrapping_add(hash);
    }

    /// Removes an element by its hash.
    #[inline]
    pub(crate) fn remove_hash(&mut self, hash: u128) {
        self.count = self.count.wrapping_sub(1);
        self.sum = self.sum.wrapping_sub(hash);
    }

    fn add(&mut self, bytes: &[u8]) {
        self.add_hash(xxh3_128(bytes));
    }

    /// Returns the count, and the two halves of the sum, the lower one first.
    pub(crate) fn to_words(self) -> [u64; 3] {
        [self.count, self.sum as u64, (self.sum >> 64) as u64]
    }

    pub(crate) fn from_words([count, low, high]: [u64; 3]) -> Self {
        let sum = u128::from(high) << 64 | u128::from(low);
        Self { count, sum }
    }
}

/// Counts wrap around too: those in a file may be wrong.
impl AddAssign for DigestSum {
    fn add_assign(&mut self, other: Self) {
        self.count = self.count.wrapping_add(other.count);
        self.sum = self.sum.wrapping_add(other.sum);
    }
}

impl SubAssign for DigestSum {
    fn sub_assign(&mut self, other: Self) {
        self.count = self.count.wrapping_sub(other.count);
        self.sum = self.sum.wrapping_sub(other.sum);
    }
}

/// The digest of a triangulation.
///
/// A file stores its digest ([`Metadata::digest`](crate::store::Metadata::digest)). Builds and
/// edits compute it as they write. Compare that with what is in the tiles by
/// [`TileReader::recompute_digest`](crate::store::TileReader::recompute_digest) or
/// [`TileReader::verify`](crate::store::TileReader::verify).
///
/// Its [`Display`](fmt::Display) output has one line for each sum, in the order of the fields, with
/// the name, the count, and the sum in hexadecimal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digest {
    /// All triangles.
    pub triangles: DigestSum,
    /// All vertices.
    pub vertices: DigestSum,
    /// Constraint edges. Each is hashed from its lexicographically smaller end to its larger end.
    pub constraint_edges: DigestSum,
    /// Triangles in holes, with the same hashes as in `triangles`.
    pub holes: DigestSum,
    /// All vertices with their z; none in files without z.
    pub vertices_with_z: DigestSum,
    /// The sources of constraint edges: for each edge and each source of it, the ends of the edge
    /// with the kind of the line and the side of an obstacle's interior. The numbers of lines do
    /// not count.
    pub edge_sources: DigestSum,
    /// The sites with their positions and ids.
    pub sites: DigestSum,
}

impl Digest {
    /// The names of the sums, in the order of the fields.
    const NAMES: [&str; 7] = [
        "triangles",
        "vertices",
        "constraint-edges",
        "holes",
        "vertices-with-z",
        "edge-sources",
        "sites",
    ];

    /// Adds a vertex.
    pub fn add_vertex(&mut self, p: Point) {
        self.vertices.add(point_bytes([p]).as_flattened());
    }

    /// Adds the z of a vertex. The vertex must be added with [`add_vertex`](Self::add_vertex) too.
    pub fn add_z(&mut self, p: Point, z: f64) {
        let [x, y, z] = [p.x, p.y, z].map(f64::to_le_bytes);
        self.vertices_with_z.add([x, y, z].as_flattened());
    }

    /// Adds a triangle. Its `corners` must be in counter-clockwise order.
    pub fn add_triangle(&mut self, corners: [Point; 3]) {
        self.triangles.add_hash(triangle_hash(corners));
    }

    /// Adds a triangle to the holes. It must be added with [`add_triangle`](Self::add_triangle)
    /// too.
    pub fn add_hole(&mut self, corners: [Point; 3]) {
        self.holes.add_hash(triangle_hash(corners));
    }

    /// Adds a constraint edge.
    pub fn add_constraint_edge(&mut self, ends: [Point; 2]) {
        let (ends, _) = smaller_first(ends);
        self.constraint_edges.add(point_bytes(ends).as_flattened());
    }

    /// Adds a source of a constraint edge, as seen from the first end to the second. The edge must
    /// be added with [`add_constraint_edge`](Self::add_constraint_edge) too.
    pub fn add_edge_source(&mut self, ends: [Point; 2], source: EdgeSource) {
        let (ends, is_turned) = smaller_first(ends);
        let source = if is_turned { source.reversed() } else { source };
        let mut bytes = [0; 40];
        bytes[..32].copy_from_slice(point_bytes(ends).as_flattened());
        bytes[32..].copy_from_slice(&source.code().to_le_bytes());
        self.edge_sources.add(&bytes);
    }

    /// Adds a site with its number, and with its id if it has one of its own.
    pub fn add_site(&mut self, p: Point, number: u64, id: Option<&str>) {
        let mut bytes = point_bytes([p]).as_flattened().to_vec();
        match id {
            None => {
                bytes.push(0);
                bytes.extend_from_slice(&number.to_le_bytes());
            }
            Some(id) => {
                bytes.push(1);
                bytes.extend_from_slice(id.as_bytes());
            }
        }
        self.sites.add(&bytes);
    }

    /// Adds vertices, and their z unless `z` is empty.
    pub(crate) fn add_vertices(&mut self, points: &[Point], z: &[f64]) {
        points.iter().for_each(|&p| self.add_vertex(p));
        points.iter().zip(z).for_each(|(&p, &z)| self.add_z(p, z));
    }

    /// Adds sites, given as pairs of an index into `points` and a number. `ids` is empty, or has an
    /// id for each site, which is empty if the number is the id.
    pub(crate) fn add_sites(&mut self, points: &[Point], sites: &[(u32, u64)], ids: &[String]) {
        for (index, &(vertex, number)) in sites.iter().enumerate() {
            let id = ids.get(index).map(String::as_str).filter(|id| !id.is_empty());
            self.add_site(points[vertex as usize], number, id);
        }
    }

    fn sums(&self) -> [DigestSum; 7] {
        let Self {
            triangles,
            vertices,
            constraint_edges,
            holes,
            vertices_with_z,
            edge_sources,
            sites,
        } = *self;
        [
            triangles,
            vertices,
            constraint_edges,
            holes,
            vertices_with_z,
            edge_sources,
            sites,
        ]
    }

    fn sums_mut(&mut self) -> [&mut DigestSum; 7] {
        [
            &mut self.triangles,
            &mut self.vertices,
            &mut self.constraint_edges,
            &mut self.holes,
            &mut self.vertices_with_z,
            &mut self.edge_sources,
            &mut self.sites,
        ]
    }

    /// Returns the line of `Display` that this sum has.
    fn line(name: &str, DigestSum { count, sum }: DigestSum) -> String {
        format!("{name:<16} {count:>12} {sum:032x}")
    }

    /// Returns the first lines of `Display` that differ, of this digest and of the other one;
    /// `None` if the digests are equal.
    pub(crate) fn first_difference(&self, other: &Self) -> Option<[String; 2]> {
        let pairs = self.sums().into_iter().zip(other.sums());
        let mut pairs = Self::NAMES.into_iter().zip(pairs);
        let (name, (this, other)) = pairs.find(|(_, (this, other))| this != other)?;
        Some([this, other].map(|sum| Self::line(name, sum)))
    }

    /// Returns each count, and the two halves of each sum, the lower one first, in the order of the
    /// fields.
    pub(crate) fn to_words(self) -> [[u64; 3]; 7] {
        self.sums().map(DigestSum::to_words)
    }

    /// Returns the digest that [`to_words`](Self::to_words) was called on.
    pub(crate) fn from_words(words: [[u64; 3]; 7]) -> Self {
        let mut this = Self::default();
        for (sum, words) in this.sums_mut().into_iter().zip(words) {
            *sum = DigestSum::from_words(words);
        }
        this
    }

    /// Returns the sums as a file stores them, in the order of the fields.
    pub(crate) fn to_schema(self) -> [schema::Sum; 7] {
        self.to_words()
            .map(|[count, low, high]| schema::Sum::new(count, low, high))
    }

    /// Returns the digest from the sums that a file stores, in the order of the fields.
    pub(crate) fn from_schema(sums: [&schema::Sum; 7]) -> Self {
        Self::from_words(sums.map(|sum| [sum.count(), sum.low(), sum.high()]))
    }
}

/// Returns the hash of a triangle, whose corners are in counter-clockwise order.
#[inline]
pub(crate) fn triangle_hash([a, b, c]: [Point; 3]) -> u128 {
    // Branch-free, because which corner is the smallest is unpredictable. Builds hash all
    // triangles.
    let is_less = |p: Point, q: Point| (p.x < q.x) | ((p.x == q.x) & (p.y < q.y));
    let [ab, bc, ca] = [is_less(a, b), is_less(b, c), is_less(c, a)];
    let first = usize::from(!ab & bc) + 2 * usize::from(!bc & ca);
    let corners = [a, b, c, a, b];
    let corners = [corners[first], corners[first + 1], corners[first + 2]];
    xxh3_128(point_bytes(corners).as_flattened())
}

/// Returns the ends of an edge, the lexicographically smaller one first, and whether they were
/// swapped.
fn smaller_first([a, b]: [Point; 2]) -> ([Point; 2], bool) {
    if a.lex_cmp(b).is_lt() {
        ([a, b], false)
    } else {
        ([b, a], true)
    }
}

fn point_bytes<const N: usize>(points: [Point; N]) -> [[u8; 16]; N] {
    points.map(|p| {
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&p.x.to_le_bytes());
        bytes[8..].copy_from_slice(&p.y.to_le_bytes());
        bytes
    })
}

impl AddAssign for Digest {
    fn add_assign(&mut self, other: Self) {
        for (sum, other) in self.sums_mut().into_iter().zip(other.sums()) {
            *sum += other;
        }
    }
}

impl SubAssign for Digest {
    fn sub_assign(&mut self, other: Self) {
        for (sum, other) in self.sums_mut().into_iter().zip(other.sums()) {
            *sum -= other;
        }
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines = Self::NAMES.into_iter().zip(self.sums());
        let lines: Vec<String> = lines.map(|(name, sum)| Self::line(name, sum)).collect();
        f.write_str(&lines.join("\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::format::edge_source::LineKind;

    fn at(x: f64, y: f64) -> Point {
        Point::new(x, y)
    }

    fn of(add: impl Fn(&mut Digest)) -> Digest {
        let mut digest = Digest::default();
        add(&mut digest);
        digest
    }

    /// The bytes that are hashed, written out, so that they cannot change unnoticed.
    #[test]
    fn each_sum_hashes_the_bytes_that_the_table_says() {
        let (a, b, c) = (at(1.0, 5.0), at(1.0, 7.0), at(-2.0, 6.0));
        let bytes = |numbers: &[f64]| numbers.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let sum = |bytes: &[u8]| DigestSum {
            count: 1,
            sum: xxh3_128(bytes),
        };
        let triangle = sum(&bytes(&[-2.0, 6.0, 1.0, 5.0, 1.0, 7.0]));
        for corners in [[a, b, c], [b, c, a], [c, a, b]] {
            assert_eq!(of(|d| d.add_triangle(corners)).triangles, triangle);
            assert_eq!(of(|d| d.add_hole(corners)).holes, triangle);
        }
        assert_ne!(of(|d| d.add_triangle([a, c, b])).triangles, triangle);
        assert_eq!(of(|d| d.add_vertex(a)).vertices, sum(&bytes(&[1.0, 5.0])));
        assert_eq!(of(|d| d.add_z(a, 9.5)).vertices_with_z, sum(&bytes(&[1.0, 5.0, 9.5])));
        let edge = bytes(&[1.0, 5.0, 1.0, 7.0]);
        let with_code = |code: u64| sum(&[&edge[..], &code.to_le_bytes()].concat());
        for ends in [[a, b], [b, a]] {
            assert_eq!(of(|d| d.add_constraint_edge(ends)).constraint_edges, sum(&edge));
        }
        for (kind, forward, backward) in [
            (LineKind::BreakLine, 0, 0),
            (LineKind::Wall, 1, 1),
            (LineKind::Obstacle, 2, 3),
        ] {
            for number in [0, 77, EdgeSource::MAX_NUMBER] {
                let source = EdgeSource::new(kind, number);
                let seen = |ends: [Point; 2], source| of(|d| d.add_edge_source(ends, source)).edge_sources;
                assert_eq!(seen([a, b], source), with_code(forward));
                assert_eq!(seen([b, a], source), with_code(backward));
                assert_eq!(seen([b, a], source.reversed()), with_code(forward));
            }
        }
        let site = |id: &[u8]| sum(&[&bytes(&[1.0, 5.0])[..], id].concat());
        let number = 0x0102_0304_0506_0708;
        assert_eq!(
            of(|d| d.add_site(a, number, None)).sites,
            site(b"\0\x08\x07\x06\x05\x04\x03\x02\x01")
        );
        assert_eq!(of(|d| d.add_site(a, number, Some("ä"))).sites, site(b"\x01\xc3\xa4"));
    }

    #[test]
    fn what_was_added_can_be_subtracted_and_a_difference_is_named() {
        let all = of(|d| {
            d.add_vertex(at(1.0, 2.0));
            d.add_z(at(1.0, 2.0), 3.0);
            d.add_triangle([at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)]);
            d.add_hole([at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)]);
            d.add_constraint_edge([at(0.0, 0.0), at(1.0, 0.0)]);
            d.add_edge_source([at(0.0, 0.0), at(1.0, 0.0)], EdgeSource::new(LineKind::Wall, 3));
            d.add_site(at(1.0, 2.0), 3, None);
        });
        assert!(all.sums().iter().all(|sum| sum.count == 1 && sum.sum != 0));
        let mut sum = all;
        sum += all;
        sum -= all;
        assert_eq!(sum, all);
        sum -= all;
        assert_eq!(sum, Digest::default());
        let [text, zero] = [all, sum].map(|digest| digest.to_string());
        for ((index, name), (line, other)) in Digest::NAMES.iter().enumerate().zip(text.lines().zip(zero.lines())) {
            let mut changed = all;
            *changed.sums_mut()[index] = DigestSum::default();
            assert!(line.starts_with(name), "{line}");
            assert_eq!(
                changed.first_difference(&all),
                Some([other.to_owned(), line.to_owned()])
            );
        }
        assert_eq!(all.first_difference(&all), None);
        assert_eq!(text.lines().count(), 7);
    }
}
