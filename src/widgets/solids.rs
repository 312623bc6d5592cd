//! The solids of a STEP file, to be chosen from.

use egui::{Color32, RichText, Sense, Ui, Vec2};

use crate::widgets::theme::palette;
use import::SolidReport;

/// Solids that are listed at most.
const LISTED: usize = 200;

/// Numbers of solids that were chosen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChosenSolids {
    /// Numbers of the solids that make the part.
    pub part: Vec<u32>,
    /// Numbers of the solids that are in the way.
    pub obstacles: Vec<u32>,
}

/// Purpose of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Part,
    Obstacle,
    LeftOut,
}

impl Use {
    fn of(solid: &SolidReport) -> Self {
        match (solid.is_taken, solid.is_obstacle) {
            (true, _) => Self::Part,
            (_, true) => Self::Obstacle,
            _ => Self::LeftOut,
        }
    }
}

/// Draws two boxes to tick for each solid of a file: it makes the part, or it is an obstacle; without a tick it is left
/// out. Answers the numbers once they change.
pub fn solids(ui: &mut Ui, all: &[SolidReport]) -> Option<ChosenSolids> {
    if all.len() < 2 {
        return None;
    }
    let taken = all.iter().filter(|s| s.is_taken).count();
    let mut changed = None;
    egui::CollapsingHeader::new(format!("Solids: {taken} of {}", all.len())).default_open(true).show(ui, |ui| {
        egui::ScrollArea::vertical().max_height(180.0).auto_shrink([false, true]).show(ui, |ui| {
            for solid in all.iter().take(LISTED) {
                let now = Use::of(solid);
                // The part keeps at least one solid.
                let can_change = now != Use::Part || taken > 1;
                if let Some(then) = ui.horizontal(|ui| row(ui, solid, can_change)).inner {
                    changed = Some((solid.number, then));
                }
            }
            if all.len() > LISTED {
                let text = format!("and {} more; give their numbers above", all.len() - LISTED);
                ui.label(RichText::new(text).small().color(palette(ui).faint));
            }
        });
    });
    let (number, then) = changed?;
    let of = |wanted: Use| {
        let is_wanted = |s: &&SolidReport| if s.number == number { then == wanted } else { Use::of(s) == wanted };
        all.iter().filter(is_wanted).map(|s| s.number).collect()
    };
    Some(ChosenSolids { part: of(Use::Part), obstacles: of(Use::Obstacle) })
}

/// The row of a solid; its use once that changes.
fn row(ui: &mut Ui, solid: &SolidReport, can_change: bool) -> Option<Use> {
    let now = Use::of(solid);
    let mut then = None;
    if let Some(color) = solid.color {
        let (place, _) = ui.allocate_exact_size(Vec2::splat(10.0), Sense::hover());
        let [red, green, blue] = color.map(|c| (255.0 * c.clamp(0.0, 1.0)).round() as u8);
        ui.painter().rect_filled(place, 2.0, Color32::from_rgb(red, green, blue));
    }
    let closed = if solid.is_closed { "closed" } else { "open" };
    let about = format!("{} faces, {:.1} mm³, {closed}", solid.faces, solid.volume_mm3);
    let mut is_part = now == Use::Part;
    let text = format!("{} {}", solid.number, solid.name);
    let part = ui.add_enabled(can_change, egui::Checkbox::new(&mut is_part, text));
    if part.on_hover_text(format!("Part of what is machined: {about}")).changed() {
        then = Some(if is_part { Use::Part } else { Use::LeftOut });
    }
    let mut is_obstacle = now == Use::Obstacle;
    let obstacle = ui.add_enabled(can_change, egui::Checkbox::new(&mut is_obstacle, "obstacle"));
    ui.ctx()
        .accesskit_node_builder(obstacle.id, |node| node.set_label(format!("Solid {} is an obstacle", solid.number)));
    if obstacle.on_hover_text("In the way: electrodes keep clear of it, and it is not machined").changed() {
        then = Some(if is_obstacle { Use::Obstacle } else { Use::LeftOut });
    }
    then
}
