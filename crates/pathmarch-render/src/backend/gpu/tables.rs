//! Functions of a kernel that read the tables of leaves, materials and lights.
//!
//! Records that the lanes of a software adapter read at places of their own take eight loads for each word. Where a table is
//! short, its function therefore contains the records of a long picture, and selects among the different values of each
//! field. A table of one record is then a constant. Measured in docs/performance.md.

use super::encode::LightRecord;
use crate::scene::{LeafRecord, MaterialRecord, RenderScene};
use crate::wgsl::{FieldValue, SharedStruct, field_values};
use std::collections::BTreeMap;

/// Longest table whose records a kernel contains.
const MAX_CONSTANT_RECORDS: usize = 16;

/// Functions that read the tables, in WGSL.
pub(super) struct TableReaders {
    /// Functions for leaves, materials and the parameters of materials.
    pub(super) objects: String,
    /// Function for lights.
    pub(super) lights: String,
}

impl TableReaders {
    /// Functions for the tables of a scene; with `are_constant`, those of short tables contain the records.
    pub(super) fn new(scene: &RenderScene, are_constant: bool) -> Self {
        let lights: Vec<LightRecord> = scene.lights.iter().map(LightRecord::new).collect();
        let leaves = fields_of(&scene.leaves, are_constant);
        let materials = fields_of(&scene.materials, are_constant);
        let parameters =
            materials.as_ref().and_then(|fields| fields.last()).map(|field| selected("k", field.parts.iter()));
        let parameter = parameters.unwrap_or_else(|| "materials[index].parameters[k]".to_owned());
        let parameter_reader =
            format!("\nfn material_parameter(index: u32, k: u32) -> vec4f {{\n    return {parameter};\n}}\n");
        Self {
            objects: reader::<LeafRecord>("leaf_at", "leaves", leaves)
                + &reader::<MaterialRecord>("material_at", "materials", materials)
                + &parameter_reader,
            lights: reader::<LightRecord>("light_at", "lights", fields_of(&lights, are_constant)),
        }
    }
}

/// Function that returns a record of the array `table`, or one of these fields.
fn reader<S: SharedStruct>(function: &str, table: &str, fields: Option<Vec<FieldValue>>) -> String {
    let record = match fields {
        Some(fields) => format!("{}({})", S::NAME, fields.iter().map(FieldValue::wgsl).collect::<Vec<_>>().join(", ")),
        None => format!("{table}[index]"),
    };
    format!("\nfn {function}(index: u32) -> {} {{\n    return {record};\n}}\n", S::NAME)
}

/// Fields of the record at `index`, as expressions; `None` if they are not constant: if there are no records or too many, or
/// if a number is not finite.
fn fields_of<S: SharedStruct + bytemuck::Pod>(records: &[S], are_constant: bool) -> Option<Vec<FieldValue>> {
    if !are_constant || !(1..=MAX_CONSTANT_RECORDS).contains(&records.len()) {
        return None;
    }
    let values = records.iter().map(field_values).collect::<Option<Vec<_>>>()?;
    let field = |index: usize| {
        let FieldValue { kind, ref parts } = values[0][index];
        let part = |part: usize| selected("index", values.iter().map(|record| &record[index].parts[part]));
        FieldValue { kind, parts: (0..parts.len()).map(part).collect() }
    };
    Some((0..values[0].len()).map(field).collect())
}

/// Expression for the value at a place; the most frequent one needs no condition.
fn selected<T: AsRef<str> + Ord>(place: &str, values: impl Iterator<Item = T>) -> String {
    let mut places: BTreeMap<T, Vec<usize>> = BTreeMap::new();
    for (index, value) in values.enumerate() {
        places.entry(value).or_default().push(index);
    }
    let mut places: Vec<_> = places.into_iter().collect();
    places.sort_by_key(|(_, indices)| std::cmp::Reverse(indices.len()));
    let (most, others) = places.split_first().expect("a table that is not empty");
    others.iter().fold(most.0.as_ref().to_owned(), |otherwise, (value, indices)| {
        let conditions: Vec<String> = indices.iter().map(|index| format!("({place} == {index}u)")).collect();
        format!("select({otherwise}, {}, {})", value.as_ref(), conditions.join(" | "))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wgsl::shared_struct;

    shared_struct! {
        /// A record.
        struct Pair as WgslPair {
            first: f32,
            second: u32,
        }
    }

    #[test]
    fn functions_select_among_the_values_of_each_field() {
        let record = |first, second| Pair { first, second };
        let records = [record(0.5, 7), record(2.0, 7), record(0.5, 7), record(4.0, 7)];
        let expected = "\nfn pair_at(index: u32) -> WgslPair {\n    return WgslPair(f32(select(select(0.5, 2.0, (index == 1u)), 4.0, \
                        (index == 3u))), u32(7u));\n}\n";
        assert_eq!(reader::<Pair>("pair_at", "pairs", fields_of(&records, true)), expected);
        let read = "\nfn pair_at(index: u32) -> WgslPair {\n    return pairs[index];\n}\n";
        let too_many = [record(1.0, 1); MAX_CONSTANT_RECORDS + 1];
        for (records, are_constant) in
            [(&records[..], false), (&[], true), (&too_many, true), (&[record(f32::NAN, 1)], true)]
        {
            assert_eq!(reader::<Pair>("pair_at", "pairs", fields_of(records, are_constant)), read);
        }
    }
}
