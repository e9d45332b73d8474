//! Grids as bytes, for a cache.
//!
//! A header, the arrays in little-endian order, and a checksum of all before it. Reading reserves no more than the bytes that are
//! there; bytes that another version wrote, or that are damaged, are refused.

use super::layout::{Layout, SAMPLES};
use super::{DistanceGrid, NO_BRICK, greatest};
use glam::{UVec3, Vec3};

/// First bytes: a name, and the version of the layout and of the method that computes the samples.
const MAGIC: [u8; 8] = *b"PMGRID01";

/// Bytes that are no grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CacheError {
    /// Another program or version wrote them.
    #[error("the bytes are no distance grid of this version; build it again")]
    Version,
    /// They are damaged.
    #[error("the distance grid is damaged; build it again")]
    Damaged,
}

impl DistanceGrid {
    /// Bytes of the grid.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.size_in_bytes() + 64);
        bytes.extend(MAGIC);
        let Layout { origin, voxel, blocks } = self.layout;
        bytes.extend([origin.x, origin.y, origin.z, voxel].iter().flat_map(|v| v.to_le_bytes()));
        let counts = [blocks.x, blocks.y, blocks.z, (self.bricks.len() / SAMPLES) as u32];
        bytes.extend(counts.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(self.coarse.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(self.bricks_of_blocks.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(self.slopes.iter().flat_map(|v| v.to_le_bytes()));
        bytes.extend(self.bricks.iter().flat_map(|v| v.to_le_bytes()));
        let sum = checksum(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }

    /// Grid of bytes that [`DistanceGrid::to_bytes`] made.
    ///
    /// # Errors
    /// [`CacheError`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, CacheError> {
        let rest = bytes.strip_prefix(&MAGIC).ok_or(CacheError::Version)?;
        let (body, sum) = rest.split_last_chunk::<8>().ok_or(CacheError::Damaged)?;
        if checksum(&bytes[..bytes.len() - 8]) != u64::from_le_bytes(*sum) {
            return Err(CacheError::Damaged);
        }
        let mut reader = Reader { rest: body };
        let grid = reader.grid().filter(|grid| reader.rest.is_empty() && grid.is_consistent());
        grid.ok_or(CacheError::Damaged)
    }

    fn is_consistent(&self) -> bool {
        let bricks = self.bricks.len() / SAMPLES;
        self.layout.origin.is_finite()
            && self.layout.voxel.is_finite()
            && self.layout.voxel > 0.0
            && self.bricks_of_blocks.iter().all(|&brick| brick == NO_BRICK || (brick as usize) < bricks)
            && self.slopes.iter().chain(&self.coarse).all(|v| v.is_finite())
    }
}

struct Reader<'a> {
    rest: &'a [u8],
}

impl Reader<'_> {
    fn grid(&mut self) -> Option<DistanceGrid> {
        let header = self.array(4, f32::from_le_bytes)?;
        let counts = self.array(4, u32::from_le_bytes)?;
        let layout = Layout { origin: Vec3::from_slice(&header), voxel: header[3], blocks: UVec3::from_slice(&counts) };
        // No axis is longer than the bytes, so that no product below overflows.
        if layout.blocks.min_element() == 0 || layout.blocks.max_element() > 1 << 12 {
            return None;
        }
        let coarse = self.array(layout.coarse_count(), f32::from_le_bytes)?;
        let bricks_of_blocks = self.array(layout.block_count(), u32::from_le_bytes)?;
        let slopes = self.array(layout.block_count(), f32::from_le_bytes)?;
        Some(DistanceGrid {
            layout,
            coarse,
            bricks_of_blocks,
            lipschitz: greatest(&slopes),
            slopes,
            bricks: self.array((counts[3] as usize).checked_mul(SAMPLES)?, i16::from_le_bytes)?,
        })
    }

    fn array<T, const N: usize>(&mut self, count: usize, read: impl Fn([u8; N]) -> T) -> Option<Vec<T>> {
        let (bytes, rest) = self.rest.split_at_checked(count.checked_mul(N)?)?;
        self.rest = rest;
        Some(bytes.as_chunks::<N>().0.iter().map(|&chunk| read(chunk)).collect())
    }
}

/// FNV-1a over words of eight bytes.
fn checksum(bytes: &[u8]) -> u64 {
    let (words, rest) = bytes.as_chunks::<8>();
    let words = words.iter().map(|&word| u64::from_le_bytes(word));
    let all = words.chain(rest.iter().map(|&byte| byte.into()));
    all.fold(0xcbf2_9ce4_8422_2325, |sum, word| (sum ^ word).wrapping_mul(0x0100_0000_01b3).rotate_left(29))
}
