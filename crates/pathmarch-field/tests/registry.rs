//! Every registered shape and operator, tested over the registry.

use naga::valid::{Capabilities, ValidationFlags, Validator};
use pathmarch_field::registry::{operators, shapes};

fn validate(source: &str) {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}\n{source}", e.emit_to_string(source)));
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}\n{source}", e.emit_to_string(source)));
}

#[test]
fn every_shape_prints_valid_wgsl() {
    for shape in shapes() {
        println!("{}{}", shape.wgsl_distance(), shape.wgsl_gradient());
        validate(&(shape.wgsl_distance() + &shape.wgsl_gradient()));
    }
}

#[test]
fn every_operator_prints_valid_wgsl() {
    for operator in operators() {
        for smooth in [false, true] {
            let source =
                operator.wgsl_distance(smooth) + &operator.wgsl_gradient(smooth) + &operator.wgsl_weight(smooth);
            println!("{source}");
            validate(&source);
        }
    }
}
