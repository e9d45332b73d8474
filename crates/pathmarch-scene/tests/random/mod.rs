//! Random numbers for the tests; the same in every run.
#![allow(dead_code)]

use glam::Vec3;

/// A small generator (PCG; O'Neill 2014), so that samples are independent and the same on each run.
pub struct Random(pub u64);

impl Random {
    /// Uniform in 0..1.
    pub fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        (word.rotate_right((self.0 >> 59) as u32) >> 8) as f32 / 16_777_216.0
    }
    pub fn three(&mut self) -> [f32; 3] {
        [self.next(), self.next(), self.next()]
    }
    /// Within a box of this half edge.
    pub fn point(&mut self, half: f32) -> Vec3 {
        Vec3::from(self.three()) * (2.0 * half) - half
    }
}
