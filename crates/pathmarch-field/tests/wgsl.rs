//! The printed WGSL, word for word. `cargo insta review` shows what a change does to it.

use crate::sampling;
use pathmarch_field::graph::Kind;
use pathmarch_field::registry::{operator, shape};
use pathmarch_field::wgsl::Program;
use pathmarch_field::{Field, Node, Placement};

fn printed(name: &str) -> String {
    let shape = shape(name).expect("registered");
    let source = shape.wgsl_distance() + "\n" + &shape.wgsl_gradient();
    sampling::validate(&source);
    source
}

#[test]
fn torus() {
    insta::assert_snapshot!(printed("torus"));
}

#[test]
fn r#box() {
    insta::assert_snapshot!(printed("box"));
}

/// A shape with a loop.
#[test]
fn ellipsoid() {
    insta::assert_snapshot!(printed("ellipsoid"));
}

/// A fractal and its orbit: five numbers returned.
#[test]
fn sierpinski() {
    let shape = shape("sierpinski").expect("registered");
    let source = shape.wgsl_distance() + "\n" + &shape.wgsl_orbit();
    sampling::validate(&source);
    insta::assert_snapshot!(source);
}

#[test]
fn a_smooth_union_of_a_placed_torus_and_box() {
    let node = |name, params: &[f32], tag, placement| {
        let shape = shape(name).expect("registered");
        Node { kind: Kind::Shape { shape: shape.into(), params: params.to_vec(), tag }, placement }
    };
    let children = vec![
        node("torus", &[1.0, 0.25], 0, Placement { at: Some([0.0, 1.0, 0.0]), ..Placement::default() }),
        node("box", &[1.0, 2.0, 3.0], 1, Placement { rotate: Some([0.0, 45.0, 0.0]), ..Placement::default() }),
    ];
    let operator = operator("union").expect("registered");
    let kind = Kind::Operator { operator, smooth: Some(0.1.into()), children };
    let program = Program::new(&Field::new(&[Node { kind, placement: Placement::default() }]));
    sampling::validate(&(sampling::declared(&program) + &program.code));
    insta::assert_snapshot!(program.code);
}
