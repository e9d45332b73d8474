//! Numbers of all pixels in planes, so that eight adjoining pixels are one SIMD vector.

use glam::Vec3;
use rayon::prelude::*;
use wide::f32x8;

/// Size of a picture that a filter walks over.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) width: i32,
    pub(super) height: i32,
}

impl Grid {
    pub(super) fn new(size: [u32; 2]) -> Self {
        Self { width: size[0] as i32, height: size[1] as i32 }
    }

    /// Index of a pixel; `None` outside.
    #[inline]
    pub(super) fn index(self, x: i32, y: i32) -> Option<usize> {
        ((0..self.width).contains(&x) && (0..self.height).contains(&y)).then(|| (y * self.width + x) as usize)
    }

    /// Pixels next to a pixel.
    pub(super) fn around(self, x: i32, y: i32) -> impl Iterator<Item = usize> {
        SQUARE_OF_3.into_iter().filter_map(move |(dx, dy)| self.index(x + dx, y + dy))
    }

    /// Places of all pixels of a row, eight at a time.
    pub(super) fn places(self, row: i32) -> impl Iterator<Item = Place> {
        (0..self.width as usize).step_by(8).map(move |x| Place::new(x, row))
    }
}

/// Offsets to the `COUNT` pixels of the square around a pixel, without itself.
pub(super) const fn square_around<const COUNT: usize>(radius: i32) -> [(i32, i32); COUNT] {
    let (mut offsets, mut count, side) = ([(0, 0); COUNT], 0, 2 * radius + 1);
    let mut k = 0;
    while k < side * side {
        let offset = (k % side - radius, k / side - radius);
        if offset.0 != 0 || offset.1 != 0 {
            offsets[count] = offset;
            count += 1;
        }
        k += 1;
    }
    offsets
}

/// Offsets to the pixels of the square of 3x3 around a pixel, without itself.
pub(super) const SQUARE_OF_3: [(i32, i32); 8] = square_around(1);

/// Number of pixels beside the rows of [`Planes`], at least the largest reach of the filter and eight more.
const MARGIN: usize = 16;

/// `N` numbers of all pixels, row by row: a plane of the row for each number, with a margin on both sides.
pub(super) struct Planes<const N: usize> {
    stride: usize,
    numbers: Vec<f32>,
}

/// Place of eight adjoining pixels in planes: their row, and the column of the first with the margin.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) row: i32,
    pub(super) column: i32,
}

impl Place {
    pub(super) fn new(x: usize, row: i32) -> Self {
        Self { row, column: (x + MARGIN) as i32 }
    }

    /// Column of the first pixel.
    pub(super) fn x(self) -> usize {
        self.column as usize - MARGIN
    }

    /// Indices of the pixels of a picture; beyond the end of the row those of others.
    pub(super) fn indices(self, grid: Grid) -> [usize; 8] {
        let (first, last) =
            (self.row as usize * grid.width as usize + self.x(), (grid.width * grid.height) as usize - 1);
        std::array::from_fn(|lane| (first + lane).min(last))
    }

    /// Place so many pixels further; `None` above and below the picture.
    #[inline(always)]
    pub(super) fn moved(self, grid: Grid, dx: i32, dy: i32) -> Option<Self> {
        let row = self.row + dy;
        (0..grid.height).contains(&row).then_some(Self { row, column: self.column + dx })
    }
}

impl<const N: usize> Planes<N> {
    /// Planes that `fill` writes: it receives the planes of a row, each with its margins, and the row.
    fn filled(grid: Grid, fill: impl Fn(&mut [&mut [f32]; N], i32) + Sync) -> Self {
        let stride = grid.width as usize + 2 * MARGIN;
        let mut numbers = vec![0.0; N * stride * grid.height as usize];
        numbers.par_chunks_mut(N * stride).enumerate().with_min_len(8).for_each(|(row, planes)| {
            let mut planes = planes.chunks_mut(stride);
            fill(&mut std::array::from_fn(|_| planes.next().unwrap_or_default()), row as i32);
        });
        Self { stride, numbers }
    }

    /// Planes of a function of all pixels; the margins have these numbers.
    pub(super) fn new(grid: Grid, margin: [f32; N], values: impl Fn(usize) -> [f32; N] + Sync) -> Self {
        Self::filled(grid, |planes, row| {
            let width = grid.width as usize;
            for (plane, margin) in planes.iter_mut().zip(margin) {
                plane[..MARGIN].fill(margin);
                plane[MARGIN + width..].fill(margin);
            }
            for x in 0..width {
                let numbers = values(row as usize * width + x);
                for (plane, number) in planes.iter_mut().zip(&numbers) {
                    plane[MARGIN + x] = *number;
                }
            }
        })
    }

    /// Planes of a function of eight adjoining pixels.
    pub(super) fn of_eight(grid: Grid, values: impl Fn(Place) -> [f32x8; N] + Sync) -> Self {
        Self::within(grid, [0.0; N], values)
    }

    /// Planes of a function of eight adjoining pixels; the margins have these numbers.
    pub(super) fn within(grid: Grid, margin: [f32; N], values: impl Fn(Place) -> [f32x8; N] + Sync) -> Self {
        Self::filled(grid, |planes, row| {
            for (plane, margin) in planes.iter_mut().zip(margin) {
                plane[..MARGIN].fill(margin);
                plane[MARGIN + grid.width as usize..].fill(margin);
            }
            for place in grid.places(row) {
                let column = place.column as usize;
                // Arrays that are iterated by value are copied once more.
                for (plane, value) in planes.iter_mut().zip(&values(place)) {
                    plane[column..column + 8].copy_from_slice(value.as_array());
                }
            }
        })
    }

    /// Number `k` of eight pixels.
    #[inline(always)]
    pub(super) fn load(&self, k: usize, place: Place) -> f32x8 {
        let at = (place.row as usize * N + k) * self.stride + place.column as usize;
        f32x8::new(self.numbers[at..at + 8].try_into().unwrap_or([0.0; 8]))
    }

    /// Numbers of eight pixels.
    #[inline(always)]
    pub(super) fn lanes(&self, place: Place) -> [f32x8; N] {
        // A loop is unrolled where `from_fn` becomes calls.
        let mut lanes = [f32x8::ZERO; N];
        for (k, lane) in lanes.iter_mut().enumerate() {
            *lane = self.load(k, place);
        }
        lanes
    }
}

/// Values of all pixels, from those of eight adjoining ones.
pub(super) fn by_eight<T: Copy + Default + Send>(grid: Grid, of: impl Fn(Place) -> [T; 8] + Sync) -> Vec<T> {
    let width = grid.width as usize;
    let mut values = vec![T::default(); width * grid.height as usize];
    values.par_chunks_mut(width).enumerate().with_min_len(8).for_each(|(row, values)| {
        for (place, values) in grid.places(row as i32).zip(values.chunks_mut(8)) {
            values.copy_from_slice(&of(place)[..values.len()]);
        }
    });
    values
}

/// Sums over the squares around all pixels, of half this side, of functions of a pixel.
pub(super) fn box_sums<const N: usize>(
    size: [u32; 2],
    radius: i32,
    values: impl Fn(usize) -> [f32; N] + Sync,
) -> BoxSums<N> {
    sums_where(Grid::new(size), radius, values, |_, _| f32x8::ZERO.simd_eq(f32x8::ZERO))
}

/// [`box_sums`] over the pixels that show the surface of the middle one: a number, and a unit normal that differs by at most
/// the angle of `min_cosine`. Those of the middle's column count, and beside each of these the ones of its own surface.
pub(super) fn box_sums_of_surfaces<const N: usize>(
    size: [u32; 2],
    radius: i32,
    min_cosine: f32,
    surface: impl Fn(usize) -> (f32, Vec3) + Sync,
    values: impl Fn(usize) -> [f32; N] + Sync,
) -> BoxSums<N> {
    let grid = Grid::new(size);
    let surfaces = &Planes::new(grid, [0.0; 4], |index| {
        let (number, normal) = surface(index);
        [number, normal.x, normal.y, normal.z]
    });
    sums_where(grid, radius, values, |here, there| {
        let ([number, ax, ay, az], [other, bx, by, bz]) = (surfaces.lanes(here), surfaces.lanes(there));
        let cosine = ax * bx + ay * by + az * bz;
        number.simd_eq(other) & cosine.simd_ge(f32x8::splat(min_cosine))
    })
}

/// Sums over squares of pixels, eight at a time: `counts` is the mask of those at the second place for those at the first.
#[inline(always)]
pub(super) fn sums_where<const N: usize>(
    grid: Grid,
    radius: i32,
    values: impl Fn(usize) -> [f32; N] + Sync,
    counts: impl Fn(Place, Place) -> f32x8 + Sync,
) -> BoxSums<N> {
    let values = Planes::new(grid, [0.0; N], values);
    // Sums over squares are sums over columns of sums over rows.
    let sums = |values: &Planes<N>, place: Place, [dx, dy]: [i32; 2]| {
        let mut sums = [f32x8::ZERO; N];
        for k in -radius..=radius {
            let Some(there) = place.moved(grid, k * dx, k * dy) else { continue };
            let counts = counts(place, there);
            for (sum, value) in sums.iter_mut().zip(&values.lanes(there)) {
                *sum += counts & *value;
            }
        }
        sums
    };
    let rows = Planes::of_eight(grid, |place| sums(&values, place, [1, 0]));
    let sums = Planes::of_eight(grid, |place| sums(&rows, place, [0, 1]));
    BoxSums { grid, sums }
}

/// Sums of [`box_sums`].
pub(super) struct BoxSums<const N: usize> {
    pub(super) grid: Grid,
    sums: Planes<N>,
}

impl<const N: usize> BoxSums<N> {
    /// Sums around eight pixels.
    #[inline(always)]
    pub(super) fn lanes(&self, place: Place) -> [f32x8; N] {
        self.sums.lanes(place)
    }

    /// Sums around the pixel of an index.
    pub(super) fn at(&self, index: usize) -> [f32; N] {
        let width = self.grid.width as usize;
        let (row, column) = (index / width, index % width + MARGIN);
        std::array::from_fn(|k| self.sums.numbers[(N * row + k) * self.sums.stride + column])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_surfaces_end_at_their_edges() {
        // A wall of 20x9 pixels, and in front of it a post in the columns 8 to 10, from row 3 on.
        let is_post = |index: usize| index / 20 >= 3 && (8..=10).contains(&(index % 20));
        let value = |index: usize| [1.0, if is_post(index) { 100.0 } else { 1.0 }];
        let numbered = |index: usize| (if is_post(index) { 2.0f32 } else { 1.0 }, Vec3::Z);
        let turned = |index: usize| (1.0f32, if is_post(index) { Vec3::X } else { Vec3::Z });
        for surface in [&numbered as &(dyn Fn(usize) -> (f32, Vec3) + Sync), &turned] {
            let sums = box_sums_of_surfaces([20, 9], 2, 0.8, surface, value);
            let at = |x: usize, y: usize| sums.at(20 * y + x);
            assert_eq!(at(3, 4), [25.0, 25.0]);
            assert_eq!(at(7, 6), [15.0, 15.0]);
            assert_eq!(at(9, 6), [15.0, 1500.0]);
            assert_eq!(at(0, 0), [9.0, 9.0]);
            // Above the post.
            assert_eq!(at(9, 2), [15.0, 15.0]);
        }
        assert_eq!(box_sums([20, 9], 2, value).at(20 * 6 + 9)[0], 25.0);
    }
}
