//! The links of components that an edit finds.

/// Pairs of linked components, by their nodes: the one whose table has the link, and the one that it
/// leads to.
#[derive(Default)]
pub(crate) struct NewLinks {
    all: Vec<[u32; 2]>,
    /// The number of pairs, sorted and without repetitions, when the list was last tidied.
    tidy: usize,
}

impl NewLinks {
    /// Adds a link, which may be there already.
    pub(crate) fn add(&mut self, link: [u32; 2]) {
        if self.all.last() == Some(&link) {
            return;
        }
        self.all.push(link);
        // Most links are found many times.
        if self.all.len() > 2 * self.tidy + 64 {
            self.finish();
        }
    }

    /// Sorts the links.
    pub(crate) fn finish(&mut self) {
        self.all.sort_unstable();
        self.all.dedup();
        self.tidy = self.all.len();
    }

    /// Returns all links.
    pub(crate) fn all(&self) -> &[[u32; 2]] {
        &self.all
    }

    /// Returns what a component is linked to, once the links are sorted.
    pub(crate) fn of(&self, node: u32) -> impl Iterator<Item = u32> {
        let start = self.all.partition_point(|[from, _]| *from < node);
        let links = self.all[start..].iter();
        links.take_while(move |[from, _]| *from == node).map(|[_, to]| *to)
    }

    /// Returns the bytes of memory that it takes.
    pub(crate) fn byte_size(&self) -> u64 {
        size_of_val(&*self.all) as u64
    }
}
