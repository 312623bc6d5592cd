//! Draws the pictures of a plan for its report.

use std::time::Instant;

use super::outcome::{PlanInputs, PlanOutcome};
use crate::widgets::camera::PICTURE_SIZE;
use crate::workspaces::blisk::report::{Report, StageTime};
use crate::workspaces::blisk::scene::pictures::{PlanPicture, PlanToShow, plan_pictures};
use files::report::Picture;
use render::offscreen::{Offscreen, RenderError};
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
    let mut offscreen = Offscreen::new()?;
    let plan = PlanToShow {
        blisk: &inputs.blisk,
        channel: &outcome.channel,
        electrodes: outcome.electrodes.iter().map(|e| (&e.electrode, &e.plan)).collect(),
        residual_stock: outcome.residual_stock().map(|left| &**left),
        spark_gap: inputs.job.electrode.spark_gap_mm,
    };
    let pictures = plan_pictures(&plan, &inputs.job.export.pictures, task)?;
    let count = pictures.len();
    let mut drawn = Vec::with_capacity(count);
    for (i, picture) in pictures.into_iter().enumerate() {
        task.check()?;
        task.report("pictures", i as f64 / count as f64, &picture.title);
        let png = offscreen.png(&picture.scene, &picture.camera, PICTURE_SIZE, &task.cancel)?;
        drawn.push(finished(picture, png));
    }
    Ok(drawn)
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
