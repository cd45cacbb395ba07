//! Byte planes: the lowest bytes of all values, then the second lowest bytes, and so on.
//!
//! Differences of neighbours are small, so the upper planes are nearly all 0, and each plane has
//! statistics of its own, which suits the entropy coder.

use crate::store::format::damage::Damage;

/// Maps a signed number to an unsigned one, which is small if the signed one is close to 0.
pub(super) const fn zigzag(value: i64) -> u64 {
    ((value << 1) ^ (value >> 63)) as u64
}

/// Returns the signed number that [`zigzag`] maps to `value`.
pub(super) const fn unzigzag(value: u64) -> i64 {
    (value >> 1) as i64 ^ -((value & 1) as i64)
}

/// Returns the number of planes that values up to `largest` need.
pub(super) const fn planes_for(largest: u64) -> usize {
    (64 - largest.leading_zeros() as usize).div_ceil(8)
}

/// The data of a plan while it is made.
#[derive(Default)]
pub(super) struct PlanData {
    pub(super) bytes: Vec<u8>,
    /// The ends of the parts that have statistics of their own.
    pub(super) ends: Vec<usize>,
}

impl PlanData {
    /// Appends bytes that have statistics of their own.
    pub(super) fn part(&mut self, bytes: impl Iterator<Item = u8>) {
        self.bytes.extend(bytes);
        self.ends.push(self.bytes.len());
    }

    /// Appends the lowest `planes` bytes of all values, plane by plane.
    pub(super) fn planes(&mut self, values: &[u64], planes: usize) {
        for plane in 0..planes {
            self.part(values.iter().map(|value| (value >> (8 * plane)) as u8));
        }
    }

    /// Appends as many planes as the values need. Returns how many these are.
    pub(super) fn all_planes(&mut self, values: &[u64]) -> u8 {
        let planes = planes_for(values.iter().fold(0, |all, value| all | value));
        self.planes(values, planes);
        planes as u8
    }
}

/// Reads the bytes of a plan from front to back.
pub(super) struct Cursor<'a>(&'a [u8]);

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    /// Takes the next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], Damage> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(too_short)?;
        self.0 = rest;
        Ok(taken)
    }

    /// Takes `N` bytes.
    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], Damage> {
        let (&taken, rest) = self.0.split_first_chunk().ok_or_else(too_short)?;
        self.0 = rest;
        Ok(taken)
    }

    /// Takes planes of `count` values.
    pub(super) fn planes<const PLANES: usize>(&mut self, count: usize) -> Result<Planes<'a, PLANES>, Damage> {
        let mut planes = [&[][..]; PLANES];
        for plane in &mut planes {
            *plane = self.take(count)?;
        }
        Ok(Planes(planes))
    }

    /// Returns the bytes that are left.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.0
    }

    /// Checks that nothing is left.
    pub(super) fn end(&self) -> Result<(), Damage> {
        match self.0.len() {
            0 => Ok(()),
            left => Err(Damage::new(format!("its plan has {left} bytes too many"))),
        }
    }
}

fn too_short() -> Damage {
    Damage::new("its plan is cut off")
}

/// Byte planes, all of one length.
#[derive(Clone, Copy)]
pub(super) struct Planes<'a, const PLANES: usize>([&'a [u8]; PLANES]);

impl<const PLANES: usize> Planes<'_, PLANES> {
    /// Returns the value at `index`.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of range.
    #[inline(always)]
    pub(super) fn get(&self, index: usize) -> u64 {
        let mut value = 0;
        for (plane, bytes) in self.0.iter().enumerate() {
            value |= u64::from(bytes[index]) << (8 * plane);
        }
        value
    }
}

/// Calls a function with a constant number of planes, from 0 to 8. `$planes` is at most 8.
macro_rules! with_planes {
    ($planes:expr, $name:ident => $call:expr) => {
        match $planes {
            0 => {
                const $name: usize = 0;
                $call
            }
            1 => {
                const $name: usize = 1;
                $call
            }
            2 => {
                const $name: usize = 2;
                $call
            }
            3 => {
                const $name: usize = 3;
                $call
            }
            4 => {
                const $name: usize = 4;
                $call
            }
            5 => {
                const $name: usize = 5;
                $call
            }
            6 => {
                const $name: usize = 6;
                $call
            }
            7 => {
                const $name: usize = 7;
                $call
            }
            _ => {
                const $name: usize = 8;
                $call
            }
        }
    };
}
pub(super) use with_planes;
