//! What became of a step, in one sentence for the log.

use super::{EventKind, Exported, Finished, Planned};
use crate::workspaces::blisk::job::stages::{Electrodes, FoundChannel, Part};

pub(super) fn part_sentence(part: &Part) -> (EventKind, String) {
    (EventKind::Done, format!("{}: {} triangles", part.name, part.mesh.triangles.len()))
}

pub(super) fn channel_sentence(found: &FoundChannel) -> (EventKind, String) {
    let channel = &found.channel;
    let text = format!("{} blades, throat {:.2} mm", channel.blades, channel.throat.width_mm);
    (EventKind::Done, text)
}

pub(super) fn electrode_sentence(made: &Electrodes) -> (EventKind, String) {
    let thinnest = made.electrodes.iter().map(|e| e.least_thickness_mm).fold(f64::INFINITY, f64::min);
    let count = made.electrodes.len();
    let plural = if count == 1 { "" } else { "s" };
    (EventKind::Done, format!("{count} electrode{plural}, least thickness {thinnest:.2} mm"))
}

pub(super) fn plan_sentence(planned: &Planned) -> (EventKind, String) {
    let plan = &planned.outcome;
    let kind = if plan.may_be_approved() { EventKind::Done } else { EventKind::Refused };
    // The first electrode that is not verified is what stands in the way.
    let told = plan.electrodes.iter().enumerate().find(|(_, e)| !e.plan.is_verified());
    let (i, electrode) = match told.or_else(|| plan.electrodes.iter().enumerate().next()) {
        Some(found) => found,
        None => return (EventKind::Refused, "there is no electrode".to_owned()),
    };
    let name = if plan.electrodes.len() > 1 { format!("electrode {} ", i + 1) } else { "the electrode ".to_owned() };
    let collision = plan.finishing().and_then(|f| f.collision());
    let collision = collision.map(|simulation| format!(". {}", simulation.sentence())).unwrap_or_default();
    (kind, name + &electrode.plan.verdict(&plan.channel) + &collision)
}

pub(super) fn finish_sentence(finished: &Finished) -> (EventKind, String) {
    match &finished.said {
        Ok(left) => (EventKind::Done, left.clone()),
        Err(why) => (EventKind::Refused, why.clone()),
    }
}

pub(super) fn export_sentence(exported: &Exported) -> (EventKind, String) {
    (EventKind::Done, format!("{} files written to {}", exported.written.len(), exported.folder.display()))
}
