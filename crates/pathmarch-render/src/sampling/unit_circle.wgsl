// Points on the unit circle. Twin of `unit_circle` in the number types of fields, which explains it.

/// Cosine and sine of `turn` full turns, 0 to 1.
fn unit_circle(turn: f32) -> vec2f {
    let v = turn - 0.5;
    let x = v * v;
    let sine = v * ((((0.07722009 * x - 0.5980452) * x + 2.5500314) * x - 5.167707) * x + 3.14159265);
    let cosine = (((0.21969669 * x - 1.3318801) * x + 4.058412) * x - 4.934793) * x + 1.0;
    let twice = sine + sine;
    return vec2f(twice * sine - 1.0, -twice * cosine);
}
