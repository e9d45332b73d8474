//! Random scenes for the tests, as text: fractals, repetitions, smooth operators and warps in all combinations.
//!
//! A scene is a function of its number. Everything but a floor is within [`MAX_EXTENT`] metres of the origin. A scene has at most
//! [`MAX_SHAPES`] shapes. No operator that makes copies contains another, and the camera is outside of all objects.
#![allow(dead_code)]

use std::fmt::Write;

/// Limit of the bounds of all objects but the floor, metres from the origin along each axis.
pub const MAX_EXTENT: f32 = 12.0;
/// Largest number of shapes of a scene, the floor included.
pub const MAX_SHAPES: usize = 40;

/// Random number generator (PCG; O'Neill 2014), the same in every run.
struct Random(u64);

impl Random {
    fn word(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = (((self.0 >> 18) ^ self.0) >> 27) as u32;
        word.rotate_right((self.0 >> 59) as u32)
    }
    /// Random integer from 0 to `count - 1`.
    fn below(&mut self, count: usize) -> usize {
        ((u64::from(self.word()) * count as u64) >> 32) as usize
    }
    /// Random number in a range, rounded to three decimals so that texts stay short.
    fn within(&mut self, low: f32, high: f32) -> f32 {
        let share = (self.word() >> 8) as f32 / 16_777_216.0;
        ((low + (high - low) * share) * 1000.0).round() / 1000.0
    }
    fn chance(&mut self, share: f32) -> bool {
        self.within(0.0, 1.0) < share
    }
    fn of<'a>(&mut self, list: &[&'a str]) -> &'a str {
        list[self.below(list.len())]
    }
}

/// Number of materials of a scene, `m0` and so on.
const MATERIALS: usize = 5;

struct Writer {
    random: Random,
    text: String,
    /// Number of shapes that may still be written.
    shapes: usize,
}

/// Text of a random scene.
pub fn random_scene(number: u64) -> String {
    let mut random = Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d);
    random.word();
    let mut writer = Writer { random, text: String::new(), shapes: MAX_SHAPES - 1 };
    writer.surroundings();
    for k in 0..MATERIALS {
        writer.material(k);
    }
    for k in 0..1 + writer.random.below(3) {
        let [x, y, z] = [0; 3].map(|_| writer.random.within(-1.0, 1.0));
        let material = writer.random.below(MATERIALS);
        write!(writer.text, "object \"o{k}\" material=\"m{material}\" {{ union {{ ").expect("writing to a string");
        writer.solid(3, true);
        writeln!(writer.text, "; at {x} {y} {z} }} }}").expect("writing to a string");
    }
    if writer.random.chance(0.6) {
        writer.text += "object \"floor\" material=\"m0\" { plane { at 0 -2.5 0 } }\n";
    }
    writer.text
}

impl Writer {
    fn put(&mut self, text: &str) {
        self.text += text;
    }
    fn number(&mut self, low: f32, high: f32) {
        let value = self.random.within(low, high);
        write!(self.text, " {value}").expect("writing to a string");
    }
    fn numbers(&mut self, ranges: &[(f32, f32)]) {
        for &(low, high) in ranges {
            self.number(low, high);
        }
    }
    /// Writes an integer.
    fn count(&mut self, low: usize, high: usize) {
        let value = low + self.random.below(high - low + 1);
        write!(self.text, " {value}").expect("writing to a string");
    }

    fn surroundings(&mut self) {
        // At least 10 m away: outside of all objects.
        let turn = self.random.within(0.0, std::f32::consts::TAU);
        let (far, height) = (self.random.within(10.0, 13.0), self.random.within(-1.5, 6.0));
        let (x, z) = (far * turn.sin(), far * turn.cos());
        let fov = self.random.within(20.0, 40.0);
        self.text = format!(
            "pathmarch 1\ncamera {{ position {x:.3} {height} {z:.3}; target 0 0 0; fov {fov} }}\n\
             render {{ size 24 24; samples 64; bounces {} }}\n",
            1 + self.random.below(8)
        );
        match self.random.below(3) {
            0 => {
                self.put("sky");
                self.numbers(&[(0.1, 1.0); 3]);
            }
            1 => {
                self.put("sky \"gradient\" { zenith");
                self.numbers(&[(0.1, 0.5), (0.2, 0.6), (0.4, 1.0)]);
                self.put("; horizon");
                self.numbers(&[(0.5, 1.2); 3]);
                self.put("; ground 0.2 0.16 0.14 }");
            }
            _ => self.put("sky 0.2 0.25 0.3"),
        }
        self.put("\nsun { direction");
        self.numbers(&[(-1.0, 1.0), (0.3, 1.0), (-1.0, 1.0)]);
        self.put("; irradiance");
        self.number(0.5, 4.0);
        self.put("; angle");
        self.number(0.0, 3.0);
        self.put(" }\n");
    }

    fn material(&mut self, k: usize) {
        write!(self.text, "material \"m{k}\" {{ ").expect("writing to a string");
        // The first material is the floor's.
        match if k == 0 { 0 } else { self.random.below(6) } {
            0 | 1 => {
                self.put("diffuse");
                self.numbers(&[(0.1, 0.8); 3]);
            }
            2 => {
                self.put("metal");
                self.numbers(&[(0.4, 0.95); 3]);
                self.put("; roughness");
                self.number(0.0, 0.6);
            }
            3 => {
                self.put("glass");
                self.numbers(&[(0.7, 1.0); 3]);
            }
            4 => {
                self.put("principled");
                self.numbers(&[(0.1, 0.9); 3]);
                self.put("; roughness");
                self.number(0.1, 1.0);
            }
            _ => {
                self.put("emit");
                self.numbers(&[(0.2, 3.0); 3]);
            }
        }
        self.put(" }\n");
    }

    /// Writes a solid of about a metre with at most `depth` nested operators; `may_copy` allows one that makes copies.
    fn solid(&mut self, depth: usize, may_copy: bool) {
        if depth == 0 || self.shapes < 4 {
            return self.shape();
        }
        match self.random.below(10) {
            0..4 => self.combination(depth, may_copy),
            4..6 if may_copy => {
                match self.random.below(4) {
                    0 | 1 => {
                        self.put("repeat");
                        let spacing = self.random.within(0.7, 1.4);
                        let axes = [[1, 0, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 0]][self.random.below(5)];
                        for axis in axes {
                            write!(self.text, " {}", spacing * axis as f32).expect("writing to a string");
                        }
                        self.put(" count=");
                        let count = 2 + self.random.below(2);
                        write!(self.text, "{count}").expect("writing to a string");
                    }
                    2 => {
                        self.put("polar");
                        self.count(2, 9);
                    }
                    _ => {
                        let axis = self.random.of(&["x", "y", "z"]);
                        write!(self.text, "mirror \"{axis}\"").expect("writing to a string");
                    }
                }
                self.child(depth, false);
            }
            4..9 => {
                match self.random.below(6) {
                    0 => {
                        self.put("twist");
                        self.number(-0.3, 0.3);
                    }
                    1 => {
                        self.put("bend");
                        self.number(0.02, 0.15);
                    }
                    2 => {
                        self.put("elongate");
                        self.numbers(&[(0.0, 0.4); 3]);
                    }
                    3 => {
                        self.put("round");
                        self.number(0.0, 0.15);
                    }
                    4 => {
                        self.put("shell");
                        self.number(0.02, 0.1);
                    }
                    _ => {
                        self.put("displace");
                        self.numbers(&[(0.0, 0.05), (0.5, 3.0)]);
                    }
                }
                self.child(depth, may_copy);
            }
            _ => self.profile(),
        }
    }

    fn child(&mut self, depth: usize, may_copy: bool) {
        self.put(" { ");
        self.solid(depth - 1, may_copy);
        self.placement(0.4);
        self.put(" }");
    }

    /// Writes the placement of a child.
    fn placement(&mut self, reach: f32) {
        // The text before ends with braces or with numbers.
        self.put("; at");
        self.numbers(&[(-reach, reach); 3]);
        self.put("; rotate");
        self.numbers(&[(-90.0, 90.0); 3]);
    }

    fn combination(&mut self, depth: usize, may_copy: bool) {
        let operator = self.random.of(&["union", "union", "union", "subtract", "intersect", "morph"]);
        self.put(operator);
        let children = if operator == "morph" {
            self.number(0.1, 0.9);
            2
        } else {
            if self.random.chance(0.8) {
                let smooth = self.random.within(0.02, 0.4);
                let profile = self.random.of(&["soft", "soft", "round", "chamfer", "stairs"]);
                write!(self.text, " smooth={smooth} profile=\"{profile}\"").expect("writing to a string");
            }
            2 + self.random.below(2)
        };
        self.put(" { ");
        for k in 0..children {
            if k > 0 {
                self.put("; ");
            }
            // Each child is a union with a placement and a material.
            let material = self.random.below(2 * MATERIALS);
            self.put("union");
            if material < MATERIALS {
                write!(self.text, " material=\"m{material}\"").expect("writing to a string");
            }
            self.put(" { ");
            self.solid(depth - 1, may_copy && k == 0);
            self.placement(0.3);
            self.put(" }");
        }
        self.put(" }");
    }

    fn profile(&mut self) {
        self.shapes = self.shapes.saturating_sub(1);
        if self.random.chance(0.5) {
            self.put("extrude");
            self.number(0.1, 0.8);
        } else {
            self.put("revolve");
            self.number(0.3, 0.7);
        }
        match self.random.below(3) {
            0 => {
                self.put(" { circle");
                self.number(0.1, 0.4);
            }
            1 => {
                self.put(" { rectangle");
                self.numbers(&[(0.3, 0.8), (0.3, 0.8), (0.0, 0.1)]);
            }
            _ => {
                self.put(" { star");
                self.count(3, 9);
                self.numbers(&[(0.3, 0.6), (0.1, 0.25)]);
            }
        }
        self.put(" }");
    }

    fn shape(&mut self) {
        self.shapes = self.shapes.saturating_sub(1);
        if self.random.chance(0.4) {
            return self.fractal();
        }
        const SHAPES: [(&str, &[(f32, f32)]); 13] = [
            ("sphere", &[(0.3, 0.8)]),
            ("box", &[(0.3, 1.2), (0.3, 1.2), (0.3, 1.2)]),
            ("rounded-box", &[(0.4, 1.2), (0.4, 1.2), (0.4, 1.2), (0.02, 0.2)]),
            ("octahedron", &[(0.4, 0.9)]),
            ("cylinder", &[(0.2, 0.5), (0.3, 1.2)]),
            ("cone", &[(0.2, 0.6), (0.4, 1.2)]),
            ("capsule", &[(0.1, 0.4), (0.2, 0.8)]),
            ("ellipsoid", &[(0.2, 0.8), (0.2, 0.8), (0.2, 0.8)]),
            ("torus", &[(0.3, 0.7), (0.05, 0.25)]),
            ("link", &[(0.2, 0.5), (0.2, 0.4), (0.05, 0.15)]),
            ("prism", &[(0.4, 1.0), (0.4, 1.0)]),
            ("hexprism", &[(0.3, 0.6), (0.3, 1.0)]),
            ("pyramid", &[(0.4, 1.0), (0.4, 1.0)]),
        ];
        let (name, ranges) = SHAPES[self.random.below(SHAPES.len())];
        self.put(name);
        self.numbers(ranges);
    }

    /// Writes a fractal, scaled to about a metre.
    fn fractal(&mut self) {
        let (size, name) = [
            (0.8, "mandelbulb"),
            (0.4, "mandelbox"),
            (0.7, "julia"),
            (0.6, "menger"),
            (0.6, "sierpinski"),
            (0.6, "apollonian"),
            (0.4, "kleinian"),
            (0.7, "ifs"),
        ][self.random.below(8)];
        self.put(name);
        match name {
            "mandelbulb" => {
                self.count(2, 12);
                self.count(2, 8);
            }
            "mandelbox" => {
                self.number(-2.0, -1.3);
                self.count(3, 10);
            }
            "julia" => {
                self.numbers(&[(-0.4, 0.4); 4]);
                self.count(4, 10);
            }
            "menger" => self.count(1, 4),
            "sierpinski" => self.count(2, 9),
            "apollonian" => {
                self.count(2, 8);
                self.number(1.1, 1.4);
            }
            "kleinian" => self.count(2, 8),
            _ => {
                self.number(1.6, 2.6);
                self.count(3, 8);
                self.numbers(&[(-40.0, 40.0), (-40.0, 40.0), (-40.0, 40.0), (0.3, 1.0), (0.0, 0.6), (0.0, 0.6)]);
            }
        }
        write!(self.text, " {{ scale {size} }}").expect("writing to a string");
    }
}
