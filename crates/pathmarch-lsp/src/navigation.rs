//! Symbols, and go to definition.

use crate::files::uri_of;
use crate::positions::Lines;
use lsp_types::{DocumentSymbol, Location, Position, SymbolKind as Kind, Uri};
use pathmarch_scene::language_service::{OpenText, Symbol, SymbolKind};

/// Outline of a document.
pub(crate) fn symbols(open: &OpenText) -> Vec<DocumentSymbol> {
    let lines = Lines::new(open.text());
    // The field that the compiler warns of has a successor, but no default.
    #[allow(deprecated)]
    let symbol = |symbol: Symbol| DocumentSymbol {
        name: symbol.name,
        detail: Some(symbol.detail),
        kind: kind(symbol.kind),
        range: lines.range(symbol.range),
        selection_range: lines.range(symbol.name_range),
        tags: None,
        deprecated: None,
        children: None,
    };
    open.symbols().into_iter().map(symbol).collect()
}

fn kind(kind: SymbolKind) -> Kind {
    match kind {
        SymbolKind::Camera => Kind::INTERFACE,
        SymbolKind::Light => Kind::EVENT,
        SymbolKind::Material => Kind::CONSTANT,
        SymbolKind::Object => Kind::OBJECT,
        SymbolKind::Shape => Kind::CLASS,
        SymbolKind::Field => Kind::FUNCTION,
        SymbolKind::Parameter => Kind::VARIABLE,
        SymbolKind::Include => Kind::FILE,
        SymbolKind::Settings => Kind::MODULE,
    }
}

/// Where the name at a position is declared.
pub(crate) fn definition(uri: &Uri, open: &OpenText, position: Position) -> Option<Location> {
    let lines = Lines::new(open.text());
    let found = open.definition(lines.byte(position))?;
    Some(match found.file {
        None => Location::new(uri.clone(), lines.range(found.range)),
        Some((path, text)) => Location::new(uri_of(&path)?, Lines::new(&text).range(found.range)),
    })
}
