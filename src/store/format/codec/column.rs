//! Columns: values at equal distances, each coded as its difference from the one before.

use crate::store::format::codec::planes::{Cursor, Planes, unzigzag, with_planes};
use crate::store::format::damage::Damage;

/// The kinds of columns, as they are stored.
pub(super) const INTEGERS: u8 = 0;
pub(super) const FLOATS: u8 = 1;
pub(super) const DECIMALS: u8 = 2;

/// How the values of a column are coded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Coding {
    /// Unsigned integers of `width` bytes.
    Integers { width: u8 },
    /// The bits of floating-point numbers.
    Floats,
    /// Floating-point numbers (`base` + `step` · i) / `divisor` for integers i.
    Decimals(Decimals),
}

/// Numbers (`base` + `step` · i) / `divisor`, rounded to a floating-point number whose bits are
/// corrected by a small integer. With the correction, numbers that were computed from integers
/// with rounding errors, as coordinates of LAS files are, need no search for the scale and offset
/// that they were computed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Decimals {
    pub(super) base: i64,
    pub(super) step: i64,
    pub(super) divisor: f64,
    /// Whether a plane of corrections follows.
    pub(super) has_corrections: bool,
}

/// The coding of a column, and the number of its byte planes, at most 8.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    pub(super) coding: Coding,
    pub(super) planes: u8,
}

impl Column {
    /// Returns the bytes per value in the decoded buffer.
    pub(super) fn width(self) -> usize {
        match self.coding {
            Coding::Integers { width } => width.into(),
            Coding::Floats | Coding::Decimals(_) => 8,
        }
    }

    pub(super) fn read(cursor: &mut Cursor<'_>) -> Result<Self, Damage> {
        let [kind, width, planes, has_corrections] = cursor.array()?;
        let coding = match kind {
            INTEGERS => Coding::Integers { width },
            FLOATS => Coding::Floats,
            DECIMALS => Coding::Decimals(Decimals {
                base: i64::from_le_bytes(cursor.array()?),
                step: i64::from_le_bytes(cursor.array()?),
                divisor: f64::from_le_bytes(cursor.array()?),
                has_corrections: has_corrections == 1,
            }),
            _ => return Err(Damage::new(format!("its plan has a column of kind {kind}"))),
        };
        let this = Self { coding, planes };
        if !(1..=8).contains(&this.width()) || planes > 8 {
            return Err(Damage::new("its plan has a column of a wrong width"));
        }
        Ok(this)
    }

    /// Decodes the column into `rows` of `stride` bytes each, from byte `at` of each row on.
    pub(super) fn decode(
        self,
        cursor: &mut Cursor<'_>,
        rows: &mut [u8],
        stride: usize,
        at: usize,
    ) -> Result<(), Damage> {
        let count = rows.len() / stride;
        with_planes!(self.planes, PLANES => {
            let planes = cursor.planes::<PLANES>(count)?;
            match self.coding {
                Coding::Integers { width } => with_planes!(width, WIDTH => integers::<WIDTH, PLANES>(planes, rows, stride, at)),
                Coding::Floats => integers::<8, PLANES>(planes, rows, stride, at),
                Coding::Decimals(decimals) if decimals.has_corrections => {
                    let corrections = cursor.planes::<1>(count)?;
                    decimals.decode(planes, |i| unzigzag(corrections.get(i)), rows, stride, at);
                }
                Coding::Decimals(decimals) => decimals.decode(planes, |_| 0, rows, stride, at),
            }
        });
        Ok(())
    }
}

fn integers<const WIDTH: usize, const PLANES: usize>(
    planes: Planes<'_, PLANES>,
    rows: &mut [u8],
    stride: usize,
    at: usize,
) {
    let mut value = 0u64;
    for (row, index) in rows.chunks_exact_mut(stride).zip(0..) {
        value = value.wrapping_add(unzigzag(planes.get(index)) as u64);
        row[at..at + WIDTH].copy_from_slice(&value.to_le_bytes()[..WIDTH]);
    }
}

impl Decimals {
    fn decode<const PLANES: usize>(
        self,
        planes: Planes<'_, PLANES>,
        correction: impl Fn(usize) -> i64,
        rows: &mut [u8],
        stride: usize,
        at: usize,
    ) {
        let mut value = self.base;
        for (row, index) in rows.chunks_exact_mut(stride).zip(0..) {
            value = value.wrapping_add(unzigzag(planes.get(index)).wrapping_mul(self.step));
            let bits = (value as f64 / self.divisor).to_bits();
            let bits = bits.wrapping_add(correction(index) as u64);
            row[at..at + 8].copy_from_slice(&bits.to_le_bytes());
        }
    }
}
