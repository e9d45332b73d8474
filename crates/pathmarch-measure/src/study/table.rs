//! A table, as Markdown for people and as CSV for programs.

use pathmarch_cli::Failure;
use std::path::Path;

/// Rows of cells below their heads.
pub struct Table {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Without rows.
    pub fn new(heads: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { heads: heads.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// Adds a row; cells that are missing are empty.
    pub fn push(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        let mut row: Vec<String> = cells.into_iter().map(Into::into).collect();
        row.resize(self.heads.len(), String::new());
        self.rows.push(row);
    }

    /// As Markdown.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| {
            let cells: Vec<_> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let rule = format!("|{}\n", "---|".repeat(self.heads.len()));
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        line(&self.heads) + &rule + &rows
    }

    /// Writes it as CSV.
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

/// A number of milliseconds for a table.
pub fn milliseconds(value: Option<f64>) -> String {
    value.map_or("-".to_owned(), |value| if value < 10.0 { format!("{value:.2}") } else { format!("{value:.0}") })
}
