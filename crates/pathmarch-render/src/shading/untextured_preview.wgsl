// Preview materials without textures. Takes the place of textured_preview.wgsl.

fn textured_preview(material: PreviewMaterial) -> PreviewMaterial {
    return material;
}
