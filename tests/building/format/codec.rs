//! Decodes stored extents as the page describes it, with a Zstandard decoder in pure Rust.

use ruzstd::decoding::FrameDecoder;

use crate::support::flat::{f64_at, u32_at, u64_at};

/// Returns the FlatBuffer of `length` bytes that an extent decodes to.
pub fn decoded(stored: &[u8], codec: u32, length: usize) -> Vec<u8> {
    match codec {
        0 => {
            assert_eq!(stored.len(), length);
            stored.to_vec()
        }
        1 => {
            assert!(length <= 256 * stored.len());
            let mut plan = vec![0; u32_at(stored, 0) as usize];
            assert!(plan.len() <= length + 4);
            let found = FrameDecoder::new().decode_all(&stored[4..], &mut plan).unwrap();
            assert_eq!(found, plan.len());
            of_plan(&plan, length)
        }
        other => panic!("the page has no codec {other}"),
    }
}

struct Column {
    coding: u8,
    width: usize,
    planes: usize,
    corrected: bool,
    /// Base, step and divisor.
    decimals: (i64, i64, f64),
}

struct Section {
    start: usize,
    rows: usize,
    kind: u8,
    width: usize,
    planes: usize,
    columns: Vec<Column>,
}

impl Section {
    fn row(&self) -> usize {
        match self.kind {
            0 => self.columns.iter().map(|column| column.width).sum(),
            1 | 2 => 3 * self.width,
            3 => self.width,
            other => panic!("the page has no sections of kind {other}"),
        }
    }
}

/// The part of a plan that is not read yet.
struct Rest<'a>(&'a [u8]);

impl<'a> Rest<'a> {
    fn take(&mut self, count: usize) -> &'a [u8] {
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        taken
    }

    fn numbers(&mut self, count: usize, planes: usize) -> Vec<u64> {
        let bytes = self.take(count * planes);
        let number = |i| {
            (0..planes)
                .map(|plane| u64::from(bytes[plane * count + i]) << (8 * plane))
                .sum()
        };
        (0..count).map(number).collect()
    }

    fn zigzag(&mut self, count: usize, planes: usize) -> Vec<i64> {
        let signed = |number: u64| match number % 2 {
            0 => (number / 2) as i64,
            _ => -1 - (number / 2) as i64,
        };
        self.numbers(count, planes).into_iter().map(signed).collect()
    }

    fn section(&mut self) -> Section {
        let header = self.take(12);
        let columns = (0..header[9]).map(|_| self.column()).collect();
        Section {
            start: u32_at(header, 0) as usize,
            rows: u32_at(header, 4) as usize,
            kind: header[8],
            width: header[10].into(),
            planes: header[11].into(),
            columns,
        }
    }

    fn column(&mut self) -> Column {
        let &[coding, width, planes, corrected] = self.take(4) else {
            unreachable!("four bytes were taken");
        };
        let decimals = match coding {
            2 => self.take(24),
            _ => &[0; 24],
        };
        assert!(coding == 0 || width == 8);
        Column {
            coding,
            width: width.into(),
            planes: planes.into(),
            corrected: corrected == 1,
            decimals: (
                u64_at(decimals, 0) as i64,
                u64_at(decimals, 8) as i64,
                f64_at(decimals, 16),
            ),
        }
    }
}

fn of_plan(plan: &[u8], length: usize) -> Vec<u8> {
    let mut rest = Rest(plan);
    let count = u32_at(rest.take(4), 0);
    assert!(count <= 64);
    let sections: Vec<Section> = (0..count).map(|_| rest.section()).collect();
    let mut out = vec![0; length];
    let mut end = 0;
    for section in &sections {
        out[end..section.start].copy_from_slice(rest.take(section.start - end));
        end = section.start + section.rows * section.row();
    }
    out[end..].copy_from_slice(rest.take(length - end));
    let mut corners = Vec::new();
    for section in &sections {
        let values = match section.kind {
            0 => {
                put_table(section, &mut rest, &mut out);
                continue;
            }
            1 => {
                corners = read_corners(section, &mut rest);
                corners.clone()
            }
            2 => neighbours(section, &mut rest),
            _ => {
                let mut last = vec![u64::MAX; section.rows];
                for (&corner, side) in corners.iter().zip(0..) {
                    last[corner as usize] = side;
                }
                last
            }
        };
        let width = section.width;
        for (value, i) in values.into_iter().zip(0..) {
            let at = section.start + i * width;
            out[at..at + width].copy_from_slice(&value.to_le_bytes()[..width]);
        }
    }
    assert!(rest.0.is_empty());
    out
}

fn put_table(section: &Section, rest: &mut Rest<'_>, out: &mut [u8]) {
    let mut column_start = section.start;
    for column in &section.columns {
        let numbers = rest.zigzag(section.rows, column.planes);
        let corrections = match column.corrected {
            true => rest.zigzag(section.rows, 1),
            false => vec![0; section.rows],
        };
        let mut sum = 0i64;
        for ((number, correction), row) in numbers.into_iter().zip(corrections).zip(0..) {
            sum = sum.wrapping_add(number);
            let (base, step, divisor) = column.decimals;
            let value = match column.coding {
                2 => {
                    let i = base.wrapping_add(step.wrapping_mul(sum));
                    (i as f64 / divisor).to_bits().wrapping_add(correction as u64)
                }
                _ => sum as u64,
            };
            let at = column_start + row * section.row();
            out[at..at + column.width].copy_from_slice(&value.to_le_bytes()[..column.width]);
        }
        column_start += column.width;
    }
}

fn read_corners(section: &Section, rest: &mut Rest<'_>) -> Vec<u64> {
    let mut planes = || rest.zigzag(section.rows, section.planes);
    let (first, second, third) = (planes(), planes(), planes());
    let mut above = [0; 3];
    let plus = |value: u64, number: i64| value.wrapping_add(number as u64) % (1 << (8 * section.width));
    let rows = (0..section.rows).flat_map(|row| {
        let a = plus(above[0], first[row]);
        let b = plus(if a == above[0] { above[2] } else { a }, second[row]);
        above = [a, b, plus(b, third[row])];
        above
    });
    rows.collect()
}

fn neighbours(section: &Section, rest: &mut Rest<'_>) -> Vec<u64> {
    let flags = rest.take(section.rows);
    let sides = (0..3 * section.rows).filter(|side| flags[side / 3] >> (side % 3) & 1 == 1);
    let sides: Vec<usize> = sides.collect();
    let mut across = vec![u64::MAX; 3 * section.rows];
    for (&side, distance) in sides.iter().zip(rest.numbers(sides.len(), section.planes)) {
        let other = side - distance as usize;
        (across[side], across[other]) = (other as u64, side as u64);
    }
    across
}
