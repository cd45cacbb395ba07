//! The bytes of a transaction in the log.
//!
//! The number of its record numbers, and then each call.

use bytes::{Buf, BufMut, Bytes};

use crate::edit::{MAX_CALL_BYTES, PointCalls, decode_call, encode_call};

/// Returns the bytes of a transaction.
pub(super) fn encode(calls: &PointCalls) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(8 + MAX_CALL_BYTES * calls.all.len());
    bytes.put_u64_le(calls.records);
    for &call in &calls.all {
        encode_call(call, &mut bytes);
    }
    bytes
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edit::PointCall;
    use crate::geometry::Point;

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
