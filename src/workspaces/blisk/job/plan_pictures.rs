//! Draws the pictures of a plan for its report.

use std::time::Instant;

use super::outcome::{PlanInputs, PlanOutcome};
use crate::widgets::camera::PICTURE_SIZE;
use crate::workspaces::blisk::report::{Report, StageTime};
use crate::workspaces::blisk::scene::pictures::{PlanPicture, PlanToShow, plan_pictures};
use files::report::Picture;
use render::offscreen::{Offscreen, RenderError, png_bytes};
use task::{Cancelled, Task};

/// Puts the pictures of `outcome` into `report`, or the reason why there are none: a plan is good without them.
///
/// # Errors
/// [`Cancelled`], which is looked at while pictures are drawn.
pub fn add(report: &mut Report, outcome: &PlanOutcome, inputs: &PlanInputs, task: &Task) -> Result<(), Cancelled> {
    let started = Instant::now();
    task.check()?;
    if !inputs.job.export.draws_any() {
        return Ok(());
    }
    match draw(outcome, inputs, task) {
        Ok(pictures) => report.pictures = pictures,
        Err(RenderError::Cancelled(cancelled)) => return Err(cancelled),
        Err(error) => report.no_pictures = Some(error.to_string()),
    }
    report.times.push(StageTime { stage: "pictures".to_owned(), seconds: started.elapsed().as_secs_f64() });
    Ok(())
}

fn draw(outcome: &PlanOutcome, inputs: &PlanInputs, task: &Task) -> Result<Vec<Picture>, RenderError> {
    task.report("pictures", 0.0, "");
    let plan = PlanToShow {
        blisk: &inputs.blisk,
        channel: &outcome.channel,
        electrodes: outcome.electrodes.iter().map(|e| (&e.electrode, &e.plan)).collect(),
        residual_stock: outcome.residual_stock().map(|left| &**left),
        measured: outcome.measured.as_deref(),
        spark_gap: inputs.job.electrode.of_last_stage().spark_gap_mm,
    };
    let (pictures, offscreen) = rayon::join(|| plan_pictures(&plan, &inputs.job.export.pictures, task), Offscreen::new);
    let (pictures, mut offscreen) = (pictures?, offscreen?);
    // One is compressed while the next is drawn.
    let mut drawn: Vec<Result<Vec<u8>, RenderError>> = pictures.iter().map(|_| Ok(Vec::new())).collect();
    rayon::in_place_scope(|scope| {
        for (i, (picture, png)) in pictures.iter().zip(&mut drawn).enumerate() {
            task.check()?;
            task.report("pictures", i as f64 / pictures.len() as f64, &picture.title);
            let image = offscreen.image_until(&picture.scene, &picture.camera, PICTURE_SIZE, &task.cancel)?;
            scope.spawn(move |_| *png = png_bytes(&image, &task.cancel));
        }
        Ok::<(), RenderError>(())
    })?;
    pictures.into_iter().zip(drawn).map(|(picture, png)| Ok(finished(picture, png?))).collect()
}

/// Draws one picture.
///
/// # Errors
/// [`RenderError`], if nothing can be drawn here, or the task is cancelled.
pub fn drawn(picture: PlanPicture, task: &Task) -> Result<Picture, RenderError> {
    let png = Offscreen::new()?.png(&picture.scene, &picture.camera, PICTURE_SIZE, &task.cancel)?;
    Ok(finished(picture, png))
}

fn finished(picture: PlanPicture, png: Vec<u8>) -> Picture {
    let legend = picture.legend.into_iter();
    Picture {
        file: picture.file,
        title: picture.title,
        caption: picture.caption,
        legend: legend.map(|(c, what)| (format!("#{:02x}{:02x}{:02x}", c.r, c.g, c.b), what.to_owned())).collect(),
        png,
    }
}
