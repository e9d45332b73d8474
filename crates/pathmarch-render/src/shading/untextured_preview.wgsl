// Preview materials without textures. Takes the place of textured_preview.wgsl.

/// Returns the preview material unchanged.
fn textured_preview(material: PreviewMaterial) -> PreviewMaterial {
    return material;
}
