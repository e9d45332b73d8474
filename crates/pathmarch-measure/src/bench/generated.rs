//! Generated benchmark scenes: many shapes in one smooth union, and many light sources.

use std::f32::consts::PI;
use std::fmt::Write;

/// A generated scene.
pub struct Generated {
    /// Name on the command line.
    pub name: &'static str,
    text: fn() -> String,
}

impl Generated {
    /// Text of the scene.
    pub fn text(&self) -> String {
        (self.text)()
    }
}

/// All generated scenes: grids of shapes in one smooth union, at rest and in motion, and light sources over a floor with three
/// solids, also in fog.
pub static ALL: [Generated; 9] = [
    Generated { name: "union-100", text: || union(5, 5, 4) },
    Generated { name: "union-1000", text: || union(10, 10, 10) },
    Generated { name: "union-10000", text: || union(25, 20, 20) },
    Generated { name: "moving-10000", text: || moving(25, 20, 20) },
    Generated { name: "lights-64", text: || lights(8, 8) },
    Generated { name: "lights-1000", text: || lights(25, 40) },
    Generated { name: "lights-10000", text: || lights(100, 100) },
    Generated { name: "foggy-lights-64", text: || lights(8, 8) + FOG },
    Generated { name: "foggy-lights-1000", text: || lights(25, 40) + FOG },
];

/// Fog in which a lamp a few metres away has a halo.
const FOG: &str = "fog { scatter 0.08; absorb 0.01; anisotropy 0.3 }\n";

/// Radius of spherical light sources, metres.
const RADIUS: f32 = 0.06;
/// Largest number of spherical light sources.
const MAX_SPHERES: u32 = 2000;

/// Uniform random numbers in 0..1 (splitmix64; Steele, Lea and Flood 2014, "Fast splittable pseudorandom number
/// generators").
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut word = self.0;
        word = (word ^ (word >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        word = (word ^ (word >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((word ^ (word >> 31)) >> 40) as f32 / 16_777_216.0
    }
    fn between(&mut self, min: f32, max: f32) -> f32 {
        min + (max - min) * self.next()
    }
}

/// Random shapes on a grid with a spacing of 1 m; some touch their neighbours.
fn union(across: u32, up: u32, deep: u32) -> String {
    const SHAPES: [&str; 8] = [
        "sphere 0.45",
        "box 0.75 0.6 0.5",
        "torus 0.36 0.13",
        "cylinder 0.3 0.8",
        "cone 0.4 0.85",
        "capsule 0.2 0.6",
        "octahedron 0.5",
        "rounded-box 0.7 0.5 0.6 0.1",
    ];
    let mut rng = SplitMix64(1);
    union_of([across, up, deep], |text, _, at| {
        let mut jitter = || rng.between(-0.1, 0.1);
        let at = at.map(|at| at + jitter());
        let rotate = [0; 3].map(|_| rng.between(0.0, 360.0));
        let shape = SHAPES[(rng.next() * SHAPES.len() as f32) as usize];
        writeln!(
            text,
            "        {shape} {{ at {:.4} {:.4} {:.4}; rotate {:.1} {:.1} {:.1} }}",
            at[0], at[1], at[2], rotate[0], rotate[1], rotate[2]
        )
        .expect("writing to a string");
    })
}

/// Balls on a grid with a spacing of 1 m, each at a height of its own formula.
fn moving(across: u32, up: u32, deep: u32) -> String {
    union_of([across, up, deep], |text, index, [x, y, z]| {
        writeln!(text, "        sphere 0.4 {{ at {x} \"{y} + 0.2 * sin(2 * t + {})\" {z} }}", index % 97)
            .expect("writing to a string");
    })
}

/// One smooth union of shapes on a grid with a spacing of 1 m, each written from its index and place.
fn union_of([across, up, deep]: [u32; 3], mut write_shape: impl FnMut(&mut String, u32, [f32; 3])) -> String {
    let size = [across, up, deep].map(|count| count as f32);
    let mut text = format!(
        "pathmarch 1\ncamera {{ position {:.3} {:.3} {:.3}; target 0 0 0; fov 40 }}\nsky 0.6 0.7 0.8\n\
         sun {{ direction 0.5 0.8 0.6; irradiance 2.5; angle 2 }}\nmaterial \"clay\" {{ diffuse 0.7 0.5 0.4 }}\n\
         object \"grid\" material=\"clay\" {{\n    union smooth=0.15 {{\n",
        1.1 * size[0],
        0.8 * size[1],
        1.6 * size[2]
    );
    for index in 0..across * up * deep {
        let place = [index % across, index / across % up, index / (across * up)];
        let at = std::array::from_fn(|k| place[k] as f32 + 0.5 - size[k] / 2.0);
        write_shape(&mut text, index, at);
    }
    text + "    }\n}\n"
}

/// Grid of small spherical light sources of random colours above a floor, with a spacing of 1.1 m; points of the same
/// intensity if there are too many objects for a kernel.
fn lights(across: u32, deep: u32) -> String {
    let mut rng = SplitMix64(2);
    let mut text = String::from(
        "pathmarch 1\ncamera { position 0 3 9; target 0 0.8 0; fov 40 }\nmaterial \"white\" { diffuse 0.75 }\n\
         object \"floor\" material=\"white\" { plane }\n\
         object \"things\" material=\"white\" { sphere 0.8 { at 0 0.8 0 }; box 1 1 1 { at -2 0.5 0.4; rotate 0 30 0 }\n\
         torus 0.6 0.2 { at 2 0.6 0.3; rotate 70 20 0 } }\n",
    );
    let place = |index: u32, count: u32| index as f32 - 0.5 * (count as f32 - 1.0);
    for index in 0..across * deep {
        let (x, z) = (place(index % across, across), place(index / across, deep));
        let colour = [0; 3].map(|_| rng.between(5.0, 60.0));
        let y = rng.between(2.2, 3.0);
        let (x, z) = (x * 1.1, z * 1.1);
        if across * deep > MAX_SPHERES {
            let [r, g, b] = colour.map(|radiance| radiance * PI * RADIUS * RADIUS);
            writeln!(text, "point {{ at {x:.3} {y:.3} {z:.3}; intensity {r:.3} {g:.3} {b:.3} }}")
        } else {
            writeln!(
                text,
                "material \"lamp {index}\" {{ emit {:.2} {:.2} {:.2} }}\n\
                 object \"lamp {index}\" material=\"lamp {index}\" {{ sphere {RADIUS} {{ at {x:.3} {y:.3} {z:.3} }} }}",
                colour[0], colour[1], colour[2],
            )
        }
        .expect("writing to a string");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use pathmarch_render::pathmarch_scene::Scene;

    #[test]
    fn generated_scenes_are_valid() {
        for (generated, leaves) in ALL.iter().zip([100, 1000, 10_000, 10_000, 68, 1004, 4, 68, 1004]) {
            let scene = Scene::parse(generated.name, &generated.text()).expect("a valid scene");
            assert_eq!(scene.field.leaves().len(), leaves, "{}", generated.name);
        }
    }
}
