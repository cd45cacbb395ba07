//! The bytes of a call: a code, positions, and what the call gives.

use bytes::{Buf, BufMut, TryGetError};

use crate::edit::points::call::PointCall;
use crate::geometry::Point;

const INSERT: u8 = 0;
const DELETE: u8 = 1;
const MOVE: u8 = 2;
const SET_Z: u8 = 3;

/// The most bytes of a call.
pub(crate) const MAX_CALL_BYTES: usize = 33;

/// Appends the bytes of a call.
pub(crate) fn encode_call(call: PointCall, bytes: &mut Vec<u8>) {
    let put_point = |bytes: &mut Vec<u8>, point: Point| {
        bytes.put_f64_le(point.x);
        bytes.put_f64_le(point.y);
    };
    match call {
        PointCall::Insert(point, z, record) => {
            bytes.put_u8(INSERT);
            put_point(bytes, point);
            bytes.put_f64_le(z);
            bytes.put_u64_le(record);
        }
        PointCall::Delete(point) => {
            bytes.put_u8(DELETE);
            put_point(bytes, point);
        }
        PointCall::Move(pair) => {
            bytes.put_u8(MOVE);
            pair.into_iter().for_each(|point| put_point(bytes, point));
        }
        PointCall::SetZ(point, z) => {
            bytes.put_u8(SET_Z);
            put_point(bytes, point);
            bytes.put_f64_le(z);
        }
    }
}

/// Decodes a call; `None` if its code is unknown.
pub(crate) fn decode_call(bytes: &mut impl Buf) -> Result<Option<PointCall>, TryGetError> {
    let (code, first) = (bytes.try_get_u8()?, decode_point(bytes)?);
    Ok(Some(match code {
        INSERT => PointCall::Insert(first, bytes.try_get_f64_le()?, bytes.try_get_u64_le()?),
        DELETE => PointCall::Delete(first),
        MOVE => PointCall::Move([first, decode_point(bytes)?]),
        SET_Z => PointCall::SetZ(first, bytes.try_get_f64_le()?),
        _ => return Ok(None),
    }))
}

fn decode_point(bytes: &mut impl Buf) -> Result<Point, TryGetError> {
    Ok(Point::new(bytes.try_get_f64_le()?, bytes.try_get_f64_le()?).normalized())
}
