use pathmarch_mesh::{ReadOptions, read};
use std::path::Path;

#[test]
fn show() {
    for dir in ["tests/data/odd", "tests/data", "/work/shared/meshes", "/work/shared/meshes/spot"] {
        let mut paths: Vec<_> = std::fs::read_dir(Path::new(dir)).unwrap().map(|e| e.unwrap().path()).collect();
        paths.sort();
        for path in paths {
            if path.is_dir() {
                continue;
            }
            match read(&path, &ReadOptions::default()) {
                Ok(i) => {
                    let m = i.merged(1 << 24).unwrap();
                    println!(
                        "{:40} meshes {} nodes {} mats {} imgs {} tris {} verts {} n{} uv{} c{} area {:.4} vol {:.4}",
                        path.file_name().unwrap().display(),
                        i.meshes.len(),
                        i.nodes.len(),
                        i.materials.len(),
                        i.images.len(),
                        m.triangles.len(),
                        m.positions.len(),
                        m.normals.len(),
                        m.uvs[0].len(),
                        m.colours.len(),
                        m.area(),
                        m.volume()
                    );
                    for w in &i.warnings {
                        println!("      W {w}");
                    }
                }
                Err(e) => println!("{e}"),
            }
        }
    }
}
