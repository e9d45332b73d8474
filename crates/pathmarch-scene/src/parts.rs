//! Scenes built in code: the same shapes, operators and materials as in the scene language, without a text.
//!
//! [`shape`], [`operator`] and [`modifier`] make the tree of an object, [`material`] makes materials, and
//! [`Scene::from_parts`] makes a scene of them. Names, parameters and ranges are those of the language; everything that
//! is a mistake in a text is refused here, too, with a [`PartsError`]. Texts, polygons and custom SDFs can only be made
//! by the language. Cost: linear in the parts.

use crate::language::{MAX_NESTING, MAX_SHAPES};
use crate::light::Light;
use crate::materials::{self, Material, MaterialKind};
use crate::medium::Medium;
use crate::scene::{Camera, Moment, Object, Scene};
use crate::settings::{RENDER, RenderSettings, Setting};
use crate::sky::Sky;
use crate::unit::LengthUnit;
use glam::Vec3;
use pathmarch_field::graph::Kind;
use pathmarch_field::{Blend, Field, Node, Param, Placement, registry};
use std::collections::HashSet;

/// Error of parts that make no scene: the problem, its place, and what is expected.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PartsError(String);

fn refuse<T>(why: impl Into<String>) -> Result<T, PartsError> {
    Err(PartsError(why.into()))
}

/// Parts of a scene.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// At least one, with names that differ; the first is the default. `up` may have any length but zero.
    pub cameras: Vec<Camera>,
    /// Picture size, quality, and how light is followed.
    pub render: RenderSettings,
    /// Radiance of the surroundings.
    pub sky: Sky,
    /// Medium between the objects.
    pub fog: Medium,
    /// Suns and points. The direction of a sun may have any length but zero.
    pub lights: Vec<Light>,
    /// Materials; the tag of a shape is an index into these.
    pub materials: Vec<Material>,
    /// Solids with names that differ.
    pub objects: Vec<Object>,
}

/// A camera at `position` that looks at `target`, with defaults for the rest.
pub fn camera(position: [f32; 3], target: [f32; 3]) -> Camera {
    Camera {
        name: "main".to_owned(),
        position,
        target,
        up: [0.0, 1.0, 0.0],
        fov: 40.0,
        lens_radius: 0.0,
        focus: None,
        exposure: 0.0,
        auto_exposure: false,
    }
}

/// A material of this kind. `values` are parameters by their names; a number is the first of three. Others have their
/// defaults. The names of kinds and parameters are those of [`materials::kinds`].
///
/// # Errors
/// For an unknown kind or parameter, and for a value out of range.
pub fn material(name: &str, kind: &str, values: &[(&str, [f32; 3])]) -> Result<Material, PartsError> {
    let Some(kind) = materials::kind(kind) else {
        let known = materials::kinds().iter().map(|kind| kind.name);
        return refuse(format!("material \"{name}\": there is no kind \"{kind}\"; there are {}", listed(known)));
    };
    let mut material = Material::new(name, kind);
    for (param, value) in values {
        let Some(index) = kind.params.iter().position(|known| known.name() == *param) else {
            let known = kind.params.iter().map(|param| param.name());
            return refuse(format!(
                "material \"{name}\": no parameter \"{param}\"; {} has {}",
                kind.name,
                listed(known)
            ));
        };
        material.values[index] = *value;
    }
    check_material(&material)?;
    Ok(material)
}

/// A shape of the registry with all its parameters, in the order of [`Shape::params`](pathmarch_field::Shape::params),
/// with the material of this index. It is at the origin; [`Node::placement`] moves it.
///
/// # Errors
/// For an unknown shape, and for parameters out of range.
pub fn shape(name: &str, numbers: &[f32], material: usize) -> Result<Node, PartsError> {
    let Some(shape) = registry::shape(name) else { return refuse(format!("there is no shape \"{name}\"")) };
    if shape.info().outline.is_some() {
        return refuse(format!("\"{name}\" is drawn by the scene language only: use Scene::parse"));
    }
    check_numbers(name, shape.params(), numbers)?;
    let Ok(tag) = u32::try_from(material) else { return refuse(format!("\"{name}\": no material {material}")) };
    Ok(placed(Kind::Shape { shape: shape.into(), params: numbers.to_vec(), tag }))
}

/// An operator of the registry, such as `union` and `subtract`, over its children, sharp or blended.
///
/// # Errors
/// For an unknown operator, an unsupported blend, and a wrong number of children.
pub fn operator(name: &str, blend: Option<Blend>, children: Vec<Node>) -> Result<Node, PartsError> {
    let Some(operator) = registry::operator(name) else { return refuse(format!("there is no operator \"{name}\"")) };
    let node = placed(Kind::Operator { operator, smooth: blend, children });
    check_kind(&node.kind)?;
    Ok(node)
}

/// A modifier of the registry, such as `twist`, over the union of its children, with all its parameters.
///
/// # Errors
/// For an unknown modifier, for parameters out of range, and for no children.
pub fn modifier(name: &str, numbers: &[f32], children: Vec<Node>) -> Result<Node, PartsError> {
    let found = registry::modifiers().iter().copied().find(|modifier| &*modifier.info().name == name);
    let Some(modifier) = found else { return refuse(format!("there is no operator \"{name}\" that changes shapes")) };
    let node = placed(Kind::Modifier { modifier, params: numbers.to_vec(), children });
    check_kind(&node.kind)?;
    Ok(node)
}

fn placed(kind: Kind) -> Node {
    Node { kind, placement: Placement::default() }
}

impl Scene {
    /// Makes a scene of its parts. It has no text, so that [`source_text`](Scene::source_text) is empty, and nothing in it
    /// depends on the moment.
    ///
    /// # Errors
    /// For whatever a text would be refused for: numbers out of range, names twice, materials that are not there.
    pub fn from_parts(parts: SceneParts) -> Result<Self, PartsError> {
        let SceneParts { mut cameras, render, sky, fog, mut lights, materials, objects } = parts;
        if cameras.is_empty() {
            return refuse("a scene needs a camera");
        }
        check_names("camera", cameras.iter().map(|camera| camera.name.as_str()))?;
        check_names("material", materials.iter().map(|material| material.name.as_str()))?;
        check_names("object", objects.iter().map(|object| object.name.as_str()))?;
        cameras.iter_mut().try_for_each(check_camera)?;
        check_render(&render)?;
        check_sky(&sky)?;
        check_fog(&fog)?;
        lights.iter_mut().try_for_each(check_light)?;
        materials.iter().try_for_each(check_material)?;
        let mut shapes = 0;
        for object in &objects {
            let in_object = |PartsError(why): PartsError| PartsError(format!("object \"{}\": {why}", object.name));
            if object.material >= materials.len() {
                return Err(in_object(PartsError(format!("there is no material {}", object.material))));
            }
            let place = Place { depth: 0, in_profile: false };
            check_node(&object.root, place, materials.len(), &mut shapes).map_err(in_object)?;
        }
        let roots: Vec<_> = objects.iter().map(|object| object.root.clone()).collect();
        let field = Field::with_lamps(&roots, |tag| materials[tag as usize].is_even_lamp());
        Ok(Self {
            unit: LengthUnit::default(),
            cameras,
            render,
            sky,
            fog,
            lights,
            materials,
            objects,
            field,
            params: Vec::new(),
            includes: Vec::new(),
            moment: Moment::default(),
            animated: false,
            warnings: Vec::new(),
            source_name: "a scene built in code".to_owned(),
            source_text: String::new(),
        })
    }
}

fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

fn check_names<'a>(what: &str, names: impl Iterator<Item = &'a str>) -> Result<(), PartsError> {
    let mut seen = HashSet::new();
    for name in names {
        if !seen.insert(name) {
            return refuse(format!("two of the name \"{name}\": each {what} needs one of its own"));
        }
    }
    Ok(())
}

/// The direction with length one; an error for one of no length.
fn unit(what: &str, direction: [f32; 3]) -> Result<[f32; 3], PartsError> {
    let unit = Vec3::from(direction).as_dvec3().try_normalize();
    unit.map_or_else(|| refuse(format!("{what} must not be zero")), |unit| Ok(unit.as_vec3().into()))
}

fn check_camera(camera: &mut Camera) -> Result<(), PartsError> {
    let of = |what: &str| format!("camera \"{}\": {what}", camera.name);
    let finite = [camera.position, camera.target, camera.up].as_flattened().iter().all(|v| v.is_finite());
    if !finite || !camera.exposure.is_finite() {
        return refuse(of("every number must be finite"));
    }
    let view = Vec3::from(camera.target) - Vec3::from(camera.position);
    if view == Vec3::ZERO {
        return refuse(of("target and position must differ"));
    }
    let up = unit(&of("up"), camera.up)?;
    if view.as_dvec3().normalize().cross(Vec3::from(up).as_dvec3()).length() < 1e-6 {
        return refuse(of("up must not be along the view"));
    }
    if !(camera.fov > 0.0 && camera.fov < 180.0) {
        return refuse(of("fov must be above 0 and below 180 degrees"));
    }
    if !(camera.lens_radius >= 0.0 && camera.lens_radius.is_finite()) {
        return refuse(of("lens_radius must be 0 or more"));
    }
    if camera.focus.is_some_and(|focus| !(focus > 0.0 && focus.is_finite())) {
        return refuse(of("focus must be above 0"));
    }
    camera.up = up;
    Ok(())
}

fn check_render(render: &RenderSettings) -> Result<(), PartsError> {
    let accepts = |setting: &&Setting| render.get(setting.name).is_some_and(|value| setting.kind.accepts(value));
    match RENDER.iter().find(|setting| !accepts(setting)) {
        Some(setting) => refuse(format!("render: {} must be {}", setting.name, setting.kind.range_in_words())),
        None => Ok(()),
    }
}

fn is_radiance(radiance: &[f32; 3]) -> bool {
    radiance.iter().all(|&v| v >= 0.0 && v.is_finite())
}

fn check_sky(sky: &Sky) -> Result<(), PartsError> {
    let sound = match sky {
        Sky::Constant(radiance) => is_radiance(radiance),
        Sky::Gradient { zenith, horizon, ground } => [zenith, horizon, ground].into_iter().all(is_radiance),
        // Pictures were checked when they were read.
        Sky::Map(_) => true,
    };
    if sound { Ok(()) } else { refuse("sky: radiance must be 0 or more, and finite") }
}

fn check_fog(fog: &Medium) -> Result<(), PartsError> {
    if ![fog.absorption, fog.scattering, fog.emission].iter().all(is_radiance) {
        return refuse("fog: coefficients must be 0 or more, and finite");
    }
    if !(fog.anisotropy > -1.0 && fog.anisotropy < 1.0) {
        return refuse("fog: anisotropy must be above -1 and below 1");
    }
    Ok(())
}

fn check_light(light: &mut Light) -> Result<(), PartsError> {
    let (power, penumbra) = match light {
        Light::Sun { direction, irradiance, angle, penumbra } => {
            *direction = unit("sun: direction", *direction)?;
            if !(0.0..=180.0).contains(angle) {
                return refuse("sun: angle must be from 0 to 180 degrees");
            }
            (irradiance, penumbra)
        }
        Light::Point { at, intensity, penumbra } => {
            if !at.iter().all(|v| v.is_finite()) {
                return refuse("point: at must be finite");
            }
            (intensity, penumbra)
        }
        Light::Spot { at, direction, intensity, cone, blend, penumbra } => {
            *direction = unit("spot: direction", *direction)?;
            if !at.iter().all(|v| v.is_finite()) {
                return refuse("spot: at must be finite");
            }
            if !(*cone > 0.0 && *cone <= 180.0 && (0.0..=1.0).contains(blend)) {
                return refuse("spot: cone must be above 0 and at most 180 degrees, and blend from 0 to 1");
            }
            (intensity, penumbra)
        }
    };
    if !is_radiance(power) {
        return refuse("a light's irradiance or intensity must be 0 or more, and finite");
    }
    if penumbra.is_some_and(|penumbra| !(penumbra > 0.0 && penumbra.is_finite())) {
        return refuse("a light's penumbra must be above 0");
    }
    Ok(())
}

fn check_material(material: &Material) -> Result<(), PartsError> {
    let Material { name, kind, values, .. } = material;
    let MaterialKind { params, name: kind, .. } = kind;
    if values.len() != params.len() {
        return refuse(format!("material \"{name}\": {kind} has {} parameters, not {}", params.len(), values.len()));
    }
    for (param, value) in params.iter().zip(values) {
        if !value.iter().all(|v| param.spec.range.accepts(*v)) {
            let range = param.spec.range.in_words();
            return refuse(format!("material \"{name}\": {} must be {range}, not {value:?}", param.name()));
        }
    }
    Ok(())
}

fn check_numbers(what: &str, params: &[Param], numbers: &[f32]) -> Result<(), PartsError> {
    if params.len() != numbers.len() {
        let names = listed(params.iter().map(|param| &*param.name));
        return refuse(format!("\"{what}\" takes {} numbers ({names}), not {}", params.len(), numbers.len()));
    }
    for (param, &number) in params.iter().zip(numbers) {
        if !param.accepts(number) {
            return refuse(format!("\"{what}\": {} must be {}, not {number}", param.name, param.range_in_words()));
        }
    }
    Ok(())
}

/// Checks a node without those below it.
fn check_kind(kind: &Kind) -> Result<(), PartsError> {
    match kind {
        // Its outline is behind its parameters; only the language makes such a shape, and checks it.
        Kind::Shape { shape, .. } if shape.info().outline.is_some() => Ok(()),
        Kind::Shape { shape, params, .. } => check_numbers(&shape.info().name, shape.params(), params),
        Kind::Operator { operator, smooth, children } => {
            let (name, (least, most)) = (&*operator.info().name, operator.children());
            if !(least..=most).contains(&children.len()) {
                let most = if most == usize::MAX { "or more".to_owned() } else { format!("to {most}") };
                return refuse(format!("\"{name}\" takes {least} {most} shapes, not {}", children.len()));
            }
            match (smooth, operator.params()) {
                (Some(blend), [param]) if !operator.blends() => {
                    check_numbers(name, std::slice::from_ref(param), &[blend.amount])
                }
                (None, [_]) if !operator.blends() => refuse(format!("\"{name}\" needs the amount of a blend")),
                (Some(_), _) if !operator.blends() => refuse(format!("\"{name}\" does not blend")),
                (Some(blend), _) if !(blend.amount > 0.0 && blend.amount.is_finite()) => {
                    refuse(format!("\"{name}\": a blend must be above 0 m wide, not {}", blend.amount))
                }
                (Some(blend), _) if !(blend.steps >= 1.0 && blend.steps.fract() == 0.0 && blend.steps <= 1000.0) => {
                    refuse(format!("\"{name}\": a blend has from 1 to 1000 whole steps, not {}", blend.steps))
                }
                _ => Ok(()),
            }
        }
        Kind::Modifier { modifier, params, children } => {
            let name = &*modifier.info().name;
            if children.is_empty() {
                return refuse(format!("\"{name}\" needs a shape"));
            }
            check_numbers(name, modifier.params(), params)
        }
    }
}

fn check_placement(placement: &Placement) -> Result<(), PartsError> {
    let Placement { normal, scale, rotate, at } = placement;
    let numbers = [normal, rotate, at].into_iter().flatten().flatten();
    if !numbers.chain(scale).all(|v| v.is_finite()) {
        return refuse("a placement's numbers must be finite");
    }
    if scale.is_some_and(|scale| scale <= 0.0) {
        return refuse("a placement's scale must be above 0");
    }
    normal.map_or(Ok(()), |normal| unit("a placement's normal", normal).map(drop))
}

/// Position of a node in its object.
#[derive(Clone, Copy)]
struct Place {
    /// Operators around it.
    depth: usize,
    /// True within an operator that makes solids of profiles.
    in_profile: bool,
}

fn check_node(node: &Node, place: Place, materials: usize, shapes: &mut usize) -> Result<(), PartsError> {
    if place.depth > MAX_NESTING {
        return refuse(format!("operators are nested more than {MAX_NESTING} levels deep"));
    }
    check_placement(&node.placement)?;
    check_kind(&node.kind)?;
    let (children, in_profile) = match &node.kind {
        Kind::Shape { shape, tag, .. } => {
            *shapes += 1;
            let name = &*shape.info().name;
            if *shapes > MAX_SHAPES {
                return refuse(format!("a scene has at most {MAX_SHAPES} shapes"));
            }
            if *tag as usize >= materials {
                return refuse(format!("\"{name}\": there is no material {tag}; there are {materials}"));
            }
            if shape.info().profile && !place.in_profile {
                return refuse(format!(
                    "\"{name}\" is a profile: it has no depth; put it into an operator of profiles"
                ));
            }
            return Ok(());
        }
        Kind::Operator { children, .. } => (children, place.in_profile),
        Kind::Modifier { modifier, children, .. } => (children, place.in_profile || modifier.of_profiles()),
    };
    let below = Place { depth: place.depth + 1, in_profile };
    children.iter().try_for_each(|child| check_node(child, below, materials, shapes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts() -> SceneParts {
        let ball = shape("sphere", &[1.0], 0).expect("a shape");
        SceneParts {
            cameras: vec![camera([0.0, 1.0, 4.0], [0.0; 3])],
            sky: Sky::Constant([1.0; 3]),
            materials: vec![material("clay", "diffuse", &[("albedo", [0.7, 0.2, 0.1])]).expect("a material")],
            objects: vec![Object { name: "ball".to_owned(), material: 0, root: ball }],
            ..SceneParts::default()
        }
    }

    /// The same scene from code and from a text.
    #[test]
    fn what_is_built_is_what_is_written() {
        let mut parts = parts();
        let mut hole = shape("box", &[1.0, 1.0, 1.0], 0).expect("a shape");
        hole.placement =
            Placement { at: Some([0.5, 0.5, 0.5]), rotate: Some([0.0, 30.0, 0.0]), ..Placement::default() };
        let ball = parts.objects[0].root.clone();
        parts.objects[0].root = operator("subtract", Some(0.1.into()), vec![ball, hole]).expect("an operator");
        parts.lights.push(Light::Sun { direction: [0.0, 3.0, 0.0], irradiance: [2.0; 3], angle: 1.0, penumbra: None });
        let built = Scene::from_parts(parts).expect("a scene");
        let text = "pathmarch 1\ncamera { position 0 1 4; target 0 0 0 }\nsky 1\nsun { direction 0 3 0; irradiance 2; angle 1 }\n\
                    material \"clay\" { diffuse 0.7 0.2 0.1 }\nobject \"ball\" material=\"clay\" { subtract smooth=0.1 { sphere 1\n\
                    box 1 1 1 { at 0.5 0.5 0.5; rotate 0 30 0 } } }\n";
        let written = Scene::parse("ball.kdl", text).expect("a scene");
        assert_eq!(built.cameras, written.cameras);
        assert_eq!((built.render.clone(), built.sky.clone()), (written.render.clone(), written.sky.clone()));
        assert_eq!(built.lights, written.lights);
        assert_eq!(built.materials[0].values, written.materials[0].values);
        for index in 0..1000 {
            let at = |k: usize| ((index * (7 + 4 * k)) % 100) as f32 / 25.0 - 2.0;
            let p = pathmarch_field::number::Vec3::new(at(0), at(1), at(2));
            assert_eq!(built.field.distance(p), written.field.distance(p));
        }
    }

    #[test]
    fn parts_that_make_no_scene_are_refused_with_the_reason() {
        let refused = |change: &dyn Fn(&mut SceneParts), words: &str| {
            let mut parts = parts();
            change(&mut parts);
            let error = Scene::from_parts(parts).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        };
        refused(&|parts| parts.cameras.clear(), "needs a camera");
        refused(&|parts| parts.cameras.push(parts.cameras[0].clone()), "two of the name \"main\"");
        refused(&|parts| parts.cameras[0].target = parts.cameras[0].position, "must differ");
        refused(&|parts| parts.cameras[0].up = [0.0, -1.0, -4.0], "along the view");
        refused(&|parts| parts.cameras[0].fov = f32::NAN, "fov");
        refused(&|parts| parts.render.samples = 0, "samples");
        refused(&|parts| parts.sky = Sky::Constant([f32::INFINITY; 3]), "sky");
        refused(&|parts| parts.materials.clear(), "there is no material 0");
        refused(&|parts| parts.materials[0].values[0] = [2.0; 3], "albedo must be");
        refused(&|parts| parts.objects[0].root.placement.scale = Some(0.0), "scale");
        refused(&|parts| parts.objects[0].root = shape("sphere", &[1.0], 7).expect("a node"), "no material 7");
        refused(&|parts| parts.objects[0].root = shape("circle", &[1.0], 0).expect("a node"), "profile");
        refused(
            &|parts| {
                for _ in 0..100 {
                    let root = parts.objects[0].root.clone();
                    parts.objects[0].root = operator("union", None, vec![root]).expect("an operator");
                }
            },
            "nested",
        );
        let error = |result: Result<Node, PartsError>| result.expect_err("refused").to_string();
        assert!(error(shape("spere", &[1.0], 0)).contains("no shape \"spere\""));
        assert!(error(shape("sphere", &[], 0)).contains("1 numbers (radius), not 0"));
        assert!(error(shape("sphere", &[-1.0], 0)).contains("above 0"));
        assert!(error(shape("text", &[], 0)).contains("scene language only"));
        assert!(
            error(operator("union", Some(0.0.into()), vec![shape("sphere", &[1.0], 0).unwrap()])).contains("above 0")
        );
        assert!(error(operator("union", None, Vec::new())).contains("not 0"));
        assert!(error(modifier("twist", &[90.0], Vec::new())).contains("needs a shape"));
        assert!(material("a", "clay", &[]).is_err_and(|error| error.to_string().contains("there are diffuse")));
        assert!(material("a", "diffuse", &[("ior", [1.5; 3])]).is_err());
    }
}
