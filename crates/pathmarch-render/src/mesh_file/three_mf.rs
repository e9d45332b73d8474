//! 3MF: a zip archive of XML, for printers.
//!
//! Format: *3D Manufacturing Format Core Specification* 1.3 and *Materials and Properties Extension* 1.2, 3mf.io. Numbers are
//! millimetres. The build platform has z up, so the item on it is turned.

use crate::output::tonemap::srgb_encode;
use pathmarch_field::Mesh;
use std::collections::HashMap;
use std::io::{self, Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;

const RELATIONSHIPS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"#;

const START: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">
<metadata name="Application">pathmarch</metadata>
<resources>
"#;

/// From y up to z up.
const END: &str = r#"</resources>
<build><item objectid="2" transform="1 0 0 0 0 1 0 -1 0 0 0 0"/></build>
</model>
"#;

pub(super) fn write(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in [("[Content_Types].xml", CONTENT_TYPES), ("_rels/.rels", RELATIONSHIPS)] {
        archive.start_file(name, SimpleFileOptions::default())?;
        archive.write_all(text.as_bytes())?;
    }
    archive.start_file("3D/3dmodel.model", SimpleFileOptions::default())?;
    write_model(&mut archive, mesh)?;
    writer.write_all(&archive.finish()?.into_inner())
}

fn write_model(writer: &mut dyn Write, mesh: &Mesh) -> io::Result<()> {
    let palette = Palette::new(mesh);
    writer.write_all(START.as_bytes())?;
    writeln!(writer, r#"<m:colorgroup id="1">"#)?;
    for [r, g, b] in &palette.colours {
        writeln!(writer, r##"<m:color color="#{r:02X}{g:02X}{b:02X}"/>"##)?;
    }
    writeln!(writer, "</m:colorgroup>\n<object id=\"2\" type=\"model\" pid=\"1\" pindex=\"0\"><mesh><vertices>")?;
    for [x, y, z] in &mesh.positions {
        writeln!(writer, r#"<vertex x="{x}" y="{y}" z="{z}"/>"#)?;
    }
    writeln!(writer, "</vertices><triangles>")?;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle;
        let [p, q, r] = triangle.map(|vertex| palette.of_vertices[vertex as usize]);
        writeln!(writer, r#"<triangle v1="{a}" v2="{b}" v3="{c}" pid="1" p1="{p}" p2="{q}" p3="{r}"/>"#)?;
    }
    writeln!(writer, "</triangles></mesh></object>")?;
    writer.write_all(END.as_bytes())
}

/// Colours of a mesh, 8-bit sRGB, in the order of their first vertices.
struct Palette {
    colours: Vec<[u8; 3]>,
    /// Index of the colour of each vertex.
    of_vertices: Vec<usize>,
}

impl Palette {
    fn new(mesh: &Mesh) -> Self {
        let mut indices = HashMap::new();
        let mut colours = Vec::new();
        let mut index = |colour: &[f32; 3]| {
            let code = colour.map(|channel| (srgb_encode(channel) * 255.0).round() as u8);
            *indices.entry(code).or_insert_with(|| {
                colours.push(code);
                colours.len() - 1
            })
        };
        let of_vertices = mesh.colours.iter().map(&mut index).collect();
        Self { colours, of_vertices }
    }
}
