//! Scene of the measurement: a bumpy torus of as many triangles as wanted, before a sky.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};
use pathmarch_cli::Failure;
use pathmarch_mesh::TriangleMesh;
use pathmarch_render::pathmarch_field::graph::Kind;
use pathmarch_render::pathmarch_field::wgsl::{Program, ProgramOptions};
use pathmarch_render::pathmarch_field::{MeshShape, MeshSurface, Node, Placement, ShapeRef};
use pathmarch_render::pathmarch_scene::parts::{SceneParts, camera, material};
use pathmarch_render::pathmarch_scene::{Camera, Light, Object, Scene, Sky};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Distance of the near plane, metres.
const NEAR: f32 = 0.05;
/// Torus of unit radius with a bumpy tube, and about this many triangles.
fn bumpy_torus(triangles: u32) -> TriangleMesh {
    let side = (f64::from(triangles) / 2.0).sqrt().round().max(3.0) as u32;
    let point = |i: u32, k: u32| {
        let (u, v) = (TAU * i as f32 / side as f32, TAU * k as f32 / side as f32);
        let tube = 0.4 + 0.06 * (7.0 * u).sin() * (9.0 * v).sin() + 0.018 * (41.0 * u + 23.0 * v).sin();
        let ring = 1.0 + tube * v.cos();
        Vec3::new(ring * u.cos(), tube * v.sin(), ring * u.sin())
    };
    let vertex = |i: u32, k: u32| i % side * side + k % side;
    let halves = |(i, k): (u32, u32)| {
        let [a, b, c, d] = [vertex(i, k), vertex(i, k + 1), vertex(i + 1, k + 1), vertex(i + 1, k)];
        [[a, b, c], [a, c, d]]
    };
    let grid = || (0..side).flat_map(|i| (0..side).map(move |k| (i, k)));
    TriangleMesh {
        positions: grid().map(|(i, k)| point(i, k)).collect(),
        triangles: grid().flat_map(halves).collect(),
        ..TriangleMesh::default()
    }
}

/// Scene with one mesh.
pub struct MeshScene {
    pub scene: Scene,
    surface: Arc<MeshSurface>,
}

impl MeshScene {
    /// Makes a torus of about this many triangles.
    pub fn torus(triangles: u32) -> Result<Self, Failure> {
        let surface = Arc::new(MeshSurface::new(bumpy_torus(triangles)).map_err(Failure::other)?);
        let shape = ShapeRef::Custom(Arc::new(MeshShape::triangles(Arc::clone(&surface), vec![0])));
        let root = Node { kind: Kind::Shape { shape, params: vec![], tag: 0 }, placement: Placement::default() };
        let scene = Scene::from_parts(SceneParts {
            cameras: vec![camera([0.0, 2.0, 3.0], [0.0; 3])],
            sky: Sky::Constant([0.5; 3]),
            lights: vec![Light::Sun { direction: [1.0, 2.0, 1.0], irradiance: [2.0; 3], angle: 0.5, penumbra: None }],
            materials: vec![material("clay", "diffuse", &[]).map_err(Failure::other)?],
            objects: vec![Object { name: "torus".to_owned(), material: 0, root }],
            ..SceneParts::default()
        });
        Ok(Self { scene: scene.map_err(Failure::other)?, surface })
    }

    /// Triangles and vertices.
    pub fn mesh(&self) -> &TriangleMesh {
        self.surface.mesh()
    }

    /// Code of the field, with the words of the hierarchy and its triangles.
    pub fn program(&self) -> Program {
        let options = ProgramOptions { has_triangle_distances: false, ..ProgramOptions::default() };
        Program::with_options(&self.scene.field, options)
    }

    /// Bytes of the hierarchy with its triangles.
    pub fn bvh_bytes(&self) -> u64 {
        size_of_val(self.program().mesh_words()) as u64
    }

    /// Triangles of the mesh in the order of kernels.
    pub fn triangles_in_kernel_order(&self) -> Vec<[u32; 3]> {
        let mut triangles = vec![[0; 3]; self.mesh().triangles.len()];
        for (number, corners) in self.surface.kernel_triangles().into_iter().zip(&self.mesh().triangles) {
            triangles[number as usize] = *corners;
        }
        triangles
    }
}

/// Positions of camera rays in their pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Offsets {
    /// Each pixel has an offset of its own, as in the renderer; the raster samples the middle of pixels.
    Own,
    /// All pixels have one offset, which is that of the raster.
    Common,
}

impl Offsets {
    pub const ALL: [Self; 2] = [Self::Own, Self::Common];

    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "own",
            Self::Common => "common",
        }
    }

    /// Position of the raster's samples in their pixels.
    fn of_raster(self) -> [f32; 2] {
        match self {
            Self::Own => [0.5; 2],
            Self::Common => [0.3, 0.8],
        }
    }

    /// Largest second difference of depths over three pixels without an edge, in widths of a pixel. With these the relMSE of
    /// 100 thousand and a million triangles is below 1e-6; with 1 for own and 32 for common offsets it was not. Rays that pass
    /// the samples of the raster need less care.
    fn max_bend(self) -> f32 {
        match self {
            Self::Own => 0.5,
            Self::Common => 4.0,
        }
    }
}

/// Camera of a picture. Twin of `View` in `view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct ViewUniform {
    clip_from_world: [[f32; 4]; 4],
    position: [f32; 3],
    width: u32,
    right: [f32; 3],
    height: u32,
    up: [f32; 3],
    max_bend: f32,
    forward: [f32; 3],
    has_own_offsets: u32,
    raster_offset: [f32; 2],
    padding: [f32; 2],
}

impl ViewUniform {
    pub fn new(camera: &Camera, [width, height]: [u32; 2], offsets: Offsets) -> Self {
        let (position, up) = (Vec3::from(camera.position), Vec3::from(camera.up));
        let forward = (Vec3::from(camera.target) - position).normalize();
        let right = forward.cross(up).normalize();
        let half_height = (0.5 * camera.fov.to_radians()).tan();
        let aspect = width as f32 / height as f32;
        let raster_offset = offsets.of_raster();
        let [x, y] = raster_offset.map(|offset| 1.0 - 2.0 * offset);
        let shift = Mat4::from_translation(Vec3::new(x / width as f32, -y / height as f32, 0.0));
        let fov = camera.fov.to_radians();
        let projection = glam::camera::rh::proj::directx::perspective_infinite_reverse(fov, aspect, NEAR);
        let view = glam::camera::rh::view::look_at_mat4(position, camera.target.into(), up);
        Self {
            clip_from_world: (shift * projection * view).to_cols_array_2d(),
            position: camera.position,
            width,
            right: (right * half_height * aspect).into(),
            height,
            up: (right.cross(forward) * half_height).into(),
            max_bend: offsets.max_bend() * 2.0 * half_height / height as f32,
            forward: forward.into(),
            has_own_offsets: u32::from(offsets == Offsets::Own),
            raster_offset,
            padding: [0.0; 2],
        }
    }
}
