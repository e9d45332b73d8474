//! What varies along a surface: the material's numbers where a path has met it, and the normal that light sees.
//!
//! **Colours and numbers.** A material is packed into numbers that its scattering functions read. Where textures or the orbit of
//! a fractal ([`OrbitTrap`]) stand for parameters, each surface that is met has numbers of its own. A colour is put in its
//! place there. For another parameter the material has been packed for [`KNOTS`] values of it, and what is between two
//! of these is interpolated: the numbers of `principled` are integrals that no path can wait for. How a material transmits and
//! whether it scatters in single directions is decided for the whole of it.
//!
//! **Relief.** The normal follows the slope of a height: n' = n - (∇h - n (n·∇h)), normalised (Blinn 1978, "Simulation of
//! Wrinkled Surfaces"; in this form Mikkelsen 2010). It is then turned back towards the true normal as far as needed for the mirrored
//! view to leave the surface, so that no mirror shows black (the problem is told in Schüßler et al. 2017, section 3; Cycles turns
//! the normal back, too). What scatters through the true surface to the wrong side is lost. The shape itself, its
//! outline and its shadows know nothing of it.
//!
//! **Where.** In the coordinates of the leaf ([`Field::coordinates`](pathmarch_field::Field::coordinates)). A height is
//! scaled with the shape. **Cost.** One evaluation for each texture, four for a relief; nothing for materials without.

use crate::frame::Prepared;
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::graph::Coordinates;
use pathmarch_field::number::Vec3 as FieldVec3;
use pathmarch_scene::materials::{
    Bsdf, BsdfParameters, Bump, Material, OrbitTrap, PreviewMaterial, TextureMapping, Texturing,
};
use pathmarch_scene::textures::{self, Pattern, Spot, Texture, ramp};

/// Values of a number for which its material is packed.
pub(crate) const KNOTS: usize = 17;

/// What gives a value from 0 to 1, or a colour.
#[derive(Clone, Debug)]
enum Source {
    Orbit(OrbitTrap),
    Texture(Texture),
}

/// What the value changes.
#[derive(Clone, Debug)]
enum Change {
    /// The three numbers from this place on are a colour of this row, or the texture's own.
    Colour { place: usize, colours: Option<Vec<[f32; 3]>> },
    /// The numbers at these places, for each of the knots.
    Numbers { places: Vec<usize>, knots: Vec<Vec<f32>> },
}

#[derive(Clone, Debug)]
struct Layer {
    source: Source,
    change: Change,
    /// How a quick picture's numbers change: for each channel of the colour by as much, or for each of the knots.
    looks: Vec<LookNumbers>,
    /// The colour that the material has without.
    base: [f32; 3],
}

/// What varies of a material.
#[derive(Clone, Debug, Default)]
pub(crate) struct Paint {
    layers: Vec<Layer>,
    bump: Option<Bump>,
}

/// The numbers of a [`PreviewMaterial`], in the order of `preview.wgsl`.
pub(super) const LOOK_SIZE: usize = 14;
pub(super) type LookNumbers = [f32; LOOK_SIZE];

/// The numbers of a look, and back.
pub(super) fn look_numbers(look: &PreviewMaterial) -> LookNumbers {
    let [straight, grazing] = look.specular;
    let mut numbers = [0.0; LOOK_SIZE];
    numbers[..3].copy_from_slice(&look.diffuse);
    numbers[3] = look.roughness;
    numbers[4..7].copy_from_slice(&straight);
    numbers[7..10].copy_from_slice(&grazing);
    numbers[10..13].copy_from_slice(&look.transmission);
    numbers[13] = look.ior;
    numbers
}

pub(super) fn look_of(numbers: &LookNumbers) -> PreviewMaterial {
    let three = |at: usize| [numbers[at], numbers[at + 1], numbers[at + 2]];
    PreviewMaterial {
        diffuse: three(0),
        roughness: numbers[3],
        specular: [three(4), three(7)],
        transmission: three(10),
        ior: numbers[13],
    }
}

/// Which channel of a colour a number of a look depends on.
fn channel(number: usize) -> usize {
    if number < 3 { number } else { number.saturating_sub(4) % 3 }
}

impl Paint {
    pub(crate) fn new(material: &Material) -> Self {
        let Some(bsdf) = material.kind.bsdf else { return Self::default() };
        let mut layers: Vec<Layer> = Vec::new();
        for painted in &material.textured {
            let source = Source::Texture(painted.texture.clone());
            let layer = match (material.kind.params[painted.param].texturing, &painted.mapping) {
                (Texturing::Colour(place), TextureMapping::Ramp(colours)) => {
                    Layer::of_colour(material, painted.param, place, source, Some(colours.clone()))
                }
                (Texturing::Colour(place), _) => Layer::of_colour(material, painted.param, place, source, None),
                (_, TextureMapping::Range(range)) => Layer::of_number(material, bsdf, painted.param, source, *range),
                _ => continue,
            };
            layers.push(layer);
        }
        // Last, so that it has the last word on fractals.
        if let Some(trap) = &material.orbit_trap
            && let Some(Texturing::Colour(place)) = material.kind.params.first().map(|param| param.texturing)
        {
            let colours = Some(trap.colours.clone());
            layers.push(Layer::of_colour(material, 0, place, Source::Orbit(trap.clone()), colours));
        }
        Self { layers, bump: material.bump.clone() }
    }

    pub(crate) fn is_plain(&self) -> bool {
        self.layers.is_empty() && self.bump.is_none()
    }

    pub(crate) fn has_bump(&self) -> bool {
        self.bump.is_some()
    }

    pub(crate) fn has_orbit(&self) -> bool {
        self.layers.iter().any(|layer| matches!(layer.source, Source::Orbit(_)))
    }

    fn textures(&self) -> impl Iterator<Item = &Texture> {
        let of_layers = self.layers.iter().filter_map(|layer| match &layer.source {
            Source::Texture(texture) => Some(texture),
            Source::Orbit(_) => None,
        });
        of_layers.chain(self.bump.iter().map(|bump| &bump.texture))
    }

    /// Numbers of the kinds of computed textures in use, and whether any shows a picture.
    pub(crate) fn uses(&self) -> (Vec<usize>, bool) {
        let mut kinds = Vec::new();
        let mut pictures = false;
        for texture in self.textures() {
            match &texture.pattern {
                Pattern::Computed { kind, .. } => kinds.push(number_of(kind)),
                Pattern::Picture { .. } => pictures = true,
            }
        }
        (kinds, pictures)
    }

    /// All sets of numbers that this may give the material, as far as its kind decides by them.
    pub(crate) fn extremes(&self, numbers: &BsdfParameters) -> Vec<BsdfParameters> {
        let mut all = Vec::new();
        for layer in &self.layers {
            if let Change::Numbers { places, knots } = &layer.change {
                all.extend(knots.iter().map(|knot| {
                    let mut own = *numbers;
                    places.iter().zip(knot).for_each(|(place, number)| own[*place] = *number);
                    own
                }));
            }
        }
        all
    }
}

/// The number of a kind of texture in the kernel.
fn number_of(kind: &'static textures::TextureKind) -> usize {
    textures::kinds().iter().position(|other| std::ptr::eq(*other, kind)).unwrap_or_default()
}

impl Layer {
    fn of_colour(
        material: &Material,
        param: usize,
        place: usize,
        source: Source,
        colours: Option<Vec<[f32; 3]>>,
    ) -> Self {
        let look_of = |grey: f32| {
            let mut values = material.values.clone();
            values[param] = [grey; 3];
            look_numbers(&(material.kind.preview)(&values))
        };
        let (black, white) = (look_of(0.0), look_of(1.0));
        // What does not depend on it channel by channel stays.
        let slope = std::array::from_fn(|k| if k == 3 || k == 13 { 0.0 } else { white[k] - black[k] });
        let change = Change::Colour { place, colours };
        Self { source, change, looks: vec![slope], base: material.values[param] }
    }

    fn of_number(material: &Material, bsdf: &Bsdf, param: usize, source: Source, [from, to]: [f32; 2]) -> Self {
        let values: Vec<Vec<[f32; 3]>> = (0..KNOTS)
            .map(|k| {
                let mut values = material.values.clone();
                values[param][0] = from + (to - from) * k as f32 / (KNOTS - 1) as f32;
                values
            })
            .collect();
        let packed: Vec<BsdfParameters> = values.iter().map(|values| (bsdf.pack)(values)).collect();
        let places: Vec<usize> =
            (0..packed[0].len()).filter(|&k| packed.iter().any(|numbers| numbers[k] != packed[0][k])).collect();
        let knots = packed.iter().map(|numbers| places.iter().map(|&place| numbers[place]).collect()).collect();
        let middle = look_numbers(&material.preview());
        let looks = values.iter().map(|values| {
            let look = look_numbers(&(material.kind.preview)(values));
            std::array::from_fn(|k| look[k] - middle[k])
        });
        Self { source, change: Change::Numbers { places, knots }, looks: looks.collect(), base: [0.0; 3] }
    }
}

/// Between two of the knots.
fn between<T>(knots: &[T], value: f32) -> (&T, &T, f32) {
    let place = value * (KNOTS - 1) as f32;
    let first = (place as usize).min(KNOTS - 2);
    (&knots[first], &knots[first + 1], place - first as f32)
}

/// A point on a surface whose material varies.
pub(crate) struct Painted<'p> {
    paint: &'p Paint,
    spot: Spot,
    here: Coordinates,
    orbit: Option<[f32; 5]>,
    /// World metres of a local unit.
    size: f32,
}

impl<'p> Painted<'p> {
    /// The point `p` of a leaf, whose outward normal is `outward`, at the end of a path of this length; `None` where
    /// nothing varies.
    #[inline]
    pub(crate) fn new(prepared: &'p Prepared, leaf: usize, p: Vec3, outward: Vec3, length: f32) -> Option<Self> {
        let paint = prepared.paints.get(prepared.leaves[leaf].material as usize).filter(|paint| !paint.is_plain())?;
        Self::by(paint, prepared, leaf, p, outward, length)
    }

    /// Apart, so that what is plain costs no call.
    fn by(paint: &'p Paint, prepared: &Prepared, leaf: usize, p: Vec3, outward: Vec3, length: f32) -> Option<Self> {
        let p = FieldVec3::new(p.x, p.y, p.z);
        let here = prepared.field.coordinates(leaf, p)?;
        let vector = |v: FieldVec3<f32>| Vec3::new(v.x, v.y, v.z);
        let [x, y, z] = here.gradients.map(vector);
        // Normals turn by the transposed inverse.
        let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
        let determinant = x.dot(cofactors[0]);
        let size = determinant.abs().max(1e-30).cbrt().recip();
        let across = Vec3::from_array(cofactors.map(|cofactor| cofactor.dot(outward)));
        let normal = (across * determinant.signum()).normalize_or(Vec3::Y);
        let covered = prepared.frame.pixel * length;
        let spot = Spot { p: vector(here.point), normal, footprint: covered / size };
        let orbit = if paint.has_orbit() { prepared.field.orbit(leaf, p) } else { None };
        Some(Self { paint, spot, here, orbit, size })
    }

    /// The value of a source; `None` where it has none here.
    fn value(&self, source: &Source) -> Option<f32> {
        match source {
            Source::Orbit(trap) => self.orbit.as_ref().map(|orbit| trap.place(orbit)),
            Source::Texture(texture) => Some(texture.value(&self.spot)),
        }
    }

    fn colour_of(&self, source: &Source, colours: Option<&Vec<[f32; 3]>>) -> Option<Vec3> {
        match (colours, source) {
            (None, Source::Texture(texture)) => Some(texture.colour(&self.spot)),
            (Some(colours), _) => Some(ramp(colours, self.value(source)?).into()),
            (None, Source::Orbit(_)) => None,
        }
    }

    /// The material's numbers here.
    pub(crate) fn numbers(&self, numbers: &BsdfParameters) -> BsdfParameters {
        let mut own = *numbers;
        for layer in &self.paint.layers {
            match &layer.change {
                Change::Colour { place, colours } => {
                    if let Some(colour) = self.colour_of(&layer.source, colours.as_ref()) {
                        own[*place..*place + 3].copy_from_slice(&colour.to_array());
                    }
                }
                Change::Numbers { places, knots } => {
                    let Some(value) = self.value(&layer.source) else { continue };
                    let (a, b, part) = between(knots, value);
                    for ((place, a), b) in places.iter().zip(a).zip(b) {
                        own[*place] = a + (b - a) * part;
                    }
                }
            }
        }
        own
    }

    /// The material's colour here, its first parameter, where that varies.
    pub(crate) fn colour(&self) -> Option<Vec3> {
        let mut colours = self.paint.layers.iter().filter_map(|layer| match &layer.change {
            Change::Colour { place: 0, colours } => self.colour_of(&layer.source, colours.as_ref()),
            _ => None,
        });
        colours.next_back()
    }

    /// What a quick picture shows of the material here.
    pub(super) fn look(&self, look: LookNumbers) -> LookNumbers {
        let mut own = look;
        for layer in &self.paint.layers {
            match &layer.change {
                Change::Colour { colours, .. } => {
                    let Some(colour) = self.colour_of(&layer.source, colours.as_ref()) else { continue };
                    let change = colour - Vec3::from(layer.base);
                    (0..LOOK_SIZE).for_each(|k| own[k] += layer.looks[0][k] * change[channel(k)]);
                }
                Change::Numbers { .. } => {
                    let Some(value) = self.value(&layer.source) else { continue };
                    let (a, b, part) = between(&layer.looks, value);
                    (0..LOOK_SIZE).for_each(|k| own[k] += a[k] + (b[k] - a[k]) * part);
                }
            }
        }
        own
    }

    /// The normal that light sees on the side of `normal`, which is the true one there; `view` points away from the
    /// surface, to where it is seen from.
    pub(crate) fn normal(&self, outward: Vec3, normal: Vec3, view: Vec3) -> Vec3 {
        let Some(bump) = &self.paint.bump else { return normal };
        let slope = bump.texture.slope(&self.spot) * bump.height;
        let [x, y, z] = self.here.gradients.map(|g| Vec3::new(g.x, g.y, g.z));
        let gradient = (x * slope.x + y * slope.y + z * slope.z) * self.size;
        let along = gradient - outward * outward.dot(gradient);
        let side = if normal.dot(outward) < 0.0 { -1.0 } else { 1.0 };
        visible_normal((outward - along).normalize() * side, normal, view)
    }
}

/// The normal nearest to `bent`, between it and the true normal, that mirrors the view to the side of the true one.
///
/// In the plane of both normals, with θ the angle between them, the view at φ from the true normal and |view| = A there, the
/// mirrored view is at 2θ - φ: it is at least t above the surface for cos(2θ - φ) ≥ t/A.
fn visible_normal(bent: Vec3, normal: Vec3, view: Vec3) -> Vec3 {
    let above = view.dot(normal).max(1e-5);
    let height = bent.dot(normal);
    let aside = bent - normal * height;
    let tilt = aside.length();
    if tilt < 1e-6 {
        return normal;
    }
    let aside = aside / tilt;
    let sideways = view.dot(aside);
    let least = (0.9 * above).min(0.01);
    let steepest = 0.5 * (sideways.atan2(above) + (least / sideways.hypot(above)).acos());
    let angle = tilt.atan2(height).min(steepest);
    normal * angle.cos() + aside * angle.sin()
}

/// What is in the tables for textures, to stand at `start`: for each leaf where it stands, then for each material where what
/// varies of it is told, or 0; then these.
pub(crate) fn words(field: &Field, paints: &[Paint], start: usize) -> Vec<u32> {
    let mut words: Vec<u32> = Vec::new();
    for (index, leaf) in field.leaves().iter().enumerate() {
        let rows = leaf.pose.local_from_world();
        words.extend(leaf.pose.at.iter().chain(rows.as_flattened()).map(|number| number.to_bits()));
        words.push(field.holder(index));
    }
    let first = words.len();
    words.resize(first + paints.len(), 0);
    let mut pictures: Vec<(*const textures::Picture, u32)> = Vec::new();
    for (index, paint) in paints.iter().enumerate().filter(|(_, paint)| !paint.is_plain()) {
        let mut add_texture = |words: &mut Vec<u32>, source: &Source| -> u32 {
            let mut record = vec![0; TEXTURE_WORDS];
            match source {
                Source::Orbit(trap) => {
                    let [from, to] = trap.range.map(f32::to_bits);
                    record[0] = ORBIT;
                    record[NUMBERS..NUMBERS + 3].copy_from_slice(&[trap.trap as u32, from, to]);
                }
                Source::Texture(texture) => {
                    let pose = &texture.pose;
                    let rows = pose.local_from_world();
                    let place = pose.at.iter().chain(rows.as_flattened()).chain([&pose.scale]);
                    let step = match &texture.pattern {
                        Pattern::Computed { kind, parameters: numbers } => {
                            record[0] = number_of(kind) as u32;
                            record[NUMBERS..].copy_from_slice(&numbers.map(f32::to_bits));
                            (kind.step)(numbers)
                        }
                        Pattern::Picture { picture, size } => {
                            let known = pictures.iter().find(|(known, _)| *known == &raw const **picture);
                            let at = match known {
                                Some((_, at)) => *at,
                                None => {
                                    let at = (start + words.len()) as u32;
                                    words.extend(&picture.texels);
                                    pictures.push((&raw const **picture, at));
                                    at
                                }
                            };
                            record[0] = PICTURE;
                            record[NUMBERS..NUMBERS + 6].copy_from_slice(&[
                                at,
                                picture.width,
                                picture.height,
                                picture.levels(),
                                size.to_bits(),
                                u32::from(picture.encoded),
                            ]);
                            size / picture.width as f32
                        }
                    };
                    for (word, number) in record[1..].iter_mut().zip(place.chain([&step])) {
                        *word = number.to_bits();
                    }
                }
            }
            words.extend(record);
            (start + words.len() - TEXTURE_WORDS) as u32
        };
        let layers: Vec<u32> = paint
            .layers
            .iter()
            .map(|layer| {
                let texture = add_texture(&mut words, &layer.source);
                let looks = (start + words.len()) as u32;
                if let Change::Colour { .. } = layer.change {
                    words.extend(layer.base.map(f32::to_bits));
                }
                words.extend(layer.looks.as_flattened().iter().map(|number| number.to_bits()));
                let at = (start + words.len()) as u32;
                match &layer.change {
                    Change::Colour { place, colours: Some(colours) } => {
                        words.extend([texture, COLOURS, *place as u32, looks, colours.len() as u32 - 1]);
                        words.extend(colours.as_flattened().iter().map(|channel| channel.to_bits()));
                    }
                    Change::Colour { place, colours: None } => {
                        words.extend([texture, OWN_COLOURS, *place as u32, looks]);
                    }
                    Change::Numbers { places, knots } => {
                        words.extend([texture, PACKED, places.len() as u32, looks]);
                        words.extend(places.iter().map(|place| *place as u32));
                        words.extend(knots.iter().flatten().map(|number| number.to_bits()));
                    }
                }
                at
            })
            .collect();
        let bump = paint.bump.as_ref().map_or(0, |bump| {
            let texture = add_texture(&mut words, &Source::Texture(bump.texture.clone()));
            words.extend([texture, bump.height.to_bits()]);
            (start + words.len() - 2) as u32
        });
        words[first + index] = (start + words.len()) as u32;
        words.extend([layers.len() as u32, bump]);
        words.extend(layers);
        // The kernel may look one word beyond.
        words.push(0);
    }
    words
}

/// Words of a texture: kind, place, three rows, scale, step, numbers.
const TEXTURE_WORDS: usize = NUMBERS + textures::MAX_PARAMETERS;
const NUMBERS: usize = 15;
/// What stands for a kind of texture that is not in the list.
pub(crate) const ORBIT: u32 = 1000;
pub(crate) const PICTURE: u32 = 1001;
/// What a layer changes.
const COLOURS: u32 = 0;
pub(crate) const OWN_COLOURS: u32 = 1;
pub(crate) const PACKED: u32 = 2;
