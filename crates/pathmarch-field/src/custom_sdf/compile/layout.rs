//! Layout of values in slots: numbers of scalars, and offsets of parts.

use super::{Body, Compiler, MAX_SLOTS, fault};
use crate::custom_sdf::CodeDiagnostic;
use naga::{ArraySize, Expression, Handle, ScalarKind, Span, Type, TypeInner};

/// Parts of an expression's type.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub(super) kind: ScalarKind,
    /// Scalars of a column.
    pub(super) rows: u32,
    pub(super) columns: u32,
}

impl Shape {
    pub(super) fn count(self) -> u32 {
        self.rows * self.columns
    }
    pub(super) fn is_scalar(self) -> bool {
        self.count() == 1
    }
}

impl Compiler<'_> {
    /// Number of scalars of a value of this type.
    pub(super) fn size(&self, inner: &TypeInner, span: Span) -> Result<u32, CodeDiagnostic> {
        let scalar = |scalar: naga::Scalar| match (scalar.kind, scalar.width) {
            (ScalarKind::Bool, _) | (_, 4) => Ok(()),
            _ => Err(fault(span, "Numbers of a field are f32, i32 and u32.")),
        };
        match *inner {
            TypeInner::Scalar(kind) => scalar(kind).map(|()| 1),
            TypeInner::Vector { size, scalar: kind } => scalar(kind).map(|()| size as u32),
            TypeInner::Matrix { columns, rows, scalar: kind } => scalar(kind).map(|()| columns as u32 * rows as u32),
            TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
                let one = u64::from(self.size_of(base, span)?);
                u32::try_from(one * u64::from(count.get()))
                    .ok()
                    .filter(|size| *size as usize <= MAX_SLOTS)
                    .ok_or_else(|| fault(span, format!("An array of more than {MAX_SLOTS} numbers is too large.")))
            }
            TypeInner::Struct { ref members, .. } => {
                let mut size = 0_u32;
                for member in members {
                    size = size.saturating_add(self.size_of(member.ty, span)?);
                }
                Ok(size)
            }
            _ => Err(fault(span, "A field has numbers, vectors, matrices, structures and arrays of a fixed size.")),
        }
    }

    pub(super) fn size_of(&self, ty: Handle<Type>, span: Span) -> Result<u32, CodeDiagnostic> {
        self.size(&self.module.types[ty].inner, span)
    }

    pub(super) fn shape(&self, body: &Body, expression: Handle<Expression>) -> Option<Shape> {
        shape(self.inner(body, expression))
    }

    /// Type of a value, or of a pointer's target.
    pub(super) fn pointee(&self, body: &Body, expression: Handle<Expression>) -> TypeInner {
        match self.inner(body, expression) {
            TypeInner::Pointer { base, .. } => self.module.types[*base].inner.clone(),
            TypeInner::ValuePointer { size: Some(size), scalar, .. } => {
                TypeInner::Vector { size: *size, scalar: *scalar }
            }
            inner => inner.clone(),
        }
    }

    /// Offset and size of an element, and the number of elements.
    pub(super) fn element(&self, inner: &TypeInner, index: u32, span: Span) -> Result<(u32, u32, u32), CodeDiagnostic> {
        Ok(match inner {
            TypeInner::Vector { size, .. } => (index.min(*size as u32 - 1), 1, *size as u32),
            TypeInner::Matrix { columns, rows, .. } => {
                (index.min(*columns as u32 - 1) * *rows as u32, *rows as u32, *columns as u32)
            }
            TypeInner::Array { base, size: ArraySize::Constant(count), .. } => {
                let size = self.size_of(*base, span)?;
                (index.min(count.get() - 1) * size, size, count.get())
            }
            TypeInner::Struct { members, .. } => {
                let mut offset = 0;
                for member in &members[..index as usize] {
                    offset += self.size_of(member.ty, span)?;
                }
                (offset, 1, 1)
            }
            _ => return Err(fault(span, "A field only computes with numbers: this is not for it.")),
        })
    }
}

/// Shape of a scalar, a vector or a matrix.
fn shape(inner: &TypeInner) -> Option<Shape> {
    let (scalar, rows, columns) = match *inner {
        TypeInner::Scalar(scalar) => (scalar, 1, 1),
        TypeInner::Vector { size, scalar } => (scalar, size as u32, 1),
        TypeInner::Matrix { columns, rows, scalar } => (scalar, rows as u32, columns as u32),
        _ => return None,
    };
    Some(Shape { kind: scalar.kind, rows, columns })
}
