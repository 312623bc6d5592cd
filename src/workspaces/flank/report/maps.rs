//! Pictures of deviations over the surface for a report.

use image::{Rgba, RgbaImage};

use crate::workspaces::flank::report::DeviationMaps;
use files::report::Picture;
use flank::deviation::Deviation;
use flank::plan::{FlankPlan, WITHIN_ROUNDING};
use render::colour_map::ColourMap;
use render::offscreen::{RenderError, png_bytes};
use task::Cancel;

/// The most pixels of a map, across and up.
const MOST_PIXELS: [usize; 2] = [400, 200];
/// The least deviation (mm) at the end of the scale: what is less is rounding.
const LEAST_MM: f64 = 1e-6;
/// Pixels of the bar of colours.
const BAR_PIXELS: u32 = 256;

/// Maps of the three paths of `plan` with one scale, symmetric about zero.
///
/// # Errors
/// Cancelled, or the PNG encoder's own.
pub fn deviation_maps(plan: &FlankPlan, cancel: &Cancel) -> Result<DeviationMaps, RenderError> {
    let greatest = |d: &Deviation| d.most_undercut.max(-d.most_overcut).max(0.0);
    let end_mm = plan.paths().iter().map(|(_, path)| greatest(&path.deviation)).fold(LEAST_MM, f64::max);
    let map = |name: &str, deviation: &Deviation| {
        let share = plan.share(deviation.sum);
        let share = share.map_or_else(|| WITHIN_ROUNDING.to_owned(), |share| format!("{share:.3} of the initial"));
        let caption = format!(
            "sum {:.3} mm, {share}; overcut up to {:.1} \u{b5}m, undercut up to {:.1} \u{b5}m",
            deviation.sum,
            1e3 * (-deviation.most_overcut).max(0.0),
            1e3 * deviation.most_undercut.max(0.0)
        );
        let png = png_bytes(&picture(deviation, end_mm), cancel)?;
        let (title, file, legend) = (name.to_owned(), String::new(), Vec::new());
        Ok::<_, RenderError>(Picture { file, title, caption, legend, png })
    };
    let maps = plan.paths().map(|(name, path)| map(name, &path.deviation));
    let maps = maps.into_iter().collect::<Result<Vec<_>, _>>()?;
    let bar = RgbaImage::from_fn(BAR_PIXELS, 1, |x, _| colour(f64::from(x) / f64::from(BAR_PIXELS - 1)));
    Ok(DeviationMaps { maps, bar_png: png_bytes(&bar, cancel)?, end_mm })
}

fn colour(share: f64) -> Rgba<u8> {
    let colour = ColourMap::Diverging.at(share);
    Rgba([colour.r, colour.g, colour.b, 255])
}

/// u to the right and v upwards; a pixel that stands for several places has the colour of the worst of them.
fn picture(deviation: &Deviation, end_mm: f64) -> RgbaImage {
    let [nu, nv] = deviation.grid;
    let [width, height] = [nu.min(MOST_PIXELS[0]), nv.min(MOST_PIXELS[1])];
    RgbaImage::from_fn(width as u32, height as u32, |x, y| {
        let (x, y) = (x as usize, height - 1 - y as usize);
        let across = x * nu / width..((x + 1) * nu / width);
        let up = y * nv / height..((y + 1) * nv / height);
        let values = across.flat_map(|i| up.clone().filter_map(move |j| deviation.at(i, j)));
        let worst = values.fold(0.0, |worst: f64, v| if v.abs() > worst.abs() { v } else { worst });
        colour(0.5 + 0.5 * (worst / end_mm))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_shows_undercut_red_overcut_blue_and_the_lower_guide_below() {
        // Two places along u, three along v: undercut at the lower guide's start, overcut at the upper guide's end.
        let values = vec![1.0, 0.0, 0.0, 0.0, 0.0, -1.0];
        let image = picture(&Deviation::of([2, 3], values), 1.0);
        assert_eq!(image.dimensions(), (2, 3));
        let [r, _, b, _] = image.get_pixel(0, 2).0;
        assert!(r > b + 60, "red at the lower left");
        let [r, _, b, _] = image.get_pixel(1, 0).0;
        assert!(b > r + 60, "blue at the upper right");
        let middle = image.get_pixel(0, 0).0;
        assert!(middle[..3].iter().all(|c| *c > 200), "light where nothing is off");
    }

    #[test]
    fn a_fine_grid_keeps_its_worst_place() {
        let mut values = vec![0.0; 1000 * 500];
        values[777 * 500 + 123] = -2.0;
        let image = picture(&Deviation::of([1000, 500], values), 2.0);
        assert_eq!(image.dimensions(), (400, 200));
        assert_eq!(image.pixels().filter(|p| **p == colour(0.0)).count(), 1);
    }
}
