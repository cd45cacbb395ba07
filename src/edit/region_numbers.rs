//! The numbers of the regions of an edited file.
//!
//! Regions keep their former numbers as far as these are still free, so that the component tables
//! of tiles that are not affected need not be written again.

use foldhash::{HashMap, HashMapExt};

use crate::store::Metadata;

/// The number of a region that had none.
pub(crate) const NEW: u64 = u64::MAX;

/// A region to be numbered.
#[derive(Clone, Copy)]
pub(crate) struct ToNumber {
    /// Its former number, or [`NEW`].
    pub(crate) previous: u64,
    /// Whether it may extend over several tiles.
    pub(crate) is_spanning: bool,
}

/// The numbers of regions.
pub(crate) struct RegionNumbers {
    pub(crate) all: Vec<u64>,
    /// The number of regions that may extend over several tiles, or might before.
    pub(crate) spanning: u64,
}

/// Numbers regions, given the number of all. Those that may extend over several tiles get the first
/// numbers. Each region keeps its former number where possible.
pub(crate) fn number_regions(regions: &[ToNumber], metadata: &Metadata) -> RegionNumbers {
    let count = regions.len() as u64;
    let spanning_now = regions.iter().filter(|region| region.is_spanning).count() as u64;
    let spanning = spanning_now.max(metadata.spanning_regions.min(count));
    let mut is_taken = vec![false; regions.len()];
    let mut all = vec![None; regions.len()];
    for (region, number) in regions.iter().zip(&mut all) {
        let wanted = region.previous;
        let fits = wanted < count && (wanted < spanning || !region.is_spanning);
        if fits && !is_taken[wanted as usize] {
            is_taken[wanted as usize] = true;
            *number = Some(wanted);
        }
    }
    // Spanning regions take free numbers first. Theirs must be among the first numbers, so other
    // regions may have to give these up.
    let mut low = 0;
    let mut displaced = Vec::new();
    let mut holder: HashMap<u64, usize> = HashMap::new();
    for (index, (number, region)) in all.iter().zip(regions).enumerate() {
        if let Some(number) = number.filter(|number| *number < spanning)
            && !region.is_spanning
        {
            holder.insert(number, index);
        }
    }
    for index in 0..regions.len() {
        if all[index].is_some() || !regions[index].is_spanning {
            continue;
        }
        while low < spanning && is_taken[low as usize] && !holder.contains_key(&low) {
            low += 1;
        }
        if let Some(other) = holder.remove(&low) {
            displaced.push(other);
        }
        is_taken[low as usize] = true;
        all[index] = Some(low);
        low += 1;
    }
    for &index in &displaced {
        all[index] = None;
    }
    let mut free = (0..count).filter(|&number| !is_taken[number as usize]);
    let all = all
        .into_iter()
        .map(|number| number.or_else(|| free.next()).unwrap_or(NEW));
    RegionNumbers {
        all: all.collect(),
        spanning,
    }
}
