//! Quadratic error function: the point nearest to several planes.
//!
//! **Idea.** Each crossing of an edge, with the field's gradient, is a plane. The sum of the squared distances to
//! all of them is least where they meet: on a face anywhere, on an edge along a line, at a corner in a point (Garland and
//! Heckbert 1997; Ju et al. 2002). **Source.** In directions of small eigenvalues, which the planes hardly determine, the point
//! stays at the mean of the crossings (Lindstrom 2000). **Difference.** Eigenvalues come from
//! Jacobi's rotations, in double precision. **Cost.** About 0.2 µs.

use glam::{DMat3, DVec3};

/// Fraction of the largest eigenvalue below which a direction is undetermined: two planes that meet at less than 11° are one
/// smooth surface.
const LEAST_SHARE: f64 = 0.01;

/// Point nearest to planes, each a point and a unit normal, and the number of directions that they determine: 1 on a face, 2 on an
/// edge, 3 at a corner. In the others it is the mean of the points.
pub(super) fn solve(planes: impl Iterator<Item = (DVec3, DVec3)> + Clone) -> (DVec3, usize) {
    let (count, sum) = planes.clone().fold((0.0, DVec3::ZERO), |(n, sum), (point, _)| (n + 1.0, sum + point));
    let mean = sum / count;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (point, normal) in planes {
        matrix += DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        right += normal * normal.dot(point - mean);
    }
    let (values, vectors) = eigen(matrix);
    let least = values.max_element() * LEAST_SHARE;
    let told: Vec<_> = (0..3).filter(|&k| values[k] > least).collect();
    let along = |&k: &usize| vectors.col(k) * (vectors.col(k).dot(right) / values[k]);
    (mean + told.iter().map(along).sum::<DVec3>(), told.len())
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix: Jacobi's rotations (Golub and Van Loan 2013, section 8.5).
fn eigen(matrix: DMat3) -> (DVec3, DMat3) {
    let (mut matrix, mut vectors) = (matrix, DMat3::IDENTITY);
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let beside = matrix.col(q)[p];
            if beside.abs() < 1e-15 {
                continue;
            }
            let theta = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * beside);
            let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
            let sine = tangent * cosine;
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cosine;
            turn.col_mut(q)[q] = cosine;
            turn.col_mut(q)[p] = sine;
            turn.col_mut(p)[q] = -sine;
            matrix = turn.transpose() * matrix * turn;
            vectors *= turn;
        }
    }
    (DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_edges_and_faces_are_met() {
        let corner = DVec3::new(0.3, -0.2, 0.1);
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 0.9, -0.3);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis);
        let plane = |k: usize, a: f64, b: f64| (corner + axes[(k + 1) % 3] * a + axes[(k + 2) % 3] * b, axes[k]);
        let planes = [plane(0, 0.2, 0.5), plane(1, -0.3, 0.1), plane(2, 0.4, -0.6)];
        let (met, told) = solve(planes.into_iter());
        assert!((met - corner).length() < 1e-12 && told == 3);
        let edge = [plane(0, 0.2, 0.5), plane(1, -0.3, 0.1)];
        let (met, told) = solve(edge.into_iter());
        assert_eq!(told, 2);
        assert!((met - corner).dot(axes[0]).abs() < 1e-12 && (met - corner).dot(axes[1]).abs() < 1e-12);
        let face = [plane(0, 0.2, 0.5), plane(0, 0.4, 0.1)];
        let (met, told) = solve(face.into_iter());
        assert!((met - plane(0, 0.3, 0.3).0).length() < 1e-12 && told == 1, "the mean, where it is flat");
    }

    #[test]
    fn a_gentle_bend_is_smooth() {
        let slope = 0.05_f64;
        let planes = [
            (DVec3::new(-0.5, 0.0, 0.0), DVec3::new(-slope, 1.0, 0.0).normalize()),
            (DVec3::new(0.3, 0.0, 0.0), DVec3::new(slope, 1.0, 0.0).normalize()),
        ];
        assert!((solve(planes.into_iter()).0.x + 0.1).abs() < 0.01);
    }
}
