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

    /// Reads the rows of a table that an earlier run has saved; none if there is no such file or its header differs.
    pub fn saved_rows(&self, directory: &Path, name: &str) -> Vec<Vec<String>> {
        let Ok(mut reader) = csv::Reader::from_path(directory.join(format!("{name}.csv"))) else { return Vec::new() };
        if reader.headers().is_ok_and(|heads| heads.iter().eq(&self.heads)) {
            let rows = reader.records().flatten();
            rows.map(|row| row.iter().map(str::to_owned).collect()).collect()
        } else {
            Vec::new()
        }
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

    /// Rows whose ratio in a column is below one, each as "label (ratio)", separated by commas; `None` if there are none.
    pub fn losses(&self, head: &str, label: usize) -> Option<String> {
        let column = self.heads.iter().position(|other| other == head)?;
        let is_lost = |row: &&Vec<String>| row[column].parse().is_ok_and(|ratio: f64| ratio < 1.0);
        let lost = self.rows.iter().filter(is_lost).map(|row| format!("{} ({})", row[label], row[column]));
        Some(lost.collect::<Vec<_>>().join(", ")).filter(|text| !text.is_empty())
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
