//! Facts about a step, below its form, with the button for the next action.

use crate::workspaces::blisk::commands::BliskCommand;
use crate::workspaces::blisk::desk::BliskDesk;
use crate::workspaces::commands::FrameCommand;
use crate::workspaces::context::Context;
use egui::{RichText, Ui};

use super::stepper::Standing;
use crate::widgets::panel_parts::grouped;
use crate::widgets::panel_parts::{fact, notice, sentence};
use crate::widgets::solids::solids;
use crate::widgets::theme::palette;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::stage::Stage;
use crate::workspaces::blisk::job::outcome::PlanOutcome;
use crate::workspaces::blisk::job::simulate;
use feed::plan_params::Strategy;
use feed::residual_stock::ResidualStock;
use task::State;
use wheel::channel::Channel;
use wheel::electrode::EntrySide;

/// Draws them.
pub fn show(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, stage: Stage) {
    match stage {
        Stage::Part => part(ui, desk, cx),
        Stage::Channel => channel(ui, desk, cx),
        Stage::Electrode => electrode(ui, desk, cx),
        Stage::Plan => plan(ui, desk, cx),
        Stage::Verify => {
            verify(ui, desk, cx);
            super::scan::show(ui, desk, cx);
        }
        Stage::Export => export(ui, desk, cx),
    }
}

fn next(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, stage: Stage) {
    ui.add_space(8.0);
    let text = format!("Go on to {}", stage.name());
    cx.button(ui, desk, BliskCommand::Step(stage), &text, true);
}

fn part(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    ui.horizontal(|ui| {
        cx.button(ui, desk, FrameCommand::Open, "Open…", desk.work.part().is_none());
        cx.button(ui, desk, BliskCommand::NewDemonstration, "Demonstration", false);
    });
    ui.add_space(4.0);
    let Some(part) = desk.work.part().cloned() else { return };
    let length = cx.preferences.length;
    fact(ui, "File", &part.name);
    fact(ui, "Triangles", grouped(part.mesh.triangles.len()));
    let size = part.shape.bounds().size();
    for (axis, extent) in ["Size along X", "Size along Y", "Size along Z"].into_iter().zip(size.to_array()) {
        fact(ui, axis, length.show(extent, 2));
    }
    if let Some(report) = &part.report {
        fact(ui, "Unit", report.unit.name());
        fact(ui, "Surface", if report.watertight { "watertight" } else { "open" });
        ui.add(egui::Label::new(RichText::new(&report.unit_reason).small().color(palette(ui).faint)).wrap());
        if let Some(chosen) = solids(ui, &report.solids) {
            let mut job = desk.document.params().clone();
            (job.blisk.reading.solids, job.blisk.reading.obstacles) = (chosen.part, chosen.obstacles);
            desk.edit("solids of the part", job, false);
        }
        if let Some(tolerance) = report.step_tolerance_mm {
            fact(ui, "Off the exact faces", format!("{tolerance} mm at most"));
        }
        for warning in &report.warnings {
            notice(ui, palette(ui).warning, warning);
        }
    }
    if desk.work.state(Stage::Part) == State::Ready {
        next(ui, desk, cx, Stage::Channel);
    }
}

fn channel(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    if !super::picks::come_first(desk) {
        super::picks::show(ui, desk, cx);
    }
    let Some(found) = desk.work.channel().cloned() else { return };
    if matches!(desk.work.state(Stage::Channel), State::Failed(_)) {
        return;
    }
    let (channel, length) = (&found.channel, cx.preferences.length);
    let ([low, high], middle) = (channel.span_x(), channel.middle());
    fact(ui, "Blades", channel.blades.to_string());
    fact(ui, "Channel", format!("{} (0 to {})", channel.index, channel.blades - 1));
    fact(ui, "Passage", channel.flow.name().to_owned());
    fact(ui, "Throat", length.show(channel.throat.width_mm, 3));
    fact(ui, "Turning", format!("{:.1} deg", channel.turning.to_degrees()));
    fact(ui, "Hub radius, middle", length.show(middle.hub.y, 2));
    fact(
        ui,
        if channel.shrouded { "Shroud radius, middle" } else { "Tip radius, middle" },
        length.show(middle.shroud.y, 2),
    );
    fact(ui, "Blades along X", length.show(high - low, 2));
    let agreement = channel.agreement.iter().map(|a| a.share).fold(1.0, f64::min);
    fact(ui, "Agrees with the mesh", format!("{:.1} % at least", 100.0 * agreement));
    super::meridian::show(ui, channel);
    measured(ui, desk, cx);
    for assumed in &channel.assumed {
        notice(ui, palette(ui).faint, assumed);
    }
    if desk.work.state(Stage::Channel) == State::Ready {
        next(ui, desk, cx, Stage::Electrode);
    }
}

/// What the measured sections that the part was made from are off the walls of the channel.
fn measured(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    let Some((walls, _)) = desk.measured() else { return };
    let colour = if walls.holds() { palette(ui).good } else { palette(ui).warning };
    notice(ui, colour, &walls.sentence());
    let text = if desk.deviations { "Show the electrode" } else { "Show the deviations" };
    cx.button(ui, desk, BliskCommand::Deviations, text, false);
}

fn electrode(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    super::sizes::live(ui, desk);
    // Figures of what was made before would pass for those of what could not be made.
    if matches!(desk.work.state(Stage::Electrode), State::Failed(_)) {
        return;
    }
    let length = cx.preferences.length;
    let told = desk.reported_electrodes();
    for (i, electrode) in told.iter().enumerate() {
        if told.len() > 1 {
            ui.strong(format!("Electrode {}", electrode.label(i)));
        }
        fact(ui, "Enters from", electrode.enters_from.label());
        fact(ui, "Least thickness", length.show(electrode.least_thickness_mm, 3));
        fact(ui, "Clearance in the final pose", length.show(electrode.clearance_mm, 4));
        fact(ui, "Volume", format!("{:.1} mm³", electrode.volume_mm3));
        fact(ui, "Burn area", format!("{:.1} mm²", electrode.burn_area_mm2));
        for assumed in &electrode.assumed {
            notice(ui, palette(ui).faint, assumed);
        }
    }
    if desk.work.state(Stage::Electrode) == State::Ready {
        ui.add_space(4.0);
        cx.button(ui, desk, BliskCommand::MillFlanks, "Mill its flanks", false);
        next(ui, desk, cx, Stage::Plan);
    }
    super::sizes::show(ui, desk);
    super::sets::show(ui, desk);
}

fn plan(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    let running = desk.work.state(Stage::Plan) == State::Running;
    ui.horizontal(|ui| {
        if running {
            cx.button(ui, desk, FrameCommand::Cancel, "Cancel", false);
        } else {
            let text = if desk.work.plan().is_some() { "Plan again" } else { "Plan feed path" };
            let is_next = desk.work.state(Stage::Plan) != State::Ready;
            cx.button(ui, desk, BliskCommand::Plan, text, is_next);
        }
    });
    ui.add_space(4.0);
    if running {
        let nodes = desk.work.partial_plan().map_or(&[][..], |partial| &partial.nodes);
        fact(ui, "Nodes so far", nodes.len().to_string());
        fact(ui, "Retracted", cx.preferences.length.show(nodes.last().map_or(0.0, |n| n.s), 2));
        return;
    }
    super::sizes::live(ui, desk);
    weights(ui, desk);
    let Some(plan) = desk.work.plan().cloned() else { return };
    for (i, outcome) in plan.electrodes.iter().enumerate() {
        let colour = match Standing::of(desk, Stage::Plan) {
            Standing::Done => palette(ui).good,
            Standing::Working => palette(ui).accent,
            Standing::Stale | Standing::Unchecked => palette(ui).warning,
            // The feed may be good where the machine's motion about it is not.
            _ if outcome.plan.is_verified() => palette(ui).warning,
            _ => palette(ui).bad,
        };
        let name = if plan.electrodes.len() > 1 {
            format!("Electrode {}: ", outcome.electrode.label(i))
        } else {
            String::new()
        };
        // A plan that failed says so above the form.
        if outcome.plan.path.is_some() {
            notice(ui, colour, &(name + &FIELDS.labelled(&outcome.plan.verdict(&plan.channel))));
        }
        fact(ui, "Nodes", outcome.plan.nodes.len().to_string());
        if outcome.plan.rounds == 0 {
            fact(ui, "Found", "opened with the project; verified again");
            continue;
        }
        fact(ui, "Searches", outcome.plan.rounds.to_string());
        if outcome.plan.repairs > 0 {
            fact(ui, "Path repairs", format!("{} times", outcome.plan.repairs));
        }
        fact(ui, "Points tested", outcome.plan.probes.to_string());
        fact(ui, "Search", format!("{:.1} s", outcome.plan.search_seconds));
        for (side, why) in &outcome.tried {
            ui.label(RichText::new(format!("From {}: {why}", side.label())).small().color(palette(ui).faint));
        }
    }
    if plan.is_verified() && desk.work.state(Stage::Plan) == State::Ready {
        ui.add_space(4.0);
        cx.button(ui, desk, BliskCommand::Keep, "Keep for comparison", false);
        next(ui, desk, cx, Stage::Verify);
    }
}

/// The weights as the genetic search uses them: scaled to sum 1 in each group, over the axes that move.
fn weights(ui: &mut Ui, desk: &BliskDesk) {
    let job = desk.document.params();
    if job.plan.strategy != Strategy::Genetic {
        return;
    }
    let side = desk.shown_electrode().map_or(EntrySide::PlusX, |(electrode, _)| electrode.enters_from);
    let w = job.plan.weights.normalised(job.machine.axes.free_axes(side));
    let groups: [&[(&str, f64)]; 3] = [
        &[("a1", w.a1), ("b1", w.b1), ("c1", w.c1), ("d1", w.d1), ("e1", w.e1)],
        &[("a2", w.a2), ("b2", w.b2), ("c2", w.c2)],
        &[("a3", w.a3), ("b3", w.b3)],
    ];
    let shown = |group: &[(&str, f64)]| {
        let used = group.iter().filter(|(_, weight)| *weight > 0.0);
        used.map(|(name, weight)| format!("{name} {weight:.3}")).collect::<Vec<_>>().join("  ")
    };
    for (name, group) in ["Axes, normalised", "Walls, normalised", "Objectives, normalised"].iter().zip(groups) {
        fact(ui, name, shown(group));
    }
}

fn verify(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    let Some(plan) = desk.work.plan().cloned() else {
        ui.label("No path yet: plan one first (F5).");
        return;
    };
    let length = cx.preferences.length;
    for (index, outcome) in plan.electrodes.iter().enumerate() {
        let Some(planned) = &outcome.plan.path else {
            // What a single electrode fails at is said above the form already.
            if plan.electrodes.len() > 1 {
                notice(ui, palette(ui).bad, &FIELDS.labelled(&outcome.plan.verdict(&plan.channel)));
            }
            continue;
        };
        let c = &planned.certificate;
        let (colour, text) = if desk.plan_is_stale() {
            (palette(ui).warning, "This certificate is out of date: plan again (F5).".to_owned())
        } else if c.holds() && plan.simulation(index).is_some_and(|simulation| !simulation.holds()) {
            let text =
                "Certified: the feed keeps the spark gap, within the tolerance; its motion on the machine does not.";
            (palette(ui).warning, text.to_owned())
        } else if c.holds() {
            (palette(ui).good, "Certified: the whole motion keeps the spark gap, within the tolerance.".to_owned())
        } else {
            (palette(ui).bad, FIELDS.labelled(&outcome.plan.verdict(&plan.channel)))
        };
        notice(ui, colour, &text);
        fact(ui, "Required", length.show(c.required(), 4));
        fact(ui, "Certified (lower bound)", length.show(c.certified(), 4));
        fact(ui, "Smallest met (upper bound)", length.show(c.least().distance, 4));
        fact(ui, "  against", plan.channel.surface_name(c.least().surface));
        fact(ui, "  at a retract distance of", length.show(c.least().s, 3));
        fact(ui, "Rows", planned.path.rows.len().to_string());
        fact(ui, "Violations", c.violations().len().to_string());
        if ui.button("Go to the closest point").clicked() {
            desk.go_to(c.least().s);
        }
        if let Some(preset) = outcome.preset_sentence() {
            notice(ui, palette(ui).faint, &format!("{preset}."));
        }
        if let Some(copying) = plan.copying(index) {
            notice(ui, palette(ui).faint, &copying.sentence());
        }
        if let Some(room) = plan.setting(index) {
            let colour = if room.holds() { palette(ui).faint } else { palette(ui).warning };
            notice(ui, colour, &sentence(&format!("{}.", room.sentence())));
        }
    }
    finishing(ui, desk, cx, &plan);
    if desk.work.can_release() {
        next(ui, desk, cx, Stage::Export);
    }
}

/// The work that a certified plan waits for before it can be released.
fn awaited(desk: &BliskDesk) -> &'static str {
    match desk.work.doing().filter(|doing| doing.what == Stage::Verify.name()).map(|doing| &*doing.stage) {
        Some("simulation") => "the whole motion is being simulated on the machine",
        Some("residual stock") => "the residual stock is being computed",
        _ => "the copying motions are being computed",
    }
}

/// The finishing of the channel by the electrodes, as far as known.
fn finishing(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, plan: &PlanOutcome) {
    match desk.work.finishing() {
        State::Running => {
            notice(ui, palette(ui).faint, &format!("{}\u{2026}", sentence(awaited(desk))));
        }
        State::Failed(why) => {
            let text = format!("No residual stock and no copying motions: {why}.");
            notice(ui, palette(ui).warning, &text);
            if ui.button("Compute the residual stock").clicked() {
                desk.work.resume_finishing();
            }
        }
        _ => {
            if let Some(left) = plan.residual_stock() {
                residual_stock(ui, desk, cx, left, &plan.channel);
            }
            super::burning::show(ui, desk);
        }
    }
}

/// Residual stock, surface by surface.
fn residual_stock(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context, left: &ResidualStock, channel: &Channel) {
    let length = cx.preferences.length;
    ui.add_space(6.0);
    ui.strong(if desk.plan_is_stale() { "Residual stock, out of date" } else { "Residual stock" });
    let stock = &left.stock;
    fact(ui, "In the channel", format!("{:.2} of {:.0} mm³", stock.left_mm3, stock.channel_mm3));
    for figures in &left.surfaces {
        let name = channel.surface_name(figures.surface);
        fact(ui, &format!("Thickest, {name}"), length.show(figures.left.depth_mm, 3));
        if figures.overcut.at.is_some() {
            fact(ui, &format!("Overcut, {name}"), length.show(figures.overcut.depth_mm, 3));
        }
    }
    let text = if desk.residual_stock { "Show the electrode" } else { "Show the residual stock" };
    cx.button(ui, desk, BliskCommand::ResidualStock, text, false);
}

fn export(ui: &mut Ui, desk: &mut BliskDesk, cx: &mut Context) {
    let released = desk.work.released().is_some();
    if !released && !desk.work.can_release() && desk.work.finishing() == State::Running {
        let unless = if simulate::is_needed(desk.document.params()) { ", unless something collides" } else { "" };
        let text = format!(
            "{}. The plan can be released once its copying motions are computed{unless}.",
            sentence(awaited(desk))
        );
        notice(ui, palette(ui).faint, &text);
    } else if !released && !desk.work.can_release() {
        let collides = desk.work.plan().and_then(|plan| plan.finishing()).is_some_and(|f| f.collision().is_some());
        let why = if collides {
            "A plan with a collision on the machine cannot be released; step Verify shows where."
        } else {
            "Only a certified plan that is up to date can be released."
        };
        notice(ui, palette(ui).warning, why);
    }
    ui.horizontal(|ui| {
        cx.button(ui, desk, BliskCommand::Release, "Release for export", !released);
        cx.button(ui, desk, FrameCommand::Export, "Export…", released);
        if released {
            cx.button(ui, desk, BliskCommand::Withdraw, "Withdraw", false);
        }
    });
    if released {
        ui.add_space(4.0);
        let text = "Released: this path. A change of the path withdraws the release; feed and post do not change it.";
        notice(ui, palette(ui).good, text);
    }
    let Some(exported) = desk.work.exported().cloned() else { return };
    ui.add_space(6.0);
    ui.strong("Written");
    ui.add(egui::Label::new(RichText::new(exported.folder.display().to_string()).small()).wrap());
    for name in &exported.written {
        ui.label(RichText::new(name).monospace());
    }
    if let Some(why) = &exported.no_job_sheet {
        notice(ui, palette(ui).warning, &format!("No job sheet: {why}"));
    }
}
