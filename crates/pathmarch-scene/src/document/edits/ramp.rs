//! Colour ramps: the `colour` nodes of a texture or an orbit trap.

use super::transaction::Transaction;
use crate::document::control::Value;
use crate::document::error::EditError;
use crate::document::parameters::{Inside, Parameter, Place, holder};
use crate::document::text::layout::{Chunk, Site, insert_first};
use crate::document::text::literals::{number, numbers};
use crate::document::tree::path::Path;
use crate::language::keywords::{COLOUR, COLOUR_POSITION, ORBIT_TRAP};
use crate::textures;

/// A colour ramp of a material.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp {
    /// Parameter that it colours, the first part of the keys of its colours.
    pub name: String,
    /// Present colours, linear Rec. 709; empty if the text gives none.
    pub colours: Vec<[f32; 3]>,
    /// Value of each colour, from 0 to 1, never falling.
    pub positions: Vec<f32>,
    /// Values of the colours that the text gives.
    pub(crate) given: Vec<Option<f32>>,
    /// Node whose texture or orbit trap it is in.
    pub(crate) owner: &'static str,
}

impl Ramp {
    /// Key of the position of a colour.
    pub(crate) fn position_key(&self, index: usize) -> String {
        format!("{}.{COLOUR}.{}.{COLOUR_POSITION}", self.name, index + 1)
    }

    /// Its present colours and their positions.
    pub fn gradient(&self) -> textures::Ramp {
        textures::Ramp { colours: self.colours.clone(), positions: Some(self.positions.clone()) }
    }
}

/// Ramps among the parameters of a material.
pub(crate) fn ramps(parameters: &[Parameter]) -> Vec<Ramp> {
    let mut ramps: Vec<Ramp> = Vec::new();
    // The texture of a number has a range of values, that of bumps a height.
    let is_number = |name: &str| {
        let words = ["from", "height"].map(|word| format!("{name}.{word}"));
        parameters.iter().any(|parameter| words.iter().any(|word| *word == parameter.control.key))
    };
    for Parameter { control, place } in parameters {
        let name = control.key.split('.').next().unwrap_or_default().to_owned();
        let owner = match place {
            Place::Inside(owner, Inside::Colour(_) | Inside::ColourPosition(_)) => *owner,
            // One that has no colours yet.
            Place::Node(ORBIT_TRAP) if control.given => ORBIT_TRAP,
            Place::Texture(owner) if control.given && !is_number(&name) => match &control.value {
                Value::Text(kind) if textures::kind(kind).is_some() => owner,
                _ => continue,
            },
            _ => continue,
        };
        if ramps.iter().all(|ramp| ramp.owner != owner) {
            ramps.push(Ramp { name, colours: Vec::new(), positions: Vec::new(), given: Vec::new(), owner });
        }
        let Some(ramp) = ramps.iter_mut().find(|ramp| ramp.owner == owner) else { continue };
        match (place, &control.present) {
            (Place::Inside(_, Inside::Colour(_)), Value::Colour(colour)) => ramp.colours.push(*colour),
            // One that cannot be read has a place nevertheless.
            (Place::Inside(_, Inside::Colour(_)), _) => ramp.colours.push([0.0; 3]),
            (Place::Inside(_, Inside::ColourPosition(_)), Value::Number(position)) if control.given => {
                ramp.given.push(Some(*position));
            }
            (Place::Inside(_, Inside::ColourPosition(_)), _) => ramp.given.push(None),
            _ => {}
        }
    }
    for ramp in &mut ramps {
        ramp.positions = textures::Ramp::spaced(&ramp.given);
    }
    ramps
}

/// The colour node of this index in the ramp of `owner`.
fn site<'t>(
    transaction: &'t Transaction,
    path: &Path,
    owner: &'static str,
    colour: usize,
) -> Result<Site<'t>, EditError> {
    let found = transaction.find(path)?;
    let site = holder(found.node, &Place::Inside(owner, Inside::Argument)).and_then(|holder| {
        transaction.writer(found).of(holder).check_braces().ok()?;
        let block = holder.children.as_ref()?;
        let mut colours = (0..block.nodes.len()).filter(|index| block.nodes[*index].name.value == COLOUR);
        Some(Site { block, top: false, index: colours.nth(colour)? })
    });
    site.ok_or_else(|| EditError::NotHere(format!("This ramp has no colour {}.", colour + 1)))
}

/// Puts a chunk into a ramp, where it has this index.
fn insert(
    transaction: &mut Transaction,
    path: &Path,
    owner: &'static str,
    index: usize,
    chunk: &Chunk,
) -> Result<(), EditError> {
    let patch = match index.checked_sub(1) {
        Some(before) => {
            site(transaction, path, owner, before)?.insert_behind(&transaction.text, chunk, transaction.style)
        }
        None => {
            let found = transaction.find(path)?;
            let Some(holder) = holder(found.node, &Place::Inside(owner, Inside::Argument)) else {
                return Err(EditError::NotHere(format!("`{owner}` has no texture.")));
            };
            transaction.writer(found).of(holder).check_braces()?;
            insert_first(&transaction.text, holder, chunk, transaction.style)
        }
    };
    transaction.then(vec![patch])
}

/// Adds colours to a ramp, of which the first then has this index, with their positions if they are given.
pub(crate) fn add(
    transaction: &mut Transaction,
    path: &Path,
    owner: &'static str,
    index: usize,
    colours: &[([f32; 3], Option<f32>)],
) -> Result<(), EditError> {
    for (colour, position) in colours.iter().rev() {
        let grey = colour.iter().all(|channel| *channel == colour[0]);
        let values = if grey { &colour[..1] } else { &colour[..] };
        let position = position.map(|position| format!(" {COLOUR_POSITION}={}", number(position))).unwrap_or_default();
        let chunk = Chunk::new(&format!("{COLOUR} {}{position}", numbers(values)), transaction.style);
        insert(transaction, path, owner, index, &chunk)?;
    }
    Ok(())
}

/// Removes a colour from a ramp.
pub(crate) fn remove(
    transaction: &mut Transaction,
    path: &Path,
    owner: &'static str,
    index: usize,
) -> Result<(), EditError> {
    let patch = site(transaction, path, owner, index)?.removal(&transaction.text, false);
    transaction.then(vec![patch])
}
