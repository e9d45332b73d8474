//! The outline of a file: its nodes, without the parameters in them.

use super::nodes::{arguments, material_kind, property, text_argument};
use super::path::Path;
use crate::language::keywords::{FIELD, FOG, INCLUDE, MESH, NORMAL, PARAM, PLACEMENT, POINT, SHAPE};
use crate::language::read::declarations::leaf_counts;
use crate::language::tree::{Block, Node, Value};
use pathmarch_field::registry;
use std::collections::{HashMap, HashSet};

/// Kind of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ItemKind {
    /// `pathmarch 1`
    Version,
    /// An included file.
    Include,
    /// A parameter, which formulas use.
    Param,
    /// A custom SDF.
    Field,
    /// A camera.
    Camera,
    /// Picture size and quality.
    Render,
    /// The sky: radiance of the surroundings.
    Sky,
    /// The medium between the objects.
    Fog,
    /// A sun.
    Sun,
    /// A point light.
    Point,
    /// A spot light.
    Spot,
    /// A material.
    Material,
    /// An object.
    Object,
    /// A shape that the file declares.
    Declaration,
    /// A use of a declared shape, or of an unknown one, which is a mistake.
    Instance,
    /// A shape of the registry.
    Shape,
    /// An operator of the registry.
    Operator,
    /// Anything else; a mistake.
    Other,
}

impl ItemKind {
    /// Kind of a node of this name, in a parent of this kind or at the top of the file.
    fn of(word: &str, parent: Option<Self>, declared: &dyn Fn(&str) -> bool) -> Self {
        match (parent, word) {
            (None, "pathmarch") => Self::Version,
            (None, INCLUDE) => Self::Include,
            (None, PARAM) => Self::Param,
            (None, FIELD) => Self::Field,
            (None, "camera") => Self::Camera,
            (None, "render") => Self::Render,
            (None, "sky") => Self::Sky,
            (None, FOG) => Self::Fog,
            (None, "sun") => Self::Sun,
            (None, "point") => Self::Point,
            (None, "spot") => Self::Spot,
            (None, "material") => Self::Material,
            (None, SHAPE) => Self::Declaration,
            (None, "object") => Self::Object,
            (Some(_), word) => match registry::solid(word) {
                Some(solid) if solid.is_operator() => Self::Operator,
                Some(_) => Self::Shape,
                None if word == MESH || declared(word) => Self::Shape,
                None => Self::Instance,
            },
            _ => Self::Other,
        }
    }
    /// True if a child of this name is in the outline, and not a parameter.
    fn shows(self, word: &str) -> bool {
        match self {
            Self::Object | Self::Operator => !PLACEMENT.contains(&word),
            Self::Declaration => word != PARAM,
            Self::Instance => !PLACEMENT.contains(&word),
            Self::Shape => !PLACEMENT.contains(&word) && word != NORMAL && word != POINT,
            _ => false,
        }
    }
    /// True if it may contain shapes.
    pub fn holds_shapes(self) -> bool {
        matches!(self, Self::Object | Self::Operator | Self::Declaration)
    }
    /// True if it has a name.
    pub fn is_named(self) -> bool {
        matches!(self, Self::Param | Self::Field | Self::Camera | Self::Material | Self::Declaration | Self::Object)
    }
    /// True if the scene may leave it out: an object, or a light.
    pub fn can_hide(self) -> bool {
        matches!(self, Self::Object | Self::Sun | Self::Point | Self::Spot)
    }
    /// True if objects and operators may contain it.
    pub fn is_solid(self) -> bool {
        matches!(self, Self::Shape | Self::Instance | Self::Operator)
    }
}

/// A node of the outline.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// Path of the node.
    pub path: Path,
    /// Kind of the node.
    pub kind: ItemKind,
    /// Its first word: `sphere`, `object`.
    pub word: String,
    /// Its name, of those that have one; a camera without is `main`.
    pub name: Option<String>,
    /// Its `material=`; for a material, the name of its kind.
    pub material: Option<String>,
    /// True for an object or a light that the scene leaves out.
    pub hidden: bool,
    /// Nodes within it, in the order of the file.
    pub children: Vec<Item>,
    /// Index of its first shape among those of all objects, and the number of its shapes.
    pub(crate) leaves: (usize, usize),
}

impl Item {
    /// Its name, or else its first word.
    pub fn title(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.word)
    }
}

/// The outline of a file.
pub(crate) fn outline(file: &Block<'static>, included: &[Node<'static>]) -> Vec<Item> {
    let names: HashSet<&str> = declared_names(file).collect();
    let counts = leaf_counts(file.nodes.iter().chain(included));
    items(file, None, &Path::default(), &mut Walk { declared: &|word| names.contains(word), counts, leaves: 0 })
}

/// Names of the fields that a file declares.
fn declared_names<'b>(file: &'b Block<'static>) -> impl Iterator<Item = &'b str> {
    file.nodes.iter().filter(|node| node.name.value == FIELD).filter_map(text_argument)
}

/// A walk through a file.
struct Walk<'w> {
    declared: &'w dyn Fn(&str) -> bool,
    /// Number of shapes in each declared shape.
    counts: HashMap<String, usize>,
    /// Shapes so far.
    leaves: usize,
}

fn items(block: &Block<'static>, parent: Option<ItemKind>, path: &Path, walk: &mut Walk) -> Vec<Item> {
    let shown = shown(block, parent).enumerate();
    shown.map(|(index, (_, node))| item(node, parent, path.child(index), walk)).collect()
}

fn item(node: &Node<'static>, parent: Option<ItemKind>, path: Path, walk: &mut Walk) -> Item {
    let word = &*node.name.value;
    let kind = ItemKind::of(word, parent, walk.declared);
    let first = walk.leaves;
    walk.leaves += match kind {
        ItemKind::Shape => 1,
        ItemKind::Instance => walk.counts.get(word).copied().unwrap_or(0),
        _ => 0,
    };
    let name = kind.is_named().then(|| text_argument(node).map(str::to_owned)).flatten();
    let unnamed_camera = kind == ItemKind::Camera && arguments(node).next().is_none();
    let material = match kind {
        ItemKind::Material => material_kind(node).map(|kind| kind.name.to_owned()),
        ItemKind::Object | ItemKind::Shape | ItemKind::Instance | ItemKind::Operator => {
            match property(node, "material").map(|e| &e.value) {
                Some(Value::Text(name)) => Some(name.to_string()),
                _ => None,
            }
        }
        _ => None,
    };
    let mut children = node.children.as_ref().map_or_else(Vec::new, |block| items(block, Some(kind), &path, walk));
    let hidden = kind.can_hide() && property(node, "hidden").is_some_and(|entry| entry.value == Value::Bool(true));
    if kind == ItemKind::Declaration || hidden {
        // A declaration adds no shapes to the scene; its uses do.
        walk.leaves = first;
    }
    if hidden {
        without_leaves(&mut children);
    }
    let leaves = (first, walk.leaves - first);
    Item {
        kind,
        word: word.to_owned(),
        name: name.or_else(|| unnamed_camera.then(|| "main".to_owned())),
        material,
        hidden,
        children,
        leaves,
        path,
    }
}

/// Takes the shapes of hidden nodes, which the scene does not have.
fn without_leaves(items: &mut [Item]) {
    for item in items {
        item.leaves = (0, 0);
        without_leaves(&mut item.children);
    }
}

/// The nodes of a block that are in the outline, with their indexes among all.
pub(crate) fn shown<'b>(
    block: &'b Block<'static>,
    parent: Option<ItemKind>,
) -> impl Iterator<Item = (usize, &'b Node<'static>)> {
    let nodes = block.nodes.iter().enumerate();
    nodes.filter(move |(_, node)| parent.is_none_or(|parent| parent.shows(&node.name.value)))
}

/// A node found by its path.
#[derive(Clone, Copy)]
pub(crate) struct Found<'b> {
    pub(crate) node: &'b Node<'static>,
    pub(crate) kind: ItemKind,
    /// Block that contains it.
    pub(crate) block: &'b Block<'static>,
    /// Index in the block.
    pub(crate) index: usize,
    /// Kind of its parent.
    pub(crate) parent: Option<ItemKind>,
}

/// The node of this path.
pub(crate) fn find<'b>(file: &'b Block<'static>, path: &Path) -> Option<Found<'b>> {
    let declared = |word: &str| declared_names(file).any(|name| name == word);
    let mut found: Option<Found> = None;
    for &at in path.indexes() {
        let parent = found.map(|found| found.kind);
        let block = match found {
            Some(found) => found.node.children.as_ref()?,
            None => file,
        };
        let (index, node) = shown(block, parent).nth(at)?;
        found = Some(Found { node, kind: ItemKind::of(&node.name.value, parent, &declared), block, index, parent });
    }
    found
}
