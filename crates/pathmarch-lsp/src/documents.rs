//! Open documents, and the mistakes that were published for each file.

use crate::diagnostics::{ByFile, diagnostics};
use crate::files::path_of;
use crate::positions::Lines;
use lsp_types::{Diagnostic, TextDocumentContentChangeEvent, Uri};
use pathmarch_scene::language_service::OpenText;
use std::collections::{BTreeSet, HashMap};

/// An open document.
struct Document {
    uri: Uri,
    open: OpenText,
    /// Text that has not been read yet.
    pending: Option<String>,
    /// True if its mistakes have not been published since the last reading.
    is_new: bool,
    /// Mistakes of the document and of the files that it includes.
    found: ByFile,
}

impl Document {
    fn text(&self) -> &str {
        self.pending.as_deref().unwrap_or(self.open.text())
    }
    fn change(&mut self, change: TextDocumentContentChangeEvent) {
        let text = match change.range {
            None => change.text,
            Some(range) => {
                let text = self.text();
                let bytes = Lines::new(text).bytes(range);
                format!("{}{}{}", &text[..bytes.start], change.text, &text[bytes.end..])
            }
        };
        self.pending = Some(text);
        self.is_new = true;
    }
    /// Reads the text, if it has changed.
    fn read(&mut self) -> &mut OpenText {
        if let Some(text) = self.pending.take() {
            self.open.set_text(text);
        }
        &mut self.open
    }
}

/// All open documents, by their URI.
#[derive(Default)]
pub(crate) struct Documents {
    all: HashMap<String, Document>,
    /// Files that have published mistakes.
    published: BTreeSet<String>,
}

impl Documents {
    pub(crate) fn open(&mut self, uri: Uri, text: String, allow_files: bool) {
        let open = OpenText::new(path_of(&uri), text, allow_files);
        let document = Document { uri: uri.clone(), open, pending: None, is_new: true, found: ByFile::default() };
        self.all.insert(uri.as_str().to_owned(), document);
    }
    pub(crate) fn close(&mut self, uri: &Uri) {
        self.all.remove(uri.as_str());
    }
    pub(crate) fn change(&mut self, uri: &Uri, changes: Vec<TextDocumentContentChangeEvent>) {
        if let Some(document) = self.all.get_mut(uri.as_str()) {
            changes.into_iter().for_each(|change| document.change(change));
        }
    }
    /// Reads every document again, because a file has changed on the disk.
    pub(crate) fn refresh(&mut self) {
        for document in self.all.values_mut() {
            document.read().refresh();
            document.is_new = true;
        }
    }
    /// The document of this URI, up to date.
    pub(crate) fn get(&mut self, uri: &Uri) -> Option<&mut OpenText> {
        self.all.get_mut(uri.as_str()).map(Document::read)
    }

    /// Mistakes of each file that has other ones than those published last. A file that several documents include has the
    /// mistakes of all.
    pub(crate) fn news(&mut self) -> Vec<(Uri, Vec<Diagnostic>)> {
        let mut touched = BTreeSet::new();
        for document in self.all.values_mut().filter(|document| document.is_new) {
            document.is_new = false;
            document.read();
            touched.extend(document.found.keys().cloned());
            document.found = diagnostics(&document.uri, &document.open);
            touched.extend(document.found.keys().cloned());
        }
        // Those of closed documents.
        let known: BTreeSet<&String> = self.all.values().flat_map(|document| document.found.keys()).collect();
        touched.extend(self.published.iter().filter(|file| !known.contains(file)).cloned());
        let news: Vec<(Uri, Vec<Diagnostic>)> =
            touched.iter().filter_map(|file| Some((file.parse().ok()?, self.found(file)))).collect();
        self.published.retain(|file| !touched.contains(file));
        self.published.extend(news.iter().filter(|(_, list)| !list.is_empty()).map(|(uri, _)| uri.as_str().to_owned()));
        news
    }

    fn found(&self, file: &str) -> Vec<Diagnostic> {
        let mut all: Vec<Diagnostic> = Vec::new();
        for diagnostic in self.all.values().filter_map(|document| document.found.get(file)).flatten() {
            if !all.contains(diagnostic) {
                all.push(diagnostic.clone());
            }
        }
        all
    }
}
