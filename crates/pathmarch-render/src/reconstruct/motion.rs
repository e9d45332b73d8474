//! Motion of the surfaces between two scenes: where the present point of each pixel was in the earlier one.
//!
//! **Idea.** Points of rigid objects are moved back exactly. For an object that deforms, the earlier field itself is
//! evaluated at the point, moved as its leaf has moved, and a few Newton steps along the gradient find the surface there. A
//! point that ends farther from it than the side of a pixel was on no surface: it has no past.
//!
//! **Limits.** What mirrors show of moving objects counts as still, and so do meshes that deform and objects beyond
//! [`MAX_DEFORMING_LEAVES`]; their pixels go on only where the point is on the surface of the last picture by chance, and
//! start anew elsewhere. Between scenes of different structure nothing moves.

use super::surfaces::Vectors;
use crate::integrator::guides::{Guide, NO_LEAF};
use crate::intersect::ray::{lanes, transposed};
use crate::scene::RenderScene;
use crate::wgsl::{shared_constants, shared_struct};
use glam::Vec3;
use pathmarch_field::Field;
use pathmarch_field::graph::{Displacement, Leaf, ObjectMotion, SPHERE_TRACED, Surface};
use pathmarch_field::number::Vec3 as FieldVec3;
use rayon::prelude::*;
use wide::f32x8;

shared_constants! {
    /// Newton steps towards the surface of an earlier field.
    const EARLIER_STEPS: u32 = 4;
    /// Least square of a gradient that such a step is divided by.
    const MIN_SQUARED_GRADIENT: f32 = 0.04;
    /// Largest distance of a point from the surface of an earlier field, in sides of a pixel at its distance.
    const SURFACE_TOLERANCE: f32 = 0.5;
    /// Coordinate of points without a past.
    const NOWHERE: f32 = 1e18;
}

/// Most leaves of all objects that deform at once.
const MAX_DEFORMING_LEAVES: usize = 64;

shared_struct! {
    /// Object of a leaf, and its motion since an earlier scene: the rows of its rotation, its scale and its offset.
    pub(super) struct LeafMotion as LeafMotion {
        x: [f32; 3],
        offset_x: f32,
        y: [f32; 3],
        offset_y: f32,
        z: [f32; 3],
        offset_z: f32,
        scale: f32,
        /// Not 0 if the leaf has moved.
        moves: u32,
        /// Index of the object.
        object: u32,
        /// Not 0 if the object deforms.
        deforms: u32,
    }
}

/// Motion of a leaf since an earlier scene.
#[derive(Clone, Copy)]
struct Moved {
    /// Displacement of its points; in an object that deforms, the first guess.
    displacement: Displacement,
    deforms: bool,
}

/// Motion since an earlier scene.
#[derive(Default)]
pub(crate) struct Motion {
    /// Motion of each leaf; `None` for those that stand still.
    leaves: Vec<Option<Moved>>,
    /// Earlier field of the objects that deform, if there are any.
    pub(super) earlier_field: Option<Field>,
}

/// Point in an earlier scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EarlierPoint {
    /// Position in world space; far from everything if the point was on no surface.
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
}

/// Points of all pixels in an earlier scene; empty if nothing moves.
#[derive(Default)]
pub(crate) struct EarlierPoints(Vec<EarlierPoint>);

impl EarlierPoints {
    /// Earlier point of the pixel of an index, which has this guide.
    #[inline]
    pub(crate) fn at(&self, index: usize, guide: &Guide) -> EarlierPoint {
        let still = EarlierPoint { position: guide.position, normal: guide.normal };
        self.0.get(index).copied().unwrap_or(still)
    }

    /// Earlier positions and normals of the pixels of these indices; `None` if nothing moves.
    #[inline]
    pub(super) fn lanes(&self, indices: [usize; 8]) -> Option<(Vectors, Vectors)> {
        if self.0.is_empty() {
            return None;
        }
        let row = |index: usize| {
            let EarlierPoint { position: p, normal: n } = self.0[index];
            [p.x, p.y, p.z, 0.0, n.x, n.y, n.z, 0.0]
        };
        let [px, py, pz, _, nx, ny, nz, _] = transposed(indices.map(row));
        Some((Vectors::new(px, py, pz), Vectors::new(nx, ny, nz)))
    }
}

impl Motion {
    /// Motion between two scenes. Without the same number of leaves in both, nothing moves.
    pub(crate) fn new(earlier: &RenderScene, present: &RenderScene) -> Self {
        let (earlier, field) = (&earlier.field, &present.field);
        if earlier.leaves().len() != field.leaves().len() {
            return Self::default();
        }
        let count = field.object_bounds().len();
        let motions: Vec<ObjectMotion> = (0..count).map(|object| field.object_motion(earlier, object)).collect();
        let mut leaves_of = vec![0; count];
        for leaf in
            field.leaves().iter().filter(|leaf| motions.get(leaf.object as usize) == Some(&ObjectMotion::Deforming))
        {
            // Meshes have no numbers that change their shape.
            leaves_of[leaf.object as usize] += if leaf.shape.mesh().is_some() { MAX_DEFORMING_LEAVES + 1 } else { 1 };
        }
        let mut total = 0;
        let mut deforms = vec![false; count];
        for object in (0..count).filter(|&object| leaves_of[object] > 0) {
            deforms[object] = total + leaves_of[object] <= MAX_DEFORMING_LEAVES;
            total += if deforms[object] { leaves_of[object] } else { 0 };
        }
        let of = |(before, leaf): (&Leaf, &Leaf)| {
            let object = leaf.object as usize;
            let displacement = match motions.get(object)? {
                ObjectMotion::Still => return None,
                ObjectMotion::Rigid(displacement) => *displacement,
                ObjectMotion::Deforming if leaf.modified => Displacement::NONE,
                ObjectMotion::Deforming => Displacement::between(&leaf.pose, &before.pose),
            };
            Some(Moved { displacement, deforms: deforms[object] })
        };
        let objects: Vec<usize> = (0..count).filter(|&object| deforms[object]).collect();
        Self {
            leaves: earlier.leaves().iter().zip(field.leaves()).map(of).collect(),
            earlier_field: (!objects.is_empty()).then(|| earlier.of_objects(&objects)),
        }
    }

    /// Records of all leaves of the present scene.
    pub(super) fn records(&self, scene: &RenderScene) -> Vec<LeafMotion> {
        let record = |(index, leaf): (usize, &Leaf)| {
            let moved = self.leaves.get(index).copied().flatten();
            let Displacement { rotation, scale, offset } = moved.map_or(Displacement::NONE, |moved| moved.displacement);
            let row = |k: usize| rotation.row(k).into();
            let (moves, object) = (u32::from(moved.is_some()), leaf.object);
            let deforms = u32::from(moved.is_some_and(|moved| moved.deforms));
            let [x, y, z] = [row(0), row(1), row(2)];
            let Vec3 { x: offset_x, y: offset_y, z: offset_z } = offset;
            LeafMotion { x, offset_x, y, offset_y, z, offset_z, scale, moves, object, deforms }
        };
        scene.field.leaves().iter().enumerate().map(record).collect()
    }

    /// Motion of the leaf of a guide.
    #[inline]
    fn of(&self, guide: &Guide) -> Option<Moved> {
        self.leaves.get(guide.leaf as usize).copied().flatten().filter(|_| guide.leaf != NO_LEAF)
    }

    /// Points of all guides in the earlier scene. `pixel` is the side of a pixel at distance one.
    pub(crate) fn earlier_points(&self, guides: &[Guide], pixel: f32) -> EarlierPoints {
        if self.leaves.iter().all(Option::is_none) {
            return EarlierPoints::default();
        }
        let moved = |guide: &Guide| {
            let &Guide { position, normal, .. } = guide;
            self.of(guide).map_or(EarlierPoint { position, normal }, |Moved { displacement, .. }| EarlierPoint {
                position: displacement.earlier(position),
                normal: displacement.rotation * normal,
            })
        };
        let mut points: Vec<EarlierPoint> = guides.par_iter().with_min_len(4096).map(moved).collect();
        if let Some(field) = &self.earlier_field {
            let deforms = |guide: &Guide| self.of(guide).is_some_and(|moved| moved.deforms);
            points.par_chunks_mut(8).zip(guides.par_chunks(8)).with_min_len(64).for_each(|(points, guides)| {
                if guides.iter().any(deforms) {
                    let on_surface = on_surface(field, points, guides, pixel);
                    for ((point, guide), surface) in points.iter_mut().zip(guides).zip(on_surface) {
                        *point = if deforms(guide) { surface } else { *point };
                    }
                }
            });
        }
        EarlierPoints(points)
    }
}

/// Points of the surface of a field near up to eight points, which have these guides; far from everything where there are
/// none.
fn on_surface(field: &Field, points: &[EarlierPoint], guides: &[Guide], pixel: f32) -> [EarlierPoint; 8] {
    let last = points.len() - 1;
    let vector = |of: &dyn Fn(usize) -> Vec3| {
        let axis = |k: usize| lanes(|lane| of(lane.min(last))[k]);
        FieldVec3::new(axis(0), axis(1), axis(2))
    };
    let mut p = vector(&|lane| points[lane].position);
    let tolerance = lanes(|lane| SURFACE_TOLERANCE * pixel * guides[lane.min(last)].length);
    let surface = |p| field.surface_at_hit(p, f32x8::splat(SPHERE_TRACED), &|_| f32x8::splat(0.5));
    let mut found: Surface<f32x8> = surface(p);
    for _ in 0..EARLIER_STEPS {
        if !found.field.value.abs().simd_gt(tolerance * 0.1).any() {
            break;
        }
        let square = found.field.gradient.dot(found.field.gradient);
        p = p - found.field.gradient * (found.field.value / square.max(f32x8::splat(MIN_SQUARED_GRADIENT)));
        found = surface(p);
    }
    let normals = vector(&|lane| points[lane].normal);
    let length = found.field.gradient.length().max(f32x8::splat(1e-6));
    // On the side of the camera, as the normal of the guide.
    let side = found.field.gradient.dot(normals).simd_lt(f32x8::ZERO);
    let normal = found.field.gradient * (side.select(f32x8::splat(-1.0), f32x8::ONE) / length);
    let is_near = found.field.value.abs().simd_le(tolerance);
    let columns = |v: FieldVec3<f32x8>| [v.x, v.y, v.z].map(f32x8::to_array);
    let (p, normal, is_near) = (columns(p), columns(normal), is_near.to_bitmask());
    std::array::from_fn(|lane| {
        let of = |v: &[[f32; 8]; 3]| Vec3::from_array([v[0][lane], v[1][lane], v[2][lane]]);
        let position = if is_near >> lane & 1 == 1 { of(&p) } else { Vec3::splat(NOWHERE) };
        EarlierPoint { position, normal: of(&normal) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_scene::Scene;

    fn scene(objects: &str) -> RenderScene {
        let text = format!(
            "pathmarch 1\ncamera {{ position 0 1 5; target 0 0 0 }}\nsky 1\nobject \"floor\" {{ plane }}\n{objects}"
        );
        let scene = Scene::parse("test.kdl", &text).expect("a scene");
        RenderScene::new(&scene, &scene.cameras[0])
    }

    fn with_box(placement: &str) -> RenderScene {
        scene(&format!("object \"box\" {{ box 1 2 3 {{ {placement} }} }}"))
    }

    /// Earlier point of a guide whose pixel has a side of a millimetre.
    fn earlier(motion: &Motion, guide: &Guide) -> EarlierPoint {
        motion.earlier_points(&[Guide { length: 1.0, ..*guide }], 1e-3).at(0, guide)
    }

    #[test]
    fn points_of_a_moved_object_are_found_where_they_were() {
        let motion = Motion::new(&with_box("at 1 2 3; scale 2"), &with_box("at -1 0 4; rotate 0 90 0"));
        // A corner of the box: (0.5, 1, 1.5) in its own coordinates.
        let present = Vec3::new(-1.0 + 1.5, 1.0, 4.0 - 0.5);
        let guide = Guide { position: present, normal: Vec3::X, leaf: 1, ..Guide::NONE };
        let EarlierPoint { position, normal } = earlier(&motion, &guide);
        assert!((position - Vec3::new(2.0, 4.0, 6.0)).length() < 1e-5, "{position}");
        assert!((normal - Vec3::Z).length() < 1e-6, "{normal}");
        // The floor stands still, and so does what mirrors show.
        for leaf in [0, NO_LEAF] {
            let guide = Guide { leaf, ..guide };
            let still = EarlierPoint { position: guide.position, normal: guide.normal };
            assert_eq!(earlier(&motion, &guide), still);
        }
    }

    #[test]
    fn objects_below_modifiers_move_as_a_whole() {
        let at = |x: f32| scene(&format!("object \"twisted\" {{ twist 0.25 {{ box 0.4 1 0.4; at {x} 1 0 }} }}"));
        let motion = Motion::new(&at(0.0), &at(0.3));
        assert!(motion.earlier_field.is_none());
        let guide = Guide { position: Vec3::new(0.5, 1.0, 0.0), normal: Vec3::X, leaf: 1, ..Guide::NONE };
        assert!((earlier(&motion, &guide).position - Vec3::new(0.2, 1.0, 0.0)).length() < 1e-6);
    }

    #[test]
    fn points_of_a_growing_sphere_move_along_its_radius() {
        let of_radius = |radius: f32| scene(&format!("object \"ball\" {{ sphere {radius} {{ at 0 2 0 }} }}"));
        let motion = Motion::new(&of_radius(0.8), &of_radius(1.0));
        let centre = Vec3::new(0.0, 2.0, 0.0);
        for direction in [Vec3::X, Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.36, 0.48, 0.8)] {
            let guide = Guide { position: centre + direction, normal: direction, leaf: 1, ..Guide::NONE };
            let EarlierPoint { position, normal } = earlier(&motion, &guide);
            assert!((position - centre - direction * 0.8).length() < 1e-5, "{position}");
            assert!((normal - direction).length() < 1e-5, "{normal}");
        }
    }

    #[test]
    fn points_of_a_blend_are_on_its_earlier_surface() {
        let apart = |x: f32| {
            scene(&format!(
                "object \"drops\" {{ union smooth=0.3 {{ sphere 0.5 {{ at {x} 1 0 }}; sphere 0.5 {{ at -0.4 1 0 }} }} }}"
            ))
        };
        let [before, after] = [apart(0.5), apart(0.4)];
        let motion = Motion::new(&before, &after);
        let mut point = Vec3::new(0.05, 1.5, 0.1);
        let distance = |scene: &RenderScene, p: Vec3| {
            let p = FieldVec3::constant(p.to_array());
            scene.field.object_distances::<f32>(p).nth(1).expect("two objects")
        };
        for _ in 0..40 {
            point.y -= 0.5 * distance(&after, point);
        }
        let guide = Guide { position: point, normal: Vec3::Y, leaf: 1, ..Guide::NONE };
        let earlier = earlier(&motion, &guide).position;
        assert!(distance(&before, point).abs() > 0.01, "the surface has moved");
        assert!(distance(&before, earlier).abs() < 5e-4, "{earlier}");
    }

    #[test]
    fn a_point_without_an_earlier_surface_has_no_past() {
        // Two balls had no common points, and then a lens of them.
        let lens = |x: f32| {
            let balls = [x, -x].map(|x| format!("sphere 0.5 {{ at {x} 2 0 }}")).join("; ");
            scene(&format!("object \"lens\" {{ intersect {{ {balls} }} }}"))
        };
        let guide = Guide { position: Vec3::new(0.2, 2.0, 0.0), normal: Vec3::X, leaf: 2, ..Guide::NONE };
        let far = earlier(&Motion::new(&lens(0.8), &lens(0.3)), &guide);
        assert_eq!(far.position, Vec3::splat(NOWHERE));
        let near = earlier(&Motion::new(&lens(0.32), &lens(0.3)), &guide);
        assert!((near.position - Vec3::new(0.18, 2.0, 0.0)).length() < 1e-4, "{near:?}");
    }

    #[test]
    fn nothing_moves_between_different_structures() {
        let motion = Motion::new(&scene(""), &with_box("at 1 2 3"));
        let guide = Guide { position: Vec3::ONE, leaf: 1, ..Guide::NONE };
        assert_eq!(earlier(&motion, &guide), EarlierPoint { position: guide.position, normal: guide.normal });
    }
}
