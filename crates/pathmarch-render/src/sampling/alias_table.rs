//! Alias tables: sampling of a discrete distribution, in constant time (Walker 1977, "An Efficient Method for Generating
//! Discrete PixelSampler Variables with General Distributions"; Vose 1991, "A Linear Algorithm for Generating PixelSampler BsdfParameters
//! with a Given Distribution").

/// Cell: the share of it that is the cell's own index, and the index that has the rest.
pub(crate) type Cell = (f32, u32);

/// Alias table of these weights; uniform where all are zero.
pub(crate) fn table(weights: &[f64]) -> Vec<Cell> {
    let total: f64 = weights.iter().sum();
    let mut table: Vec<Cell> = (0..weights.len() as u32).map(|k| (1.0, k)).collect();
    if total <= 0.0 {
        return table;
    }
    let mut shares: Vec<f64> = weights.iter().map(|w| w / total * weights.len() as f64).collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..shares.len()).partition(|&k| shares[k] < 1.0);
    while let (Some(&low), Some(&high)) = (small.last(), large.last()) {
        small.pop();
        table[low] = (shares[low] as f32, high as u32);
        shares[high] -= 1.0 - shares[low];
        if shares[high] < 1.0 {
            large.pop();
            small.push(high);
        }
    }
    table
}

/// Samples a cell with a uniform number; returns the cell and the number stretched to 0..1 again.
pub(crate) fn draw(table: &[Cell], u: f32) -> (usize, f32) {
    let place = u * table.len() as f32;
    let cell = (place as usize).min(table.len() - 1);
    let rest = place - cell as f32;
    let (threshold, alias) = table[cell];
    let (cell, rest) = if rest < threshold {
        (cell, rest / threshold)
    } else {
        (alias as usize, (rest - threshold) / (1.0 - threshold))
    };
    (cell, rest.clamp(0.0, 1.0))
}
