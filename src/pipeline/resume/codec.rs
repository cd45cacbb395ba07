//! The encoding of values in work files: little-endian, field by field, without padding.

/// A value of a work file.
pub(crate) trait Stored: Sized {
    /// Appends the value to bytes.
    fn put(&self, out: &mut Vec<u8>);

    /// Takes a value from the front of bytes. Returns `None` if bytes are missing or invalid.
    fn take(from: &mut &[u8]) -> Option<Self>;
}

/// Returns the value that bytes encode, or `None` if they are not exactly one value.
pub(crate) fn decoded<T: Stored>(mut bytes: &[u8]) -> Option<T> {
    let value = T::take(&mut bytes)?;
    bytes.is_empty().then_some(value)
}

/// Stores structs field by field, in the order in which the fields are named.
macro_rules! stored {
    ($($value:ty { $($field:tt),* $(,)? })*) => {$(
        impl $crate::pipeline::resume::codec::Stored for $value {
            fn put(&self, out: &mut Vec<u8>) {
                $($crate::pipeline::resume::codec::Stored::put(&self.$field, out);)*
            }

            fn take(from: &mut &[u8]) -> Option<Self> {
                Some(Self { $($field: $crate::pipeline::resume::codec::Stored::take(from)?),* })
            }
        }
    )*};
}
pub(crate) use stored;

macro_rules! stored_numbers {
    ($($number:ty)*) => {$(
        impl Stored for $number {
            fn put(&self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }

            fn take(from: &mut &[u8]) -> Option<Self> {
                let (first, rest) = from.split_first_chunk()?;
                *from = rest;
                Some(Self::from_le_bytes(*first))
            }
        }
    )*};
}
stored_numbers!(u8 u32 i32 u64 f64);

impl Stored for usize {
    fn put(&self, out: &mut Vec<u8>) {
        (*self as u64).put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        u64::take(from)?.try_into().ok()
    }
}

impl Stored for bool {
    fn put(&self, out: &mut Vec<u8>) {
        u8::from(*self).put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let byte = u8::take(from)?;
        (byte < 2).then_some(byte == 1)
    }
}

impl Stored for String {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        out.extend_from_slice(self.as_bytes());
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let length = usize::take(from)?;
        let (text, rest) = from.split_at_checked(length)?;
        *from = rest;
        Self::from_utf8(text.to_vec()).ok()
    }
}

impl<T: Stored> Stored for Option<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.is_some().put(out);
        if let Some(value) = self {
            value.put(out);
        }
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        match bool::take(from)? {
            true => T::take(from).map(Some),
            false => Some(None),
        }
    }
}

/// Each item takes at least one byte, so a length above the number of bytes left is invalid.
impl<T: Stored> Stored for Vec<T> {
    fn put(&self, out: &mut Vec<u8>) {
        self.len().put(out);
        self.iter().for_each(|item| item.put(out));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let length = usize::take(from)?;
        if length > from.len() {
            return None;
        }
        (0..length).map(|_| T::take(from)).collect()
    }
}

impl<T: Stored + Default, const N: usize> Stored for [T; N] {
    fn put(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|item| item.put(out));
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        let mut items = [(); N].map(|()| T::default());
        for item in &mut items {
            *item = T::take(from)?;
        }
        Some(items)
    }
}

impl<A: Stored, B: Stored> Stored for (A, B) {
    fn put(&self, out: &mut Vec<u8>) {
        self.0.put(out);
        self.1.put(out);
    }

    fn take(from: &mut &[u8]) -> Option<Self> {
        Some((A::take(from)?, B::take(from)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_what_they_were_and_bytes_that_are_cut_short_are_none() {
        type All = (Vec<(u32, Option<String>)>, ([[f64; 2]; 2], bool));
        let value: All = (
            vec![(7, None), (u32::MAX, Some("Łódź".to_owned()))],
            ([[0.5, -0.0], [1e200, 3.0]], true),
        );
        let mut bytes = Vec::new();
        value.put(&mut bytes);
        assert_eq!(decoded::<All>(&bytes), Some(value));
        for length in 0..bytes.len() {
            assert_eq!(decoded::<All>(&bytes[..length]), None, "{length} bytes");
        }
        bytes.push(0);
        assert_eq!(decoded::<All>(&bytes), None);
    }

    #[test]
    fn lists_longer_than_their_bytes_take_no_memory() {
        let mut bytes = Vec::new();
        u64::MAX.put(&mut bytes);
        assert_eq!(decoded::<Vec<u64>>(&bytes), None);
        assert_eq!(decoded::<String>(&bytes), None);
    }
}
