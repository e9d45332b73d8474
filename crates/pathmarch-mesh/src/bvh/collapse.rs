//! Collapse of a binary hierarchy to eight children a node.
//!
//! **Idea.** A wide node starts with the two children of a binary node. The inner child with the largest surface area is
//! replaced by its own two until there are eight (Wald et al. 2008). **Cost.** Linear in the nodes.

use super::binary::{BinaryBvh, Node, half_area};

/// Children of a wide node, as indices of binary nodes.
pub(super) struct Children {
    nodes: [u32; 8],
    count: usize,
}

impl Children {
    /// Children of the wide node at a binary node. A leaf, which only the root may be, is its own child.
    pub fn of(tree: &BinaryBvh, parent: u32) -> Self {
        let mut children = Self { nodes: [parent; 8], count: 1 };
        let area = |node: &Node| if node.is_leaf() { -1.0 } else { half_area(node.bounds.size()) };
        let mut areas = [area(&tree.nodes[parent as usize]); 8];
        while children.count < 8 {
            let largest = (1..children.count).fold(0, |best, slot| if areas[slot] > areas[best] { slot } else { best });
            let opened = children.nodes[largest];
            let node = &tree.nodes[opened as usize];
            if node.is_leaf() {
                break;
            }
            for (slot, child) in [(largest, opened + 1), (children.count, node.second)] {
                children.nodes[slot] = child;
                areas[slot] = area(&tree.nodes[child as usize]);
            }
            children.count += 1;
        }
        children
    }

    /// Indices of the binary nodes.
    pub fn as_slice(&self) -> &[u32] {
        &self.nodes[..self.count]
    }
}
