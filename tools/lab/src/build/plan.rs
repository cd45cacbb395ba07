//! The sets of points that are triangulated, each once for all tables that contain it.

use std::fmt;

use distributions::Kind;

/// The distributions of the thesis.
pub const KINDS: [Kind; 3] = [Kind::Uniform, Kind::Kuzmin, Kind::LineSingularity];
/// The segments for each point when the number of points varies.
pub const ALPHA: f64 = 0.5;

/// A set of points, and of segments if `alpha` is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Data {
    pub kind: Kind,
    pub points: u64,
    pub alpha: Option<f64>,
}

impl fmt::Display for Data {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} points, {}", self.points, self.kind)?;
        match self.alpha {
            Some(alpha) => write!(f, ", α = {alpha}"),
            None => Ok(()),
        }
    }
}

/// All sets of points of an experiment.
pub struct BuildPlan {
    pub kinds: Vec<Kind>,
    pub sizes: Vec<u64>,
    pub alphas: Vec<f64>,
    /// The number of points when the share of segments varies.
    pub alpha_size: u64,
    data: Vec<Data>,
}

impl BuildPlan {
    /// Creates the plan for these distributions, sizes and shares, without duplicates and in order.
    pub fn new(kinds: &[Kind], sizes: &[u64], alphas: &[f64], alpha_size: Option<u64>) -> Self {
        let (mut sizes, mut alphas) = (sizes.to_vec(), alphas.to_vec());
        let kinds: Vec<Kind> = KINDS.into_iter().filter(|kind| kinds.contains(kind)).collect();
        sizes.sort_unstable();
        sizes.dedup();
        alphas.sort_by(f64::total_cmp);
        alphas.dedup();
        let alpha_size = alpha_size.unwrap_or_else(|| sizes.get(sizes.len() / 2).copied().unwrap_or(0));
        let mut data = Vec::new();
        for &kind in &kinds {
            let by_size = sizes
                .iter()
                .flat_map(|&points| [None, Some(ALPHA)].map(|alpha| Data { kind, points, alpha }));
            let by_alpha = alphas.iter().map(|&alpha| Data {
                kind,
                points: alpha_size,
                alpha: Some(alpha),
            });
            for one in by_size.chain(by_alpha) {
                if !data.contains(&one) {
                    data.push(one);
                }
            }
        }
        Self {
            kinds,
            sizes,
            alphas,
            alpha_size,
            data,
        }
    }

    /// Returns each set of points once.
    pub fn data(&self) -> &[Data] {
        &self.data
    }

    /// Returns the largest number of points of a set.
    pub fn largest(&self) -> u64 {
        self.data.iter().map(|data| data.points).max().unwrap_or(0)
    }

    /// Returns whether peers triangulate a set too. Only those of the first distribution are: the
    /// distribution hardly matters to peers, and they take most of the time.
    pub fn has_peers(&self, data: &Data) -> bool {
        self.kinds.first() == Some(&data.kind)
    }

    /// Returns whether a set is triangulated under a hard limit too; only those of the first
    /// distribution are.
    pub fn is_limited(&self, data: &Data) -> bool {
        self.has_peers(data) && data.alpha.is_none_or(|alpha| alpha == ALPHA) && self.sizes.contains(&data.points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_set_of_points_occurs_once() {
        let plan = BuildPlan::new(&KINDS, &[200, 100, 200, 300], &[0.5, 0.1, 0.1], None);
        assert_eq!((plan.alpha_size, plan.largest()), (200, 300));
        // Three sizes with segments and without, and one share that is not among these.
        assert_eq!(plan.data().len(), 3 * (3 * 2 + 1));
        let limited = plan.data().iter().filter(|data| plan.is_limited(data)).count();
        assert_eq!(limited, 6);
        let elsewhere = BuildPlan::new(&[Kind::Kuzmin, Kind::Kuzmin], &[100], &[0.5], Some(50));
        assert_eq!(elsewhere.data().len(), 3);
        assert_eq!(
            elsewhere
                .data()
                .iter()
                .filter(|data| elsewhere.is_limited(data))
                .count(),
            2
        );
    }
}
