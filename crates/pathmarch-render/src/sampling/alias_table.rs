//! Alias tables: sampling of a discrete distribution in constant time (Walker 1977, "An Efficient Method for Generating
//! Discrete Random Variables with General Distributions"; Vose 1991, "A Linear Algorithm for Generating Random Numbers
//! with a Given Distribution").

/// Cell of an alias table: the probability of its own index, and the alias that has the remaining probability.
pub(crate) type Cell = (f32, u32);

/// Builds the alias table of these weights; uniform if all are zero.
pub(crate) fn table(weights: &[f64]) -> Vec<Cell> {
    let total: f64 = weights.iter().sum();
    let mut table: Vec<Cell> = (0..weights.len() as u32).map(|k| (1.0, k)).collect();
    if total <= 0.0 {
        return table;
    }
    let mut scaled: Vec<f64> = weights.iter().map(|w| w / total * weights.len() as f64).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..scaled.len()).partition(|&k| scaled[k] < 1.0);
    while let (Some(&low), Some(&high)) = (small.last(), large.last()) {
        small.pop();
        table[low] = (scaled[low] as f32, high as u32);
        scaled[high] -= 1.0 - scaled[low];
        if scaled[high] < 1.0 {
            large.pop();
            small.push(high);
        }
    }
    table
}

/// Samples an index with a uniform number. Returns the index and the number remapped to 0..1.
pub(crate) fn sample(table: &[Cell], u: f32) -> (usize, f32) {
    let scaled = u * table.len() as f32;
    let cell = (scaled as usize).min(table.len() - 1);
    let remapped = scaled - cell as f32;
    let (threshold, alias) = table[cell];
    let (cell, remapped) = if remapped < threshold {
        (cell, remapped / threshold)
    } else {
        (alias as usize, (remapped - threshold) / (1.0 - threshold))
    };
    (cell, remapped.clamp(0.0, 1.0))
}
