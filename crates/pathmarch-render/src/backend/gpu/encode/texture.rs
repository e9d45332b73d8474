//! Encoding of textured materials, which `shading/textured_material.wgsl` decodes.
//!
//! The words contain the pose of each leaf, then the offset of each material's textures (0 if it has none), then the textures.
//! Offsets count from the start of the buffer.

use crate::scene::textured_material::{Change, Layer, Source, TexturedMaterial};
use crate::wgsl::shared_constants;
use pathmarch_field::Field;
use pathmarch_scene::textures::{self, Decal, DecalSpace, Pattern, Picture, Ramp, Texture, TextureKind};

shared_constants! {
    /// Words of a leaf: position, three rows of the inverse rotation and scale, and the modifiers around it.
    const LEAF_WORDS: u32 = 13;
    /// Words of a texture: kind, position, three rows, scale, step of differences, parameters.
    const TEXTURE_POSITION: u32 = 1;
    const TEXTURE_ROWS: u32 = 4;
    const TEXTURE_SCALE: u32 = 13;
    const TEXTURE_STEP: u32 = 14;
    const TEXTURE_PARAMETERS: u32 = 15;
    /// Kinds of textures that are not functions of the point alone.
    const ORBIT_SOURCE: u32 = 1000;
    const PICTURE_SOURCE: u32 = 1001;
    const UV_PICTURE_SOURCE: u32 = 1002;
    const DECAL_SOURCE: u32 = 1003;
    const WORLD_DECAL_SOURCE: u32 = 1004;
    /// Words of a layer: texture, kind, place or number of places, preview materials, contents.
    const LAYER_KIND: u32 = 1;
    const LAYER_PLACE: u32 = 2;
    const LAYER_PREVIEWS: u32 = 3;
    const LAYER_CONTENTS: u32 = 4;
    /// Kinds of layers: a ramp of evenly spaced colours, the texture's own colour, parameters packed at knots, a ramp of
    /// colours with positions, a decal.
    const RAMP_LAYER: u32 = 0;
    const OWN_COLOURS_LAYER: u32 = 1;
    const PACKED_LAYER: u32 = 2;
    const POSITIONED_RAMP_LAYER: u32 = 3;
    const DECAL_LAYER: u32 = 4;
}

/// Total number of words of a texture.
const TEXTURE_WORDS: usize = TEXTURE_PARAMETERS as usize + textures::MAX_PARAMETERS;

/// Index of a kind of computed texture.
pub(crate) fn computed_kind(kind: &'static TextureKind) -> usize {
    textures::kinds().iter().position(|other| std::ptr::eq(*other, kind)).unwrap_or_default()
}

/// Encodes leaves, materials and textures as words that start at `start` in the buffer.
pub(super) fn encode(field: &Field, materials: &[TexturedMaterial], start: usize) -> Vec<u32> {
    let mut encoder = Encoder { words: Vec::new(), start, pictures: Vec::new() };
    for (index, leaf) in field.leaves().iter().enumerate() {
        let rows = leaf.pose.local_from_world();
        encoder.floats(leaf.pose.at.iter().chain(rows.as_flattened()).copied());
        encoder.words.push(field.enclosing_modifier(index));
    }
    let first = encoder.words.len();
    encoder.words.resize(first + materials.len(), 0);
    for (index, material) in materials.iter().enumerate().filter(|(_, material)| !material.is_plain()) {
        encoder.words[first + index] = encoder.material(material);
    }
    encoder.words
}

/// [`TEXTURE_PARAMETERS`] as an index.
const PARAMETERS: usize = TEXTURE_PARAMETERS as usize;

struct Encoder<'a> {
    words: Vec<u32>,
    /// Offset of the first word in the buffer.
    start: usize,
    /// Pictures and the offset of their texels.
    pictures: Vec<(&'a Picture, u32)>,
}

impl<'a> Encoder<'a> {
    /// Offset of the next word.
    fn offset(&self) -> u32 {
        (self.start + self.words.len()) as u32
    }

    fn floats(&mut self, numbers: impl IntoIterator<Item = f32>) {
        self.words.extend(numbers.into_iter().map(f32::to_bits));
    }

    /// Encodes a material; returns its offset.
    fn material(&mut self, material: &'a TexturedMaterial) -> u32 {
        let layers: Vec<u32> = material.layers.iter().map(|layer| self.layer(layer)).collect();
        let bump = material.bump.as_ref().map_or(0, |bump| {
            let texture = self.texture(&bump.texture);
            let at = self.offset();
            self.words.extend([texture, bump.height.to_bits()]);
            at
        });
        let normal_map = material.normal_map.as_ref().map_or(0, |map| {
            let texture = self.texture(&map.texture);
            let at = self.offset();
            self.words.extend([texture, map.scale.to_bits()]);
            at
        });
        let emission = material.emission.as_ref().map_or(0, |texture| {
            let texture = self.texture(texture);
            let at = self.offset();
            self.words.push(texture);
            at
        });
        let at = self.offset();
        self.words.extend([layers.len() as u32, bump, normal_map, emission]);
        self.words.extend(layers);
        // The kernel may read one word beyond the last.
        self.words.push(0);
        at
    }

    /// Encodes a layer; returns its offset.
    fn layer(&mut self, layer: &'a Layer) -> u32 {
        let texture = match &layer.source {
            Source::Orbit(trap) => {
                let [from, to] = trap.range.map(f32::to_bits);
                let [x, y, z] = trap.centre.map(f32::to_bits);
                let mut record = [0; TEXTURE_WORDS];
                record[0] = ORBIT_SOURCE;
                record[PARAMETERS..PARAMETERS + 6].copy_from_slice(&[trap.trap as u32, from, to, x, y, z]);
                self.record(record)
            }
            Source::Texture(texture) => self.texture(texture),
            Source::Decal(decal) => self.decal(decal),
        };
        let previews = self.offset();
        if let Change::Colour { .. } = layer.change {
            self.floats(layer.base);
        }
        self.floats(layer.previews.as_flattened().iter().copied());
        let at = self.offset();
        match &layer.change {
            Change::Colour { first, ramp: Some(Ramp { colours, positions }) } => {
                let kind = if positions.is_some() { POSITIONED_RAMP_LAYER } else { RAMP_LAYER };
                self.words.extend([texture, kind, *first as u32, previews, colours.len() as u32 - 1]);
                self.floats(colours.as_flattened().iter().copied());
                self.floats(positions.iter().flatten().copied());
            }
            Change::Colour { first, ramp: None } => {
                let kind = if let Source::Decal(_) = layer.source { DECAL_LAYER } else { OWN_COLOURS_LAYER };
                self.words.extend([texture, kind, *first as u32, previews]);
            }
            Change::Parameters { indices, knots } => {
                self.words.extend([texture, PACKED_LAYER, indices.len() as u32, previews]);
                self.words.extend(indices.iter().map(|index| *index as u32));
                self.floats(knots.iter().flatten().copied());
            }
        }
        at
    }

    /// Encodes a texture; returns its offset.
    fn texture(&mut self, texture: &'a Texture) -> u32 {
        let mut record = [0; TEXTURE_WORDS];
        let step = match &texture.pattern {
            Pattern::Computed { kind, parameters } => {
                record[0] = computed_kind(kind) as u32;
                record[PARAMETERS..].copy_from_slice(&parameters.map(f32::to_bits));
                (kind.step)(parameters)
            }
            Pattern::Picture { picture, size } => {
                let texels = self.texels(picture);
                record[0] = PICTURE_SOURCE;
                record[PARAMETERS..PARAMETERS + 6].copy_from_slice(&[
                    texels,
                    picture.width,
                    picture.height,
                    picture.levels(),
                    size.to_bits(),
                    u32::from(picture.encoded),
                ]);
                size / picture.width as f32
            }
            Pattern::UvPicture { picture, mapping } => {
                let texels = self.texels(picture);
                record[0] = UV_PICTURE_SOURCE;
                record[PARAMETERS..].copy_from_slice(&[
                    texels,
                    picture.width,
                    picture.height,
                    picture.levels(),
                    mapping.scale().to_bits(),
                    u32::from(picture.encoded),
                    mapping.wrap[0].code() | mapping.wrap[1].code() << 2 | u32::from(mapping.is_nearest) << 4,
                    mapping.set as u32 | (mapping.channel as u32) << 1 | u32::from(mapping.has_vertex_colours) << 3,
                ]);
                1.0
            }
        };
        let mut rows = texture.pose.local_from_world();
        if let Pattern::UvPicture { mapping, .. } = &texture.pattern {
            // Their coordinates are not those of the shape. The third row is the factor of the colour.
            rows[..2].copy_from_slice(&mapping.rows);
            rows[2] = mapping.factor;
        }
        let numbers = texture.pose.at.iter().chain(rows.as_flattened()).chain([&texture.pose.scale, &step]);
        for (word, number) in record[1..].iter_mut().zip(numbers) {
            *word = number.to_bits();
        }
        self.record(record)
    }

    /// Encodes a decal; returns its offset.
    fn decal(&mut self, decal: &'a Decal) -> u32 {
        let Decal { picture, size, depth, min_cosine, opacity, pose, space } = decal;
        let texels = self.texels(picture);
        let mut record = [0; TEXTURE_WORDS];
        record[0] = match space {
            DecalSpace::Shape => DECAL_SOURCE,
            DecalSpace::World => WORLD_DECAL_SOURCE,
        };
        let rows = pose.local_from_world();
        for (word, number) in record[1..].iter_mut().zip(pose.at.iter().chain(rows.as_flattened()).chain([&pose.scale]))
        {
            *word = number.to_bits();
        }
        record[PARAMETERS..PARAMETERS + 4].copy_from_slice(&[texels, picture.width, picture.height, picture.levels()]);
        record[PARAMETERS + 4..].copy_from_slice(&[*size, *depth, *min_cosine, *opacity].map(f32::to_bits));
        self.record(record)
    }

    fn record(&mut self, record: [u32; TEXTURE_WORDS]) -> u32 {
        let at = self.offset();
        self.words.extend(record);
        at
    }

    /// Offset of a picture's texels; encodes each picture once.
    fn texels(&mut self, picture: &'a Picture) -> u32 {
        if let Some((_, at)) = self.pictures.iter().find(|(known, _)| std::ptr::eq(*known, picture)) {
            return *at;
        }
        let at = self.offset();
        self.words.extend(&picture.texels);
        self.pictures.push((picture, at));
        at
    }
}
