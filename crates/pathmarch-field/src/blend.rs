//! Blend profiles: the cross-section of the seam between two surfaces.
//!
//! Idea: a blend of two distances is a curve in the plane of both (a, b), which joins the axis a = 0 to the axis b = 0. The
//! curves are the quadratic polynomial of Quilez 2013 ("Smooth minimum"), which is soft, and three of the library of Mercury
//! (hg_sdf 2015): a quarter of a circle, a straight line and stairs.
//!
//! Where we differ: the library gives distances that are right where the two surfaces meet at a right angle, and up to √2
//! times too large where they are parallel (`fOpUnionRound`: ∂/∂a + ∂/∂b is cos φ + sin φ). Here the value is the t for
//! which (a - t, b - t) is on the curve: the distance to it in the norm max(|a|, |b|). It is of the form
//! min(a, b) - h(|a - b|), its derivatives are never negative and ∂/∂a + ∂/∂b = 1, so that the gradient is a mean of both
//! gradients and the Lipschitz constant of the children is kept, however they stand to each other. The surface is the
//! library's; the price is a distance up to √½ too small beside the seam. The stairs of the library have this form already.
//! Cost: a few operations; a square root for the round one.

use crate::number::Real;

/// Cross-section of the seam of a blend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BlendProfile {
    /// A soft transition without edges: a parabola.
    Soft,
    /// A quarter of a circle.
    Round,
    /// A flat cut.
    Chamfer,
    /// Steps.
    Stairs,
}

/// Blend of an operator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// Width of the blend, metres of distance; the parameter of an operator that does not blend edges.
    pub amount: f32,
    /// Cross-section of the seam.
    pub profile: BlendProfile,
    /// Number of steps of [`BlendProfile::Stairs`].
    pub steps: f32,
}

/// Soft blend of this width, metres.
impl From<f32> for Blend {
    fn from(amount: f32) -> Self {
        Self { amount, profile: BlendProfile::Soft, steps: DEFAULT_STEPS }
    }
}

/// Default number of steps of stairs.
pub const DEFAULT_STEPS: f32 = 4.0;
/// Largest number of steps.
pub const MAX_STEPS: u32 = 1000;

impl BlendProfile {
    /// All profiles; the first is the default.
    pub const ALL: [Self; 4] = [Self::Soft, Self::Round, Self::Chamfer, Self::Stairs];

    /// Name in the scene language.
    pub fn name(self) -> &'static str {
        match self {
            Self::Soft => "soft",
            Self::Round => "round",
            Self::Chamfer => "chamfer",
            Self::Stairs => "stairs",
        }
    }
    /// One sentence of documentation.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Soft => "A soft transition without edges.",
            Self::Round => "A quarter of a circle, of the radius `smooth`.",
            Self::Chamfer => "A flat cut, `smooth` wide along both surfaces.",
            Self::Stairs => "Steps, `smooth` wide along both surfaces.",
        }
    }
    /// Reports whether its functions take a number of steps.
    pub(crate) fn has_steps(self) -> bool {
        self == Self::Stairs
    }
}

impl Blend {
    /// Largest offset of the surface by the blend, metres.
    pub(crate) fn reach(self) -> f32 {
        let share = match self.profile {
            BlendProfile::Soft => 0.25,
            BlendProfile::Round => 1.0 - std::f32::consts::FRAC_1_SQRT_2,
            BlendProfile::Chamfer => 0.5,
            // The outer edges of the steps.
            BlendProfile::Stairs => 0.5 + 0.5 / self.steps,
        };
        share * self.amount
    }
    /// Converts the blend to the number type `N`.
    pub(crate) fn over<N: Real>(self) -> Blending<N> {
        Blending { amount: N::constant(self.amount), profile: self.profile, steps: N::constant(self.steps) }
    }
}

/// A [`Blend`] over any number type.
#[derive(Clone, Copy)]
pub struct Blending<N> {
    /// As [`Blend::amount`].
    pub amount: N,
    /// As [`Blend::profile`].
    pub profile: BlendProfile,
    /// As [`Blend::steps`].
    pub steps: N,
}

/// Closeness of both distances: one if they are equal, zero if they differ by the width or more.
#[inline(always)]
fn nearness<N: Real>(a: N, b: N, width: N) -> N {
    (N::one() - (a - b).abs() / width.max(N::constant(1e-6))).max(N::zero())
}

/// Blended minimum of two distances.
#[inline(always)]
pub(crate) fn minimum<N: Real>(a: N, b: N, Blending { amount: width, profile, steps }: Blending<N>) -> N {
    // In this order |b - a| and the minimum take the same side where both are equal, so that their derivatives agree.
    let half = N::constant(0.5);
    match profile {
        BlendProfile::Soft => {
            let h = nearness(b, a, width).named("h");
            a.min(b) - h * h * width * N::constant(0.25)
        }
        BlendProfile::Round => {
            let apart = (b - a).abs().min(width).named("apart");
            let root = (N::constant(2.0) * width * width - apart * apart).sqrt();
            a.min(b) - (width - half * (apart + root))
        }
        BlendProfile::Chamfer => {
            let apart = (b - a).abs().min(width);
            a.min(b) - half * (width - apart)
        }
        BlendProfile::Stairs => {
            let step = (width / steps).max(N::constant(1e-6)).named("step");
            // As those of the library, but the first step ends a width away and not less.
            let along = (width + step - (b - a).abs()).max(N::zero()).named("along");
            // Distance to a multiple of two steps, where the inner edges are.
            let turns = (half * along / step + half).floor();
            let wave = (along - N::constant(2.0) * step * turns).abs();
            a.min(b) - half * (along - wave)
        }
    }
}

/// Weight of `b` in the blended minimum, 0..1: its share of the gradient of the soft one.
#[inline(always)]
pub(crate) fn weight<N: Real>(a: N, b: N, width: N) -> N {
    let half = nearness(a, b, width) * N::constant(0.5);
    N::select(b.lt(a), N::one() - half, half)
}
