//! Meshes: closed, manifold, of the right volume and area, sharp where the solid is.

use crate::sampling::Random;
use pathmarch_field::graph::Kind;
use pathmarch_field::mesh::{DistanceGrid, Fineness, Mesh, MeshError};
use pathmarch_field::number::Vec3;
use pathmarch_field::registry::{modifiers, operator, shape, shapes, solid};
use pathmarch_field::{Aabb, Field, Node, Param, Placement, Solid, Unit};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Mutex;

fn leaf(name: &str, params: &[f32], placement: Placement) -> Node {
    tagged(name, params, placement, 0)
}

fn tagged(name: &str, params: &[f32], placement: Placement, tag: u32) -> Node {
    let shape = shape(name).expect("registered");
    let given = |(k, param): (usize, &Param)| params.get(k).copied().unwrap_or(param.default);
    let params = shape.params().iter().enumerate().map(given).collect();
    Node { kind: Kind::Shape { shape: shape.into(), params, tag }, placement }
}

fn combined(name: &str, smooth: Option<f32>, children: Vec<Node>) -> Node {
    let operator = operator(name).expect("registered");
    Node {
        kind: Kind::Operator { operator, smooth: smooth.map(Into::into), children },
        placement: Placement::default(),
    }
}

fn modified(name: &str, params: &[f32], children: Vec<Node>) -> Node {
    let Some(Solid::Modifier(modifier)) = solid(name) else { panic!("no modifier {name}") };
    Node { kind: Kind::Modifier { modifier, params: params.to_vec(), children }, placement: Placement::default() }
}

fn at(x: f32, y: f32, z: f32) -> Placement {
    Placement { at: Some([x, y, z]), ..Placement::default() }
}

fn meshed_within(field: &Field, fineness: Fineness, cut: Option<Aabb>) -> Result<Mesh, MeshError> {
    Mesh::new(field, fineness, cut, &|leaf, _, _| [field.leaves()[leaf].tag as f32; 3], &|_| ControlFlow::Continue(()))
}

fn meshed(node: Node, resolution: u32) -> Mesh {
    meshed_within(&Field::new(&[node]), Fineness::Resolution(resolution), None).expect("a mesh")
}

/// Checks that every edge is in two triangles that run along it in opposite directions, that every vertex has one fan, and
/// that all numbers are finite; gives the Euler characteristic.
fn euler_of_closed(mesh: &Mesh, name: &str) -> i64 {
    assert_eq!(mesh.positions.len(), mesh.normals.len());
    assert_eq!(mesh.positions.len(), mesh.colours.len());
    assert!(mesh.positions.iter().chain(&mesh.normals).chain(&mesh.colours).flatten().all(|v| v.is_finite()), "{name}");
    let mut edges = HashMap::new();
    let mut fans = vec![HashMap::new(); mesh.positions.len()];
    for triangle in &mesh.triangles {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|j| triangle[(k + j) % 3]);
            assert_ne!(a, b, "{name}: a triangle with a vertex twice");
            assert_eq!(edges.insert((a, b), ()), None, "{name}: two triangles run along an edge in one direction");
            fans[a as usize].insert(b, c);
        }
    }
    assert!(edges.keys().all(|&(a, b)| edges.contains_key(&(b, a))), "{name}: an edge of one triangle");
    for (vertex, fan) in fans.iter().enumerate() {
        let start = *fan.keys().next().unwrap_or_else(|| panic!("{name}: vertex {vertex} is in no triangle"));
        let (mut next, mut steps) = (fan[&start], 1);
        while next != start {
            (next, steps) = (fan[&next], steps + 1);
        }
        assert_eq!(steps, fan.len(), "{name}: vertex {vertex} has two fans");
    }
    mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64
}

/// Distance from a point to the nearest vertex.
fn to_nearest(mesh: &Mesh, point: [f32; 3]) -> f32 {
    let squared = |p: &[f32; 3]| (0..3).map(|k| (p[k] - point[k]).powi(2)).sum::<f32>();
    mesh.positions.iter().map(squared).fold(f32::INFINITY, f32::min).sqrt()
}

#[test]
fn volume_and_area_are_those_of_the_formula() {
    let turned = Placement {
        rotate: Some([20.0, 35.0, 50.0]),
        scale: Some(1.5),
        at: Some([3.0, -1.0, 2.0]),
        ..at(0.0, 0.0, 0.0)
    };
    let slant = (0.75_f64 * 0.75 + 1.5 * 1.5).sqrt();
    let plain = Placement::default;
    let star = 5.0 * 0.7 * (PI / 5.0).sin();
    let cases = [
        ("sphere", leaf("sphere", &[1.0], plain()), 4.0 / 3.0 * PI, 4.0 * PI, 2),
        ("box", leaf("box", &[2.0, 1.0, 0.5], plain()), 1.0, 7.0, 2),
        ("turned box", leaf("box", &[2.0, 1.0, 0.5], turned), 3.375, 15.75, 2),
        ("torus", leaf("torus", &[1.0, 0.3], plain()), 2.0 * PI * PI * 0.09, 4.0 * PI * PI * 0.3, 0),
        ("cylinder", leaf("cylinder", &[0.5, 2.0], plain()), 0.5 * PI, 2.5 * PI, 2),
        ("cone", leaf("cone", &[0.75, 1.5], plain()), PI * 0.5625 * 0.5, PI * 0.75 * (0.75 + slant), 2),
        ("capsule", leaf("capsule", &[0.4, 1.0], plain()), PI * 0.16 * (1.0 + 1.6 / 3.0), PI * 0.8 * 1.8, 2),
        (
            "box without a ball",
            combined(
                "subtract",
                None,
                vec![leaf("box", &[2.0, 2.0, 2.0], plain()), leaf("sphere", &[0.8], at(1.0, 1.0, 1.0))],
            ),
            8.0 - PI / 6.0 * 0.512,
            24.0 - 3.0 * PI / 4.0 * 0.64 + 0.5 * PI * 0.64,
            2,
        ),
        (
            "box with a tunnel",
            combined(
                "subtract",
                None,
                vec![leaf("box", &[2.0, 1.0, 2.0], plain()), leaf("cylinder", &[0.5, 3.0], plain())],
            ),
            4.0 - 0.25 * PI,
            16.0 - 0.5 * PI + PI,
            0,
        ),
        (
            "extruded star",
            modified("extrude", &[0.5], vec![leaf("star", &[5.0, 1.0, 0.7], plain())]),
            0.5 * star,
            2.0 * star + 0.5 * 10.0 * (1.49 - 1.4 * (PI / 5.0).cos()).sqrt(),
            2,
        ),
        (
            "extruded ring",
            modified("extrude", &[0.4], vec![modified("shell", &[0.2], vec![leaf("circle", &[0.5], plain())])]),
            0.4 * PI * (0.36 - 0.16),
            2.0 * PI * (0.36 - 0.16) + 0.4 * 2.0 * PI,
            0,
        ),
        (
            // Guldin: area times the way of its centre.
            "turned rectangle",
            modified("revolve", &[0.8], vec![leaf("rectangle", &[0.4, 0.6, 0.0], at(0.1, 0.3, 0.0))]),
            2.0 * PI * 0.9 * 0.24,
            2.0 * PI * 0.9 * 2.0,
            0,
        ),
        (
            "cup",
            modified(
                "revolve",
                &[0.0],
                vec![combined(
                    "subtract",
                    None,
                    vec![
                        leaf("rectangle", &[1.2, 1.0, 0.0], plain()),
                        leaf("rectangle", &[1.0, 1.0, 0.0], at(0.0, 0.2, 0.0)),
                    ],
                )],
            ),
            PI * (0.36 - 0.25 * 0.8),
            PI * (0.36 + 0.25 + 0.11 + 1.2 + 0.8),
            2,
        ),
    ];
    for (name, node, volume, area, euler) in cases {
        let mesh = meshed(node.clone(), 64);
        println!(
            "{name}: volume {:.5} of {volume:.5}, area {:.5} of {area:.5}, {} triangles",
            mesh.volume(),
            mesh.area(),
            mesh.triangles.len()
        );
        assert_eq!(euler_of_closed(&mesh, name), euler, "{name}: Euler characteristic");
        assert!((mesh.volume() / volume - 1.0).abs() < 0.01, "{name}");
        assert!((mesh.area() / area - 1.0).abs() < 0.01, "{name}");
        let again = meshed(node, 64);
        assert_eq!((mesh.positions, mesh.triangles), (again.positions, again.triangles), "{name}: the same twice");
    }
}

#[test]
fn a_blend_has_the_volume_of_its_field() {
    let node = combined(
        "union",
        Some(0.4),
        vec![leaf("sphere", &[0.7], at(-0.5, 0.0, 0.0)), leaf("box", &[1.0], at(0.5, 0.1, 0.0))],
    );
    let field = Field::new(&[node]);
    let mesh = meshed_within(&field, Fineness::Resolution(64), None).expect("a mesh");
    assert_eq!(euler_of_closed(&mesh, "blend"), 2);
    let (bounds, mut random) = (field.bounds(), Random::new(3));
    let whole: f64 = (0..3).map(|k| f64::from(bounds.max[k] - bounds.min[k])).product();
    let count = 400_000;
    let inside = (0..count).filter(|_| field.distance(random.point(bounds)) < 0.0).count();
    let volume = whole * inside as f64 / f64::from(count);
    println!("blend: volume {:.4} of {volume:.4}", mesh.volume());
    assert!((mesh.volume() / volume - 1.0).abs() < 0.01);
}

#[test]
fn corners_and_edges_are_sharp() {
    let turn = Placement { rotate: Some([20.0, 35.0, 50.0]), at: Some([0.3, 0.2, -0.4]), ..Placement::default() };
    for (name, placement) in [("level", Placement::default()), ("turned", turn)] {
        let node = leaf("box", &[2.0, 1.0, 0.5], placement);
        let field = Field::new(std::slice::from_ref(&node));
        let leaf = &field.leaves()[0];
        let mesh = meshed(node, 64);
        for corner in Aabb::centred(1.0, 0.5, 0.25).corners() {
            let there = std::array::from_fn(|k| {
                leaf.pose.at[k] + (0..3).map(|axis| leaf.pose.axes[axis][k] * corner[axis]).sum::<f32>()
            });
            let apart = to_nearest(&mesh, there);
            assert!(apart < 1e-3, "{name}: the nearest vertex is {apart} m from the corner {there:?}");
        }
        // Where edges are cut off or left ragged, middles of triangles lie off the surface.
        let off = |triangle: &[u32; 3]| {
            let [a, b, c] = mesh.corners(*triangle);
            let [x, y, z] = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
            field.distance(Vec3::new(x, y, z)).abs()
        };
        let ragged = mesh.triangles.iter().filter(|triangle| off(triangle) > 1e-3).count();
        println!("{name}: {ragged} of {} triangles are off the surface", mesh.triangles.len());
        assert!(ragged * 200 < mesh.triangles.len(), "{name}");
    }
}

#[test]
fn every_bounded_shape_has_a_closed_mesh_on_its_surface() {
    for shape in shapes() {
        let name = &*shape.info().name;
        if shape.info().profile {
            continue;
        }
        // What a fractal has after more than three iterations is smaller than the cells.
        let value = |param: &Param| if param.unit == Unit::Count { param.default.min(3.0) } else { param.default };
        let params: Vec<_> = shape.params().iter().map(value).collect();
        let field = Field::new(&[leaf(name, &params, at(0.1, 0.2, 0.3))]);
        let mesh = meshed_within(&field, Fineness::Resolution(48), None);
        if shape.info().sheet {
            assert_eq!(mesh.err(), Some(MeshError::Empty), "{name}");
        } else if !field.bounds().is_finite() {
            assert_eq!(mesh.err(), Some(MeshError::Endless), "{name}");
        } else {
            let mesh = mesh.unwrap_or_else(|error| panic!("{name}: {error}"));
            euler_of_closed(&mesh, name);
            let bounds = field.bounds();
            let cell = (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f32::max) / 48.0;
            let off = |[x, y, z]: &[f32; 3]| field.distance(Vec3::new(*x, *y, *z)).abs();
            let farthest = mesh.positions.iter().map(off).fold(0.0, f32::max) / cell;
            let mean = mesh.positions.iter().map(off).sum::<f32>() / mesh.positions.len() as f32 / cell;
            println!("{name}: vertices {mean:.4} cells off the surface, at most {farthest:.4}");
            // A fractal has more in a cell than one vertex can show, but a cell with a vertex has surface on its edges.
            assert!(
                mean < 0.25 && farthest < 1.74,
                "{name}: a vertex is {farthest} cells off the surface, the mean {mean}"
            );
            assert!(mesh.volume() > 0.0, "{name}: inside out");
        }
    }
}

#[test]
fn every_modifier_leaves_a_closed_mesh() {
    for modifier in modifiers() {
        let name = &*modifier.info().name;
        let children =
            vec![leaf("box", &[0.6, 0.3, 0.2], at(0.5, 0.1, 0.0)), leaf("torus", &[0.4, 0.1], at(0.2, 0.2, 0.3))];
        let params = modifier.params().iter().map(|param| param.default).collect();
        let node =
            Node { kind: Kind::Modifier { modifier: *modifier, params, children }, placement: at(0.1, 0.2, 0.3) };
        let field = Field::new(&[node]);
        let cut = (!field.bounds().is_finite()).then_some(Aabb::centred(3.0, 3.0, 3.0));
        let mesh =
            meshed_within(&field, Fineness::Resolution(60), cut).unwrap_or_else(|error| panic!("{name}: {error}"));
        let euler = euler_of_closed(&mesh, name);
        println!("{name}: {} triangles, Euler characteristic {euler}", mesh.triangles.len());
        assert!(mesh.volume() > 0.0, "{name}: inside out");
    }
}

/// Balls about the size of a cell: every way in which a surface passes through a cell, and most in which it does through two.
#[test]
fn what_is_finer_than_the_cells_is_still_closed() {
    for seed in 0..20 {
        let mut random = Random::new(seed);
        let mut ball = |_| {
            let p = random.point(Aabb::centred(1.0, 1.0, 1.0));
            leaf("sphere", &[random.within(0.03, 0.12)], at(p.x, p.y, p.z))
        };
        let (balls, holes): (Vec<_>, Vec<_>) = ((0..250).map(&mut ball).collect(), (0..250).map(&mut ball).collect());
        let node = combined("subtract", None, [vec![combined("union", None, balls)], holes].concat());
        let mesh = meshed(node, 20);
        euler_of_closed(&mesh, &format!("seed {seed}"));
    }
}

#[test]
fn endless_solids_are_cut() {
    let field = Field::new(&[leaf("plane", &[], Placement::default()), leaf("sphere", &[0.5], at(0.0, 0.3, 0.0))]);
    let cut = Aabb { min: [-1.0, -0.5, -1.0], max: [1.0, 2.0, 1.0] };
    let mesh = meshed_within(&field, Fineness::Cell(0.04), Some(cut)).expect("a mesh");
    assert_eq!(euler_of_closed(&mesh, "cut"), 2);
    // The slab, and of the ball what is above it.
    let cap = PI * 0.04 * (1.5 - 0.2) / 3.0;
    assert!((mesh.volume() / (2.0 + 4.0 / 3.0 * PI * 0.125 - cap) - 1.0).abs() < 0.01, "{}", mesh.volume());
    for corner in (Aabb { max: [1.0, 0.0, 1.0], ..cut }).corners() {
        assert!(to_nearest(&mesh, corner) < 1e-3, "{corner:?}");
    }
}

#[test]
fn paints_are_those_of_the_leaves() {
    let node = combined(
        "union",
        Some(0.5),
        vec![tagged("sphere", &[0.6], at(-0.5, 0.0, 0.0), 0), tagged("sphere", &[0.6], at(0.5, 0.0, 0.0), 1)],
    );
    let mesh = meshed(node, 40);
    for ([x, ..], [tag, ..]) in mesh.positions.iter().zip(&mesh.colours) {
        if x.abs() < 0.02 {
            assert!((tag - 0.5).abs() < 0.1, "mixed in the middle, {tag}");
        } else if x.abs() > 0.4 {
            assert_eq!(*tag, if *x < 0.0 { 0.0 } else { 1.0 });
        }
    }
}

#[test]
fn what_cannot_be_meshed_is_refused() {
    let ball = Field::new(&[leaf("sphere", &[1.0], Placement::default())]);
    let of = |fineness| meshed_within(&ball, fineness, None).err();
    assert_eq!(of(Fineness::Resolution(20_000)), Some(MeshError::TooManyCells));
    assert_eq!(of(Fineness::Cell(1e-9)), Some(MeshError::CellSize(1e-9)));
    for cell in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert!(matches!(of(Fineness::Cell(cell)), Some(MeshError::CellSize(_))), "{cell}");
    }
    assert!(matches!(of(Fineness::Resolution(0)), Some(MeshError::CellSize(_))));
    assert_eq!(of(Fineness::Resolution(1)), None, "coarse, but there");
    let beside = Aabb { min: [5.0; 3], max: [6.0; 3] };
    assert_eq!(meshed_within(&ball, Fineness::Resolution(9), Some(beside)).err(), Some(MeshError::Empty));
    assert_eq!(meshed_within(&Field::new(&[]), Fineness::Resolution(9), None).err(), Some(MeshError::Empty));
}

#[test]
fn grids_have_the_distances_of_their_points() {
    let field = Field::new(&[leaf("sphere", &[1.0], at(0.3, -0.2, 5.0))]);
    let cut = Aabb { min: [-9.0, -9.0, 5.0], max: [9.0; 3] };
    for cut in [None, Some(cut)] {
        let grid = DistanceGrid::new(&field, Fineness::Resolution(20), cut).expect("a grid");
        let ([width, height, depth], origin) = (grid.size(), grid.origin());
        assert!(
            (grid.cell() - 0.1).abs() < 1e-6
                && width > 21
                && height > 21
                && depth > if cut.is_some() { 11 } else { 21 }
        );
        for x in 0..width {
            for (index, distance) in grid.plane(x).into_iter().enumerate() {
                let [px, py, pz] = [x, index / depth, index % depth].map(|v| v as f64 * grid.cell());
                let p = [px + origin[0], py + origin[1], pz + origin[2]];
                let ball = ((p[0] - 0.3).powi(2) + (p[1] + 0.2).powi(2) + (p[2] - 5.0).powi(2)).sqrt() - 1.0;
                let expected = if cut.is_some() { ball.max(5.0 - p[2]) } else { ball };
                assert!((f64::from(distance) - expected).abs() < 1e-5, "{p:?}: {distance} instead of {expected}");
            }
        }
    }
    let too_many = DistanceGrid::new(&field, Fineness::Resolution(5000), None).err();
    assert_eq!(too_many, Some(MeshError::TooManyPoints));
}

#[test]
fn progress_rises_and_stops() {
    let field = Field::new(&[leaf("torus", &[], Placement::default())]);
    let heard = Mutex::new(Vec::new());
    let hear = |share: f32| {
        heard.lock().expect("unpoisoned").push(share);
        ControlFlow::Continue(())
    };
    Mesh::new(&field, Fineness::Resolution(100), None, &|_, _, _| [1.0; 3], &hear).expect("a mesh");
    let heard = heard.into_inner().expect("unpoisoned");
    assert!(heard.len() > 10 && heard.iter().all(|share| (0.0..=1.0).contains(share)) && heard.last() == Some(&1.0));
    let stopped = Mesh::new(&field, Fineness::Resolution(100), None, &|_, _, _| [1.0; 3], &|_| ControlFlow::Break(()));
    assert_eq!(stopped.err(), Some(MeshError::Stopped));
}
