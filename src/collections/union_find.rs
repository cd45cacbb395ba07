//! Union-find, and union-find with differences of values within a set.

/// Disjoint sets of the numbers from 0.
#[derive(Debug)]
pub(crate) struct UnionFind {
    parents: Vec<u32>,
}

impl UnionFind {
    /// Creates `numbers` sets of one number each.
    pub(crate) fn new(numbers: u32) -> Self {
        Self {
            parents: (0..numbers).collect(),
        }
    }

    /// Adds `numbers` sets of one number each.
    pub(crate) fn grow(&mut self, numbers: u32) {
        let next = self.parents.len() as u32;
        self.parents.extend(next..next + numbers);
    }

    /// Returns the representative of the set of a number.
    pub(crate) fn find(&mut self, mut number: u32) -> u32 {
        loop {
            let parent = self.parents[number as usize];
            if parent == number {
                return number;
            }
            let above = self.parents[parent as usize];
            self.parents[number as usize] = above;
            number = above;
        }
    }

    /// Joins the sets of two numbers. The smaller representative stands for both.
    pub(crate) fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }
}

/// Disjoint sets of the numbers from 0. Each number has a value that is known up to a constant for
/// its set. Differences wrap around: those of a file that is made to harm may add up to any number.
#[derive(Debug)]
pub(crate) struct WeightedUnionFind {
    parents: Vec<u32>,
    /// The value of each number minus that of its parent.
    above_parent: Vec<i32>,
    path: Vec<u32>,
}

impl WeightedUnionFind {
    /// Creates `numbers` sets of one number each.
    pub(crate) fn new(numbers: u32) -> Self {
        Self {
            parents: (0..numbers).collect(),
            above_parent: vec![0; numbers as usize],
            path: Vec::new(),
        }
    }

    /// Adds `numbers` sets of one number each.
    pub(crate) fn grow(&mut self, numbers: u32) {
        let next = self.parents.len() as u32;
        self.parents.extend(next..next + numbers);
        self.above_parent.resize(self.parents.len(), 0);
    }

    /// Returns the representative of the set of a number, and the number's value minus that of the
    /// representative.
    pub(crate) fn find(&mut self, number: u32) -> (u32, i32) {
        self.path.clear();
        let mut root = number;
        while self.parents[root as usize] != root {
            self.path.push(root);
            root = self.parents[root as usize];
        }
        let mut above = 0;
        for &on_path in self.path.iter().rev() {
            above = self.above_parent[on_path as usize].wrapping_add(above);
            self.above_parent[on_path as usize] = above;
            self.parents[on_path as usize] = root;
        }
        (root, above)
    }

    /// Records that the value of `a` minus that of `b` is `difference`. Returns false if this
    /// contradicts earlier records.
    pub(crate) fn union(&mut self, a: u32, b: u32, difference: i32) -> bool {
        let ((root_a, above_a), (root_b, above_b)) = (self.find(a), self.find(b));
        // The value of the root of `a` minus that of the root of `b`.
        let apart = difference.wrapping_sub(above_a).wrapping_add(above_b);
        if root_a == root_b {
            return apart == 0;
        }
        // The smaller root stands for both sets.
        let (child, parent, above) = if root_a > root_b {
            (root_a, root_b, apart)
        } else {
            (root_b, root_a, apart.wrapping_neg())
        };
        self.parents[child as usize] = parent;
        self.above_parent[child as usize] = above;
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1), ..ProptestConfig::default() })]

        #[test]
        fn differences_are_those_of_hidden_values(
            values in prop::collection::vec(-5i32..5, 1..40),
            pairs in prop::collection::vec((0usize..40, 0usize..40), 0..60),
        ) {
            let n = values.len();
            let mut weighted = WeightedUnionFind::new(n as u32);
            let mut plain = UnionFind::new(n as u32);
            for (a, b) in pairs.into_iter().map(|(a, b)| (a % n, b % n)) {
                prop_assert!(weighted.union(a as u32, b as u32, values[a] - values[b]));
                plain.union(a as u32, b as u32);
                prop_assert!(!weighted.union(a as u32, b as u32, values[a] - values[b] + 1));
            }
            for a in 0..n {
                let (root, above) = weighted.find(a as u32);
                prop_assert_eq!(root, plain.find(a as u32));
                prop_assert!(root as usize <= a);
                prop_assert_eq!(above, values[a] - values[root as usize]);
            }
        }
    }
}
