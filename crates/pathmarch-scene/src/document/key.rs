//! Keys of controls that a front end has its own handles for. All other keys come with [`Document::controls`].
//!
//! [`Document::controls`]: super::Document::controls

/// Name of a camera, a material or an object.
pub const NAME: &str = "name";
/// Kind of a material or a sky, or which shape or operator a node is.
pub const KIND: &str = "kind";
/// Material of an object, a shape or an operator.
pub const MATERIAL: &str = "material";
/// Position of a shape or an operator.
pub const AT: &str = "place.at";
/// Rotation of a shape or an operator.
pub const ROTATE: &str = "place.rotate";
/// Scale of a shape or an operator.
pub const SCALE: &str = "place.scale";
/// Direction that a shape faces.
pub const NORMAL: &str = "place.normal";
/// Words of a text.
pub const TEXT: &str = "text";
/// Notation of a path.
pub const PATH: &str = "path";
/// Value of a parameter.
pub const VALUE: &str = "value";
/// Last part, behind a dot, of the key that chooses the texture of a parameter.
pub const TEXTURE: &str = "texture";
/// File of a sky that is a picture. May be set for every sky, which then becomes a picture.
pub const PICTURE: &str = "picture";
