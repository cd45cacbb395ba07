//! The bytes of a transaction in the log.
//!
//! The number of its record numbers, and then each call: a code, positions, and what the call gives.

use bytes::{Buf, BufMut, Bytes, TryGetError};

use crate::edit::{PointCall, PointCalls};
use crate::geometry::Point;

const INSERT: u8 = 0;
const DELETE: u8 = 1;
const MOVE: u8 = 2;
const SET_Z: u8 = 3;
/// The most bytes of a call.
const MAX_CALL: usize = 33;

/// Returns the bytes of a transaction.
pub(super) fn encode(calls: &PointCalls) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(8 + MAX_CALL * calls.all.len());
    bytes.put_u64_le(calls.records);
    for &call in &calls.all {
        encode_call(call, &mut bytes);
    }
    bytes
}

fn encode_call(call: PointCall, bytes: &mut Vec<u8>) {
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

/// Returns the transaction that has these bytes; `None` if none has.
pub(super) fn decode(mut bytes: Bytes) -> Option<PointCalls> {
    let mut calls = PointCalls::default();
    calls.records = bytes.try_get_u64_le().ok()?;
    while !bytes.is_empty() {
        let call = decode_call(&mut bytes).ok()??;
        let (points, z) = (call.positions(), call.z());
        if points.into_iter().flatten().any(|point| !point.is_valid()) || z.is_some_and(f64::is_infinite) {
            return None;
        }
        calls.push(call);
    }
    Some(calls)
}

/// Decodes a call; `None` if its code is unknown.
fn decode_call(bytes: &mut Bytes) -> Result<Option<PointCall>, TryGetError> {
    let (code, first) = (bytes.try_get_u8()?, decode_point(bytes)?);
    Ok(Some(match code {
        INSERT => PointCall::Insert(first, bytes.try_get_f64_le()?, bytes.try_get_u64_le()?),
        DELETE => PointCall::Delete(first),
        MOVE => PointCall::Move([first, decode_point(bytes)?]),
        SET_Z => PointCall::SetZ(first, bytes.try_get_f64_le()?),
        _ => return Ok(None),
    }))
}

fn decode_point(bytes: &mut Bytes) -> Result<Point, TryGetError> {
    Ok(Point::new(bytes.try_get_f64_le()?, bytes.try_get_f64_le()?).normalized())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_kinds() -> PointCalls {
        let (a, b) = (Point::new(1.5, -2.0), Point::new(0.0, 1e30));
        let mut calls = PointCalls::default();
        calls.records = 7;
        for call in [
            PointCall::Insert(a, 3.25, u64::MAX),
            PointCall::Delete(b),
            PointCall::Move([a, b]),
            PointCall::SetZ(b, -0.5),
        ] {
            calls.push(call);
        }
        calls
    }

    #[test]
    fn transactions_are_decoded_as_they_were_encoded() {
        let calls = all_kinds();
        let decoded = decode(encode(&calls).into()).unwrap();
        assert_eq!((decoded.records, &decoded.all), (calls.records, &calls.all));
        assert!(decoded.has_moves());
    }

    #[test]
    fn parts_of_transactions_and_unknown_codes_are_rejected() {
        let bytes = encode(&all_kinds());
        let ends = [8, 41, 58, 91];
        for length in 0..bytes.len() {
            let is_whole = decode(bytes[..length].to_vec().into()).is_some();
            assert_eq!(is_whole, ends.contains(&length), "{length} bytes");
        }
        let mut unknown = bytes.clone();
        unknown[8] = 9;
        assert!(decode(unknown.into()).is_none());
        let mut infinite = bytes;
        infinite[9..17].copy_from_slice(&f64::NAN.to_le_bytes());
        assert!(decode(infinite.into()).is_none());
    }
}
