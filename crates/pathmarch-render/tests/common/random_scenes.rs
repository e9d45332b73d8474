//! Random scenes of fractals, repetition, warps and smooth operators: long paths through expensive fields.

/// Random numbers of a seed (PCG hash; Jarzynski and Olano 2020).
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> u32 {
        let state = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        self.0 = state;
        let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (word >> 22) ^ word
    }
    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.next() >> 8) as f32 / 16_777_216.0
    }
    fn one_of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.next() as usize % all.len()]
    }
}

/// Text of the scene of a seed; always valid.
pub fn random_scene(seed: u32) -> String {
    let mut numbers = Numbers(seed.wrapping_mul(0x9e37_79b9) ^ 0x5eed);
    let bounces = 4 + numbers.next() % 9;
    let mut text = format!(
        "pathmarch 1\ncamera {{ position {:.2} {:.2} {:.2}; target 0 0 0; fov 45 }}\nrender {{ bounces {bounces} }}\n\
         sky 0.3 0.4 0.5\nsun {{ direction 1 2 1; irradiance 2; angle 2 }}\nmaterial \"diffuse\" {{ diffuse 0.8 }}\n\
         material \"metal\" {{ metal 0.9; roughness 0.3 }}\nmaterial \"glass\" {{ glass 1; ior 1.4 }}\n\
         material \"lamp\" {{ emit 3 }}\nmaterial \"paint\" {{ principled 0.7; coat 1 }}\n",
        numbers.between(-3.0, 3.0),
        numbers.between(0.5, 3.0),
        numbers.between(4.0, 6.0),
    );
    for object in 0..1 + numbers.next() % 3 {
        let material = numbers.one_of(&["diffuse", "diffuse", "metal", "glass", "paint"]);
        let solid = solid(&mut numbers, 3);
        text += &format!("object \"{object}\" material=\"{material}\" {{ {solid} }}\n");
    }
    text
}

fn solid(numbers: &mut Numbers, depth: u32) -> String {
    let at = [(); 3].map(|()| numbers.between(-0.8, 0.8));
    let turn = numbers.between(-90.0, 90.0);
    let placed = format!("rotate 0 {turn:.1} 10; at {:.2} {:.2} {:.2}", at[0], at[1], at[2]);
    if depth == 0 || numbers.next() % 4 == 0 {
        return leaf(numbers, &placed);
    }
    let mut inside = || solid(numbers, depth - 1);
    let (a, b) = (inside(), inside());
    let smooth = numbers.between(0.02, 0.3);
    match numbers.next() % 9 {
        0 | 1 => format!("union smooth={smooth:.2} {{ {a}; {b}; {placed} }}"),
        2 => format!("subtract smooth={smooth:.2} {{ {a}; {b}; {placed} }}"),
        3 => format!("repeat 2.5 0 2.5 count=3 {{ {a}; scale 0.4; {placed} }}"),
        4 => format!("polar 5 {{ {a}; scale 0.6; {placed} }}"),
        5 => format!("twist 0.15 {{ {a}; {placed} }}"),
        6 => format!("shell 0.08 {{ {a}; {placed} }}"),
        7 => format!("displace 0.03 3 {{ {a}; {placed} }}"),
        _ => format!("mirror {{ {a}; {placed} }}"),
    }
}

fn leaf(numbers: &mut Numbers, placed: &str) -> String {
    let material = numbers.one_of(&["", "", "", " material=\"lamp\"", " material=\"glass\""]);
    let fractal = numbers.one_of(&[
        "mandelbulb",
        "mandelbox",
        "julia",
        "menger",
        "sierpinski",
        "apollonian",
        "kleinian",
        "ifs",
        "sphere",
        "box",
        "torus",
        "octahedron",
    ]);
    let scale = match fractal {
        "mandelbox" | "kleinian" => 0.25,
        "menger" | "sierpinski" | "apollonian" | "ifs" => 0.7,
        _ => 0.9,
    };
    let numbers = match fractal {
        "menger" => " 4",
        _ => "",
    };
    format!("{fractal}{numbers}{material} {{ scale {scale}; {placed} }}")
}
