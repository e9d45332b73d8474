//! Stack of a traversal: small and on the machine's stack, with the heap behind it for trees of extreme depth.

/// Entries before the heap is used; sixty are rarely exceeded.
const NEAR: usize = 64;

/// Node to visit, and the least distance at which anything in it may be.
#[derive(Clone, Copy, Default)]
pub(super) struct Entry {
    pub node: u32,
    pub distance: f32,
}

/// Last in, first out.
pub(super) struct Stack {
    near: [Entry; NEAR],
    count: usize,
    far: Vec<Entry>,
}

impl Stack {
    /// Stack with the root on it.
    #[inline(always)]
    pub fn new() -> Self {
        Self::at(0)
    }

    /// Stack with a node on it, whatever its distance.
    #[inline(always)]
    pub fn at(node: u32) -> Self {
        let mut near = [Entry::default(); NEAR];
        near[0].node = node;
        Self { near, count: 1, far: Vec::new() }
    }

    #[inline(always)]
    pub fn push(&mut self, entry: Entry) {
        if self.count < NEAR {
            self.near[self.count] = entry;
            self.count += 1;
        } else {
            self.far.push(entry);
        }
    }

    #[inline(always)]
    pub fn pop(&mut self) -> Option<Entry> {
        if self.count == NEAR
            && let Some(entry) = self.far.pop()
        {
            return Some(entry);
        }
        self.count = self.count.checked_sub(1)?;
        Some(self.near[self.count])
    }

    /// Pushes the children of a mask, so that the nearest is popped first.
    #[inline(always)]
    pub fn push_sorted(&mut self, mask: u32, distances: &[f32; 8], children: &[u32; 8]) {
        if mask & mask.wrapping_sub(1) == 0 {
            if mask != 0 {
                let slot = mask.trailing_zeros() as usize;
                self.push(Entry { node: children[slot], distance: distances[slot] });
            }
            return;
        }
        let mut found = [Entry::default(); 8];
        let mut count = 0;
        let mut mask = mask;
        while mask != 0 {
            let slot = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let entry = Entry { node: children[slot], distance: distances[slot] };
            let mut place = count;
            while place > 0 && found[place - 1].distance < entry.distance {
                found[place] = found[place - 1];
                place -= 1;
            }
            found[place] = entry;
            count += 1;
        }
        for &entry in &found[..count] {
            self.push(entry);
        }
    }
}
