//! Buffers of reconstruction on the GPU.

use crate::backend::gpu::Device;

/// Buffers of a film that the next one reads.
pub(super) struct FilmBuffers {
    pub(super) guides: wgpu::Buffer,
    pub(super) history: wgpu::Buffer,
    pub(super) colours: wgpu::Buffer,
}

/// Buffers for the light of facets.
pub(super) struct FacetBuffers {
    /// Histories of the present film and of the one before.
    pub(super) histories: [wgpu::Buffer; 2],
    /// Filtered light without that of facets.
    pub(super) base: wgpu::Buffer,
    pub(super) images: wgpu::Buffer,
}

/// Buffers for the indirect light of a film, at half the resolution.
pub(super) struct HalfFilmBuffers {
    pub(super) guides: wgpu::Buffer,
    pub(super) history: wgpu::Buffer,
}

/// Buffers for the indirect light, at half the resolution.
pub(super) struct HalfBuffers {
    /// Those of the present film and of the one before.
    pub(super) films: [HalfFilmBuffers; 2],
    pub(super) estimates: [wgpu::Buffer; 2],
    pub(super) earlier: wgpu::Buffer,
}

/// All buffers, for films and pictures of up to so many pixels.
pub(super) struct Buffers {
    /// Number of pixels, and of those at half the resolution.
    pub(super) pixels: [u64; 2],
    /// Those for the light of facets; `None` before there are any.
    pub(super) facets: Option<FacetBuffers>,
    /// Those of the present film and of the one before.
    pub(super) films: [FilmBuffers; 2],
    /// Estimates that a pass reads and those that it writes.
    pub(super) estimates: [wgpu::Buffer; 2],
    pub(super) earlier: wgpu::Buffer,
    pub(super) half: HalfBuffers,
    pub(super) screen: wgpu::Buffer,
    pub(super) copy: wgpu::Buffer,
}

/// Bytes of the guides of a pixel.
pub(super) const GUIDE_BYTES: u64 = 64;
/// Bytes of the history of a pixel.
pub(super) const HISTORY_BYTES: u64 = 32;
/// Bytes of a colour or an estimate.
pub(super) const COLOUR_BYTES: u64 = 16;
/// Bytes of a point in the earlier scene.
pub(super) const EARLIER_BYTES: u64 = 16;
/// Bytes of a pixel of the screen.
pub(super) const SCREEN_BYTES: u64 = 4;

impl Buffers {
    /// Allocates buffers, also for the light of facets if it is there; `None` if the device cannot.
    pub(super) fn new(device: &Device, [pixels, half_pixels]: [u64; 2], has_facets: bool) -> Option<Self> {
        let limits = device.device.limits();
        if GUIDE_BYTES * pixels > limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) {
            return None;
        }
        let sized = |label, size: u64, usage| {
            device.allocate(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false }).ok()
        };
        let buffer = |label, bytes: u64, usage| sized(label, bytes * pixels, usage);
        let copied = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let storage = wgpu::BufferUsages::STORAGE | copied;
        let film = || {
            Some(FilmBuffers {
                guides: buffer("guides", GUIDE_BYTES, storage)?,
                history: buffer("history", HISTORY_BYTES, storage)?,
                colours: buffer("colours", COLOUR_BYTES, storage)?,
            })
        };
        let readback = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        let facets = || {
            let history = || buffer("history of facets", HISTORY_BYTES, storage);
            Some(FacetBuffers {
                histories: [history()?, history()?],
                base: buffer("base", COLOUR_BYTES, storage)?,
                images: buffer("images", COLOUR_BYTES, storage)?,
            })
        };
        let half = |label, bytes: u64| sized(label, bytes * half_pixels, storage);
        let half_film = || {
            Some(HalfFilmBuffers {
                guides: half("half guides", GUIDE_BYTES)?,
                history: half("half history", HISTORY_BYTES)?,
            })
        };
        Some(Self {
            pixels: [pixels, half_pixels],
            facets: if has_facets { Some(facets()?) } else { None },
            films: [film()?, film()?],
            estimates: [buffer("estimates", COLOUR_BYTES, storage)?, buffer("estimates", COLOUR_BYTES, storage)?],
            earlier: buffer("earlier points", EARLIER_BYTES, storage)?,
            half: HalfBuffers {
                films: [half_film()?, half_film()?],
                estimates: [half("half estimates", COLOUR_BYTES)?, half("half estimates", COLOUR_BYTES)?],
                earlier: half("half earlier points", EARLIER_BYTES)?,
            },
            screen: buffer("screen", SCREEN_BYTES, storage)?,
            copy: buffer("screen copy", SCREEN_BYTES, readback)?,
        })
    }

    /// Copies the films of smaller buffers.
    pub(super) fn copy_films(&self, device: &Device, old: &Self) {
        let mut encoder =
            device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("copy history") });
        for (new, old) in self.films.iter().zip(&old.films) {
            for (new, old) in [(&new.guides, &old.guides), (&new.history, &old.history), (&new.colours, &old.colours)] {
                encoder.copy_buffer_to_buffer(old, 0, new, 0, old.size());
            }
        }
        for (new, old) in self.half.films.iter().zip(&old.half.films) {
            for (new, old) in [(&new.guides, &old.guides), (&new.history, &old.history)] {
                encoder.copy_buffer_to_buffer(old, 0, new, 0, old.size());
            }
        }
        if let (Some(new), Some(old)) = (&self.facets, &old.facets) {
            for (new, old) in new.histories.iter().zip(&old.histories) {
                encoder.copy_buffer_to_buffer(old, 0, new, 0, old.size());
            }
        }
        device.queue.submit([encoder.finish()]);
    }
}
