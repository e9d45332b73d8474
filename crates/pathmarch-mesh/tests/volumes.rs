//! Volumes of distances as meshes.

use glam::Vec3;
use pathmarch_mesh::{MeshReport, ReadOptions, TriangleMesh, read_bytes};
use std::path::Path;

/// A file of `array[x, y, z]`, of these values in the order of the file.
fn file(header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let header = format!("{header:<116}\n");
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

fn header(kind: &str, order: &str, [x, y, z]: [usize; 3]) -> String {
    format!("{{'descr': '{kind}', 'fortran_order': {order}, 'shape': ({x}, {y}, {z}), }}")
}

/// Values of a function of the point, in C order: z varies fastest.
fn volume([x, y, z]: [usize; 3], value: impl Fn(Vec3) -> f32) -> Vec<f32> {
    let points = (0..x * y * z).map(|k| Vec3::new((k / (y * z)) as f32, (k / z % y) as f32, (k % z) as f32));
    points.map(value).collect()
}

fn bytes(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

fn read(bytes: &[u8]) -> Result<(TriangleMesh, usize), String> {
    let imported = read_bytes(bytes, "npy", Path::new("volume.npy"), &ReadOptions::default());
    let imported = imported.map_err(|error| error.to_string())?;
    Ok((imported.meshes[0].clone(), imported.warnings.len()))
}

/// Volume within a mesh, positive if its fronts are outside.
fn enclosed(mesh: &TriangleMesh) -> f32 {
    let signed = |[a, b, c]: [Vec3; 3]| a.dot(b.cross(c)) / 6.0;
    (0..mesh.triangles.len()).map(|k| signed(mesh.corners(k))).sum()
}

/// An ellipsoid whose radii, in steps, are 6, 9 and 12.
fn ellipsoid(p: Vec3) -> f32 {
    ((p - Vec3::new(9.5, 12.0, 14.5)) / Vec3::new(6.0, 9.0, 12.0)).length() - 1.0
}

#[test]
fn a_volume_becomes_a_closed_surface_with_its_shape() {
    let size = [20, 25, 30];
    let (mesh, warnings) = read(&file(&header("<f4", "False", size), &bytes(&volume(size, ellipsoid)))).expect("read");
    assert_eq!(warnings, 0);
    let report = MeshReport::new(&mesh, 0.0).expect("a report");
    assert!(report.is_clean(), "{report:?}");
    // The longest edge, of 29 steps, goes from -1 to 1.
    let step = 2.0 / 29.0;
    for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
        let point = *position / step;
        let radii = Vec3::new(6.0, 9.0, 12.0);
        // Linear interpolation of the curved field is a small part of a step wrong.
        assert!(((point / radii).length() - 1.0).abs() < 0.012, "{point}");
        assert!(normal.dot((point / radii / radii).normalize()) > 0.98, "{point}");
    }
    let expected = 4.0 / 3.0 * std::f32::consts::PI * 6.0 * 9.0 * 12.0 * step.powi(3);
    assert!((enclosed(&mesh) / expected - 1.0).abs() < 0.02, "{} instead of {expected}", enclosed(&mesh));
}

#[test]
fn order_and_type_of_the_values_do_not_matter() {
    let size = [20, 25, 30];
    let values = volume(size, ellipsoid);
    let (mesh, _) = read(&file(&header("<f4", "False", size), &bytes(&values))).expect("read");
    let big: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    assert!(read(&file(&header(">f4", "False", size), &big)).expect("read").0 == mesh);
    let wide: Vec<u8> = values.iter().flat_map(|value| f64::from(*value).to_le_bytes()).collect();
    assert!(read(&file(&header("<f8", "False", size), &wide)).expect("read").0 == mesh);
    let [x, y, z] = size;
    let fortran = (0..x * y * z).map(|k| values[k / (x * y) + z * (k / x % y + y * (k % x))]);
    let fortran: Vec<f32> = fortran.collect();
    assert!(read(&file(&header("<f4", "True", size), &bytes(&fortran))).expect("read").0 == mesh);
}

#[test]
fn noise_and_solids_at_the_border_are_closed() {
    // A linear congruential generator.
    let noise = |p: Vec3| {
        let seed = (p.x + 16.0 * p.y + 256.0 * p.z) as u32;
        (seed.wrapping_mul(747_796_405).wrapping_add(2_891_336_453) >> 8) as f32 / (1 << 23) as f32 - 1.0
    };
    for value in [&noise as &dyn Fn(Vec3) -> f32, &|_| -1.0] {
        let (mesh, _) =
            read(&file(&header("<f4", "False", [12, 9, 7]), &bytes(&volume([12, 9, 7], value)))).expect("read");
        let report = MeshReport::new(&mesh, 0.0).expect("a report");
        assert!(report.boundary_edges == 0 && report.flipped_edges == 0, "{report:?}");
        assert!(enclosed(&mesh) > 0.0);
    }
    let broken = |p: Vec3| if p.x == 9.0 { f32::NAN } else { ellipsoid(p) };
    let (mesh, warnings) =
        read(&file(&header("<f4", "False", [20, 25, 30]), &bytes(&volume([20, 25, 30], broken)))).expect("read");
    assert!(warnings == 1 && mesh.positions.iter().all(|position| position.is_finite()));
}

#[test]
fn mistakes_say_what_to_do() {
    let good = header("<f4", "False", [2, 2, 2]);
    for (bytes, message) in [
        (b"NUMPY".to_vec(), "does not begin"),
        (b"\x93NUMPY\x01".to_vec(), "ends within the header"),
        (b"\x93NUMPY\x09\x00\x00\x00".to_vec(), "version 9"),
        (file(&good, &[0; 31]), "31 bytes are not 2 x 2 x 2"),
        (file(&good, &[0; 32]), "same sign"),
        (file(&good.replace("<f4", "<i4"), &[0; 32]), "astype"),
        (file(&good.replace("descr", "disc"), &[0; 32]), "there is no descr"),
        (file(&good.replace("False", "Maybe"), &[0; 32]), "fortran_order"),
        (file(&good.replace("(2, 2, 2)", "(8,)"), &[0; 32]), "three dimensions"),
        (file(&good.replace("(2, 2, 2)", "(8, 1, 1)"), &[0; 32]), "too small"),
        (file(&good.replace("(2, 2, 2)", "(2, -2, 2)"), &[0; 32]), "cannot be read"),
        (file(&good.replace("(2, 2, 2)", "(1048576, 1048576, 1048576)"), &[0; 32]), "32 bytes are not"),
    ] {
        let error = read(&bytes).expect_err(message);
        assert!(error.contains("volume.npy") && error.contains(message), "{message}: {error}");
    }
}
