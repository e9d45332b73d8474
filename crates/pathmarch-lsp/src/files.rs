//! Files as the protocol names them.

use lsp_types::Uri;
use std::path::{Path, PathBuf};
use url::Url;

/// Path of a document; that of one that is no file is its URI.
pub(crate) fn path_of(uri: &Uri) -> String {
    let path = Url::parse(uri.as_str()).ok().and_then(|url| url.to_file_path().ok());
    path.map_or_else(|| uri.as_str().to_owned(), |path| path.display().to_string())
}

/// URI of a file; `None` if its path cannot be one.
pub(crate) fn uri_of(path: &Path) -> Option<Uri> {
    let path = std::path::absolute(path).ok()?;
    // Detours such as `a/../b` would make a second name of one file.
    let path: PathBuf = path.canonicalize().unwrap_or(path);
    Url::from_file_path(path).ok()?.as_str().parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn paths_come_back_from_uris() {
        let path = Path::new("/no where/ä#%.kdl");
        let uri = uri_of(path).expect("a uri");
        assert_eq!(uri.as_str(), "file:///no%20where/%C3%A4%23%25.kdl");
        assert_eq!(path_of(&uri), path.display().to_string());
        let untitled: Uri = "untitled:Untitled-1".parse().expect("a uri");
        assert_eq!(path_of(&untitled), "untitled:Untitled-1");
    }
}
