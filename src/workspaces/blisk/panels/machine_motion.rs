//! The whole motion on the machine: its strip below the timeline, and where it stands.

use crate::workspaces::blisk::desk::BliskDesk;
use std::sync::Arc;

use egui::{Align2, FontId, Rect, Ui};
use glam::DVec3;

use crate::widgets::theme::palette;
use crate::widgets::timeline::Strip;
use crate::workspaces::blisk::job::plan::PlanOutcome;
use crate::workspaces::blisk::scene::machine::{Moment, WholeMotion, meeting};
use feed::copying::Copying;
use feed::simulation::{Phase, Simulation};

/// Where the machine stands in its whole motion.
#[derive(Default)]
pub struct MachineMotion {
    /// The way that it has gone; none while the timeline above says where the electrode stands.
    way: Option<f64>,
    motion: Option<(Arc<Simulation>, WholeMotion)>,
    /// Where something comes too close first.
    trouble: Option<Trouble>,
}

/// Where something comes too close.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trouble {
    /// The way to it.
    way: f64,
    /// Withdrawn distance on the feed (mm), if it is there.
    pub s: Option<f64>,
    /// The two points that come too close, in W at that instant.
    pub points: [DVec3; 2],
}

impl MachineMotion {
    /// Keeps up with the electrode that is looked at.
    pub fn follow(&mut self, plan: Option<&Arc<PlanOutcome>>, electrode: usize) {
        let simulation = plan.and_then(|p| p.simulation(electrode));
        if simulation.map(Arc::as_ptr) == self.motion.as_ref().map(|(s, _)| Arc::as_ptr(s)) {
            return;
        }
        self.way = None;
        let planned = plan.and_then(|p| p.electrodes.get(electrode)?.plan.path.as_ref());
        let copying = plan.and_then(|p| p.copying(electrode)).and_then(Copying::certified);
        self.motion = simulation.zip(planned).map(|(simulation, planned)| {
            (simulation.clone(), WholeMotion::new(simulation, &planned.path, copying.map(|c| &c.path)))
        });
        let o = planned.map(|p| p.path.reference_point);
        self.trouble = self.motion.as_ref().zip(o).and_then(|((simulation, motion), o)| {
            let (place, points) = meeting(simulation, o)?;
            let way = motion.way_to(&place)?;
            // The way back passes the same places; where it is told of is the way in.
            let s = motion.at(way).filter(|moment| moment.phase == Phase::Feed).and_then(|moment| moment.s);
            Some(Trouble { way, s, points })
        });
    }

    /// The moment of the whole motion that is looked at, if it is that and not the timeline above.
    pub fn shown(&self) -> Option<Moment> {
        self.motion.as_ref()?.1.at(self.way?)
    }

    /// What was found out about it.
    pub fn simulation(&self) -> Option<&Arc<Simulation>> {
        self.motion.as_ref().map(|(simulation, _)| simulation)
    }

    /// Goes to `way`, or back to the timeline above.
    pub fn go_to(&mut self, way: Option<f64>) {
        self.way = way;
    }

    /// Goes on by `way`. None if it is not looked at, or whether there is more of it.
    pub fn advance(&mut self, way: f64) -> Option<bool> {
        let (now, length) = (self.way?, self.motion.as_ref()?.1.length());
        self.way = Some((now + way).min(length));
        Some(now + way < length)
    }

    /// Where something comes too close first.
    pub fn trouble(&self) -> Option<&Trouble> {
        self.trouble.as_ref()
    }
}

/// A strip with a part for everything that the machine does; a drag moves it.
pub fn strip(ui: &mut Ui, desk: &mut BliskDesk) {
    let Some((_, motion)) = &desk.machine.motion else { return };
    let length = motion.length();
    let strip = Strip::new(ui, 18.0, "Whole motion", (desk.machine.way.unwrap_or(0.0), length > 0.0));
    let (rect, painter, inner, colours) = (strip.rect, &strip.painter, strip.inner(), palette(ui));
    let x_of = |way: f64| inner.left() + inner.width() * (way / length.max(1e-9)) as f32;
    for (i, (phase, _, [from, to])) in motion.phases().enumerate() {
        let part = Rect::from_x_y_ranges(x_of(from)..=x_of(to), rect.shrink(2.0).y_range());
        let fill = if i % 2 == 0 { colours.faint.gamma_multiply(0.18) } else { colours.faint.gamma_multiply(0.32) };
        painter.rect_filled(part, 2.0, fill);
        if part.width() > 7.0 * phase.name().len() as f32 {
            let font = FontId::proportional(10.0);
            painter.text(part.center(), Align2::CENTER_CENTER, phase.name(), font, ui.visuals().text_color());
        }
    }
    if let Some(trouble) = desk.machine.trouble() {
        painter.vline(x_of(trouble.way), rect.y_range(), egui::Stroke::new(2.0, colours.bad));
    }
    if let Some(way) = desk.machine.way {
        strip.pin(x_of(way), rect.center().y, 4.0);
    }
    if let Some(t) = strip.dragged(inner) {
        desk.go_to_moment(length * t);
    }
}

/// What was found out about the whole motion.
pub fn facts(ui: &mut Ui, desk: &mut BliskDesk) {
    let Some(simulation) = desk.machine.simulation() else { return };
    ui.add_space(6.0);
    ui.separator();
    ui.label(egui::RichText::new("Whole motion on the machine").small().color(palette(ui).faint));
    let colour = if simulation.holds() { ui.visuals().text_color() } else { palette(ui).bad };
    ui.add(egui::Label::new(egui::RichText::new(simulation.sentence()).color(colour)).wrap());
    if let Some(way) = desk.machine.trouble().map(|trouble| trouble.way)
        && ui.button("Go to the collision").clicked()
    {
        desk.go_to_moment(way);
    }
}
