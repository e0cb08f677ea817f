//! `glimt compare`: how far two pictures are apart.

use super::args::{ColorArg, codes};
use super::{Failure, print};
use crate::assets::load_image;
use crate::description::printable;
use crate::math::srgb8_to_linear;
use crate::output::{check_target, encode_png, write_whole};
use crate::render::Film;
use crate::study::metrics::{Difference, difference, error_map};
use crate::study::{Table, four_figures};
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub struct CompareArgs {
    /// A picture: PNG, JPEG, BMP or TGA
    pub a: PathBuf,
    /// Another of the same size
    pub b: PathBuf,
    /// Write a PNG of where they differ: black where equal, the brighter the more codes apart (log scale)
    #[arg(long, value_name = "PNG")]
    pub diff: Option<PathBuf>,
    /// Exit with 1 if the root mean square of the differences is more than this many 8-bit codes
    #[arg(long, value_name = "CODES", value_parser = codes, allow_negative_numbers = true)]
    pub max_rmse: Option<f64>,
    /// Print one JSON object on stdout
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub color: ColorArg,
}

/// 0: within `--max-rmse`, or none was given; 1: not.
pub fn compare(args: &CompareArgs) -> Result<ExitCode, Failure> {
    if let Some(file) = &args.diff {
        check_target(file).map_err(Failure::asked)?;
    }
    let (a, b) = (read(&args.a)?, read(&args.b)?);
    let Some(found) = difference(&a, &b) else {
        let size = |file: &Path, film: &Film| format!("{} is {}x{}", file.display(), film.width(), film.height());
        let (a, b) = (size(&args.a, &a), size(&args.b, &b));
        return Err(Failure::Asked(format!("only pictures of one size can be compared: {a}, {b}")));
    };
    if let Some(file) = &args.diff {
        let map = error_map(&a, &b);
        encode_png(a.width(), a.height(), &map).and_then(|png| write_whole(file, &png)).map_err(Failure::could_not)?;
    }
    if args.json {
        print(serde_json::to_string(&found).map_err(Failure::could_not)?)?;
    } else {
        print(shown(&found, &args.a, &args.b).to_string().trim_end())?;
    }
    let too_much = args.max_rmse.is_some_and(|most| found.rmse > most);
    Ok(ExitCode::from(u8::from(too_much)))
}

fn read(file: &Path) -> Result<Film, Failure> {
    let picture = load_image(file).map_err(Failure::asked)?;
    let linear = |codes: &[u8; 3]| codes.map(|code| srgb8_to_linear(code) as f32);
    Ok(Film::of_pixels(picture.width, picture.height, picture.texels.iter().map(linear).collect()))
}

fn shown(found: &Difference, a: &Path, b: &Path) -> Table {
    let name = |file: &Path| printable(&file.to_string_lossy()).into_owned();
    let mut table = Table::new(format!("{} against {}", name(a), name(b)), &["measure", "value", "unit"]);
    let psnr = if found.psnr.is_finite() { four_figures(found.psnr) } else { "infinite".to_owned() };
    let mut row = |name: &str, value: String, unit: &str| table.push([name.into(), value.into(), unit.into()]);
    row("RMSE", four_figures(found.rmse), "8-bit codes");
    row("RMSE, linear", four_figures(found.rmse_linear), "of white");
    row("PSNR", psnr, "dB");
    row("largest difference", four_figures(found.max), "8-bit codes");
    row("FLIP", four_figures(found.flip), "0: seen as equal, 1: as different as can be");
    table
}
