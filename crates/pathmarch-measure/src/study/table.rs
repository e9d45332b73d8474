//! Tables, written as Markdown and CSV.

use pathmarch_cli::Failure;
use std::path::Path;

/// Rows of cells with a header.
pub struct Table {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates an empty table.
    pub fn new(heads: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { heads: heads.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row; missing cells are empty.
    pub fn push(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        let mut row: Vec<String> = cells.into_iter().map(Into::into).collect();
        row.resize(self.heads.len(), String::new());
        self.rows.push(row);
    }

    /// The table as Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| {
            let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rule = format!("|{}\n", "---|".repeat(self.heads.len()));
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        line(&self.heads) + &rule + &rows
    }

    /// Writes the table as CSV.
    pub fn save(&self, directory: &Path, name: &str) -> Result<(), Failure> {
        let path = directory.join(format!("{name}.csv"));
        let failed = |error: csv::Error| Failure::Other(format!("{}: {error}", path.display()));
        let mut writer = csv::Writer::from_path(&path).map_err(failed)?;
        for row in std::iter::once(&self.heads).chain(&self.rows) {
            writer.write_record(row).map_err(failed)?;
        }
        writer.flush().map_err(|error| Failure::Other(format!("{}: {error}", path.display())))
    }
}

/// Formats milliseconds.
pub fn milliseconds(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| if value < 10.0 { format!("{value:.2}") } else { format!("{value:.0}") })
}
