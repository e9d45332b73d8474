//! `pathmarch compare`: error of a picture against a reference.

use pathmarch_cli::{DONE, FAILED, Failure, note, outln};
use pathmarch_render::image;
use pathmarch_render::metrics::compare;
use serde_json::json;
use std::path::PathBuf;

#[derive(clap::Args)]
pub struct Arguments {
    /// Picture to measure
    picture: PathBuf,
    /// Reference picture
    reference: PathBuf,
    /// Fail (exit code 1) if relMSE is above this
    #[arg(long, value_name = "X", value_parser = parse_limit, allow_hyphen_values = true)]
    max_relmse: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

fn parse_limit(text: &str) -> Result<f64, String> {
    let limit = text.trim().parse().ok().filter(|limit: &f64| *limit >= 0.0 && limit.is_finite());
    limit.ok_or_else(|| "must be a finite number, 0 or more".to_owned())
}

pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let a = image::load(&arguments.picture).map_err(Failure::other)?;
    let b = image::load(&arguments.reference).map_err(Failure::other)?;
    if a.kind != b.kind {
        return Err(Failure::Usage(
            "one picture contains radiance (EXR), the other is tone-mapped (PNG, JPEG); compare two of the same kind"
                .to_owned(),
        ));
    }
    let result = compare(&a.picture, &b.picture, a.kind).map_err(Failure::other)?;
    if arguments.json {
        outln!(
            "{}",
            json!({
                "size": [result.width, result.height],
                "relmse": result.relmse,
                "mse": result.mse,
                "flip": result.flip,
                "mean": result.image_mean,
                "reference_mean": result.reference_mean,
            })
        );
    } else {
        let colour = |c: [f64; 3]| format!("{:.5} {:.5} {:.5}", c[0], c[1], c[2]);
        outln!("size       {}x{}", result.width, result.height);
        outln!("relMSE     {:.3e}", result.relmse);
        outln!("MSE        {:.3e}", result.mse);
        outln!("FLIP       {:.5}", result.flip);
        outln!("mean       {}  {}", colour(result.image_mean), arguments.picture.display());
        outln!("mean       {}  {}", colour(result.reference_mean), arguments.reference.display());
    }
    let mut code = DONE;
    for (count, path) in
        [(result.image_non_finite, &arguments.picture), (result.reference_non_finite, &arguments.reference)]
    {
        if count > 0 {
            note!("pathmarch: {}: {count} non-finite pixels were ignored", path.display());
            code = FAILED;
        }
    }
    if let Some(limit) = arguments.max_relmse.filter(|limit| result.relmse.is_nan() || result.relmse > *limit) {
        note!("pathmarch: relMSE {:.3e} is above {limit:.3e}", result.relmse);
        code = FAILED;
    }
    Ok(code)
}
