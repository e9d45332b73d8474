//! Fields that lie are caught, and those that do not are left in peace.

use pathmarch_field::graph::Kind;
use pathmarch_field::lipschitz_check::check_lipschitz;
use pathmarch_field::registry::{modifiers, shape, shapes};
use pathmarch_field::{Field, Node, Placement, Shape};

fn node(shape: &'static dyn Shape, params: Vec<f32>) -> Node {
    Node { kind: Kind::Shape { shape: shape.into(), params, tag: 0 }, placement: Placement::default() }
}

#[test]
fn what_is_registered_is_safe() {
    for shape in shapes() {
        let params: Vec<f32> = shape.params().iter().map(|param| param.default).collect();
        let finding = check_lipschitz(&Field::new(&[node(*shape, params)]), 2000);
        assert!(finding.safe_factor > 0.995, "{shape:?}: {finding:?}");
    }
    let block = shape("box").expect("registered");
    for modifier in modifiers() {
        let params = modifier.params().iter().map(|param| param.default).collect();
        let children = vec![node(block, vec![1.0, 0.6, 0.4])];
        let kind = Kind::Modifier { modifier: *modifier, params, children };
        let finding = check_lipschitz(&Field::new(&[Node { kind, placement: Placement::default() }]), 2000);
        assert!(finding.safe_factor > 0.995, "{modifier:?}: {finding:?}");
        assert!(finding.slope < 1.6, "{modifier:?}: {finding:?}");
    }
}

/// A shape that claims more than it keeps: an ellipsoid by the length of its stretched point, whose slope is that of its
/// smallest radius.
#[derive(Debug)]
struct Liar;

mod liar {
    use super::Liar;
    use pathmarch_field::number::{Differentiable, Dual, Real, Vec3};
    use pathmarch_field::{Aabb, EvalShape, Info, Param, Shape};

    static INFO: Info = Info::new("liar", "Claims to be a distance.", "nobody");

    fn stretched<N: Real>(p: Vec3<N>) -> N {
        Vec3::new(p.x, N::constant(4.0) * p.y, p.z).length() - N::one()
    }

    impl<N: Differentiable> EvalShape<N> for Liar {
        fn distance(&self, p: Vec3<N>, _: &[f32]) -> N {
            stretched(p)
        }
        fn gradient(&self, p: Vec3<Dual<N>>, _: &[f32]) -> Dual<N> {
            stretched(p)
        }
    }

    impl Shape for Liar {
        fn info(&self) -> &'static Info {
            &INFO
        }
        fn params(&self) -> &'static [Param] {
            &[]
        }
        fn bounds(&self, _: &[f32]) -> Aabb {
            Aabb::centred(1.0, 0.25, 1.0)
        }
        fn lipschitz(&self, _: &[f32]) -> f32 {
            1.0
        }
        fn wgsl_distance(&self) -> String {
            String::new()
        }
        fn wgsl_gradient(&self) -> String {
            String::new()
        }
    }
}

#[test]
fn what_claims_too_much_is_caught() {
    let finding = check_lipschitz(&Field::new(&[node(&Liar, vec![])]), 4000);
    assert!((finding.slope - 4.0).abs() < 0.05, "{finding:?}");
    // A quarter of the steps would be safe; the worst place need not have been found.
    assert!((0.24..0.4).contains(&finding.safe_factor), "{finding:?}");
    assert!(finding.at[1].abs() < 0.26 && finding.leaf == 0);
}
