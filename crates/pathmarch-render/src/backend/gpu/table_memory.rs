//! Memory of the film and of the tables that a kernel reads: uniform or storage buffers, or textures.
//!
//! A read of storage memory costs llvmpipe a loop over the lanes, in which each word goes through the stack: some sixty cycles
//! a lane. A read of a texture is eight loads and a transposition. On software adapters the film and tables of any length are
//! therefore textures of [`TEXELS_PER_ROW`] columns. Measured in docs/performance.md.

use super::device::Device;

/// Texels of a row, a power of two that every adapter supports.
const TEXELS_PER_ROW: u32 = 1 << TEXELS_PER_ROW_BITS;
const TEXELS_PER_ROW_BITS: u32 = 11;

/// Memory of a table.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Memory {
    /// Uniform buffer of this declared size, bytes.
    Uniform(usize),
    Storage,
    Texture,
}

/// Element of a table that may be in a texture.
#[derive(Clone, Copy)]
pub(super) enum Element {
    /// Word of 32 bits.
    Word,
    /// Vector of four 32-bit numbers.
    Vector,
}

impl Element {
    const fn bytes(self) -> usize {
        match self {
            Self::Word => 4,
            Self::Vector => 16,
        }
    }

    const fn format(self) -> wgpu::TextureFormat {
        match self {
            Self::Word => wgpu::TextureFormat::R32Uint,
            Self::Vector => wgpu::TextureFormat::Rgba32Float,
        }
    }

    /// Type of textures of such elements, as bindings declare it.
    pub(super) const fn binding_type(self, access: wgpu::StorageTextureAccess) -> wgpu::BindingType {
        wgpu::BindingType::StorageTexture {
            access,
            format: self.format(),
            view_dimension: wgpu::TextureViewDimension::D2,
        }
    }

    /// Name of the type in WGSL.
    const fn name(self) -> &'static str {
        match self {
            Self::Word => "u32",
            Self::Vector => "vec4f",
        }
    }

    /// WGSL of a table in a storage buffer or a texture, and of `function(index: u32)`, which reads an element of it.
    pub(super) fn declaration(self, memory: Memory, binding: u32, table: &str, function: &str) -> String {
        let name = self.name();
        let (declared, value) = match memory {
            Memory::Texture => (self.texture(table, "read"), self.texel(table, "index")),
            _ => (format!("var<storage, read> {table}: array<{name}>"), format!("{table}[index]")),
        };
        format!(
            "@group(0) @binding({binding}) {declared};\n\nfn {function}(index: u32) -> {name} {{\n    return {value};\n}}\n\n"
        )
    }

    /// WGSL of a variable for a table in a texture.
    fn texture(self, table: &str, access: &str) -> String {
        let format = match self {
            Self::Word => "r32uint",
            Self::Vector => "rgba32float",
        };
        format!("var {table}: texture_storage_2d<{format}, {access}>")
    }

    /// WGSL of an element of a table in a texture.
    fn texel(self, table: &str, index: &str) -> String {
        let component = match self {
            Self::Word => ".x",
            Self::Vector => "",
        };
        format!("textureLoad({table}, {}){component}", place(index))
    }
}

/// WGSL of the place of an element in a texture.
fn place(index: &str) -> String {
    format!("vec2u({index} & {}u, {index} >> {TEXELS_PER_ROW_BITS}u)", TEXELS_PER_ROW - 1)
}

/// WGSL of the film in this memory, of `film_sum(pixel: u32) -> vec4f`, and of `store_film(pixel: u32, sum: vec4f)`.
pub(super) fn film_declaration(memory: Memory, binding: u32) -> String {
    let element = Element::Vector;
    let (declared, sum, store) = match memory {
        Memory::Texture => (
            element.texture("film", "read_write"),
            element.texel("film", "pixel"),
            format!("textureStore(film, {}, sum)", place("pixel")),
        ),
        _ => (
            "var<storage, read_write> film: array<vec4f>".to_owned(),
            "film[pixel]".to_owned(),
            "film[pixel] = sum".to_owned(),
        ),
    };
    format!(
        "@group(0) @binding({binding}) {declared};\n\nfn film_sum(pixel: u32) -> vec4f {{\n    return {sum};\n}}\n\n\
         fn store_film(pixel: u32, sum: vec4f) {{\n    {store};\n}}\n\n"
    )
}

/// WGSL of `function() -> u32`, the number of elements of a table in a texture, those that fill its last row included.
pub(super) fn texture_length(table: &str, function: &str) -> String {
    format!("fn {function}() -> u32 {{\n    return textureDimensions({table}).y << {TEXELS_PER_ROW_BITS}u;\n}}\n\n")
}

/// Number of bytes of a texture for elements of `bytes` bytes together.
fn texture_bytes(element: Element, bytes: usize) -> usize {
    bytes.max(1).next_multiple_of(TEXELS_PER_ROW as usize * element.bytes())
}

/// Layout of a texture's rows in a buffer, and its size.
fn layout(element: Element, bytes: usize) -> (wgpu::TexelCopyBufferLayout, wgpu::Extent3d) {
    let row = TEXELS_PER_ROW as usize * element.bytes();
    let size = wgpu::Extent3d { width: TEXELS_PER_ROW, height: (bytes / row) as u32, depth_or_array_layers: 1 };
    (wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row as u32), rows_per_image: None }, size)
}

/// Texture of elements.
fn texture(device: &Device, label: &str, element: Element, bytes: usize, usage: wgpu::TextureUsages) -> wgpu::Texture {
    device.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: layout(element, bytes).1,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: element.format(),
        usage: usage | wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}

/// Table of a kernel on a device.
#[derive(Clone)]
pub(super) enum Table {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
}

impl Table {
    /// Texture of the elements.
    pub(super) fn texture(device: &Device, label: &str, element: Element, contents: &[u8]) -> Self {
        let mut padded = contents.to_vec();
        padded.resize(texture_bytes(element, contents.len()), 0);
        let texture = texture(device, label, element, padded.len(), wgpu::TextureUsages::empty());
        let (layout, size) = layout(element, padded.len());
        device.queue.write_texture(texture.as_image_copy(), &padded, layout, size);
        Self::Texture(texture.create_view(&wgpu::TextureViewDescriptor::default()))
    }

    /// Resource of a bind group.
    pub(super) fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer) => buffer.as_entire_binding(),
            Self::Texture(view) => wgpu::BindingResource::TextureView(view),
        }
    }
}

/// Film of a device: sums of samples. Kernels may write them to a texture, from which they are copied to the buffer that all
/// else reads.
pub(super) struct FilmMemory {
    /// Sums, after [`update`](Self::update).
    pub(super) buffer: wgpu::Buffer,
    texture: Option<wgpu::Texture>,
}

impl FilmMemory {
    /// Empty film of so many bytes.
    pub(super) fn new(device: &Device, memory: Memory, bytes: u64) -> Self {
        let is_texture = memory == Memory::Texture;
        let size = if is_texture { texture_bytes(Element::Vector, bytes as usize) as u64 } else { bytes };
        let copied = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let buffer = device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("film"),
            size,
            usage: wgpu::BufferUsages::STORAGE | copied,
            mapped_at_creation: false,
        });
        let of_size = || texture(device, "film", Element::Vector, size as usize, wgpu::TextureUsages::COPY_SRC);
        Self { buffer, texture: is_texture.then(of_size) }
    }

    /// What kernels write to.
    pub(super) fn table(&self) -> Table {
        match &self.texture {
            Some(texture) => Table::Texture(texture.create_view(&wgpu::TextureViewDescriptor::default())),
            None => Table::Buffer(self.buffer.clone()),
        }
    }

    /// Copies what kernels have written to the buffer.
    pub(super) fn update(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(texture) = &self.texture {
            let (layout, size) = layout(Element::Vector, self.buffer.size() as usize);
            encoder.copy_texture_to_buffer(
                texture.as_image_copy(),
                wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout },
                size,
            );
        }
    }

    /// Sets the first so many bytes to zero.
    pub(super) fn clear(&self, encoder: &mut wgpu::CommandEncoder, bytes: u64) {
        encoder.clear_buffer(&self.buffer, 0, Some(bytes));
        if let Some(texture) = &self.texture {
            let (layout, size) = layout(Element::Vector, self.buffer.size() as usize);
            encoder.copy_buffer_to_texture(
                wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout },
                texture.as_image_copy(),
                size,
            );
        }
    }
}
