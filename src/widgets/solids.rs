//! The solids of a STEP file, to be chosen from.

use egui::{RichText, Ui};

use crate::widgets::theme::palette;
use import::SolidReport;

/// Solids that are listed at most.
const LISTED: usize = 200;

/// Draws a box to tick for each solid of a file. Answers the numbers of those that make the part once they change; none
/// stand for all.
pub fn solids(ui: &mut Ui, all: &[SolidReport]) -> Option<Vec<u32>> {
    if all.len() < 2 {
        return None;
    }
    let taken = all.iter().filter(|s| s.is_taken).count();
    let mut chosen = None;
    egui::CollapsingHeader::new(format!("Solids: {taken} of {}", all.len())).default_open(true).show(ui, |ui| {
        egui::ScrollArea::vertical().max_height(180.0).auto_shrink([false, true]).show(ui, |ui| {
            for solid in all.iter().take(LISTED) {
                let mut is_taken = solid.is_taken;
                let text = format!("{} {}", solid.number, solid.name);
                // The part keeps at least one solid.
                let can_change = !is_taken || taken > 1;
                let row = ui.add_enabled(can_change, egui::Checkbox::new(&mut is_taken, text));
                let closed = if solid.is_closed { "closed" } else { "open" };
                let about = format!("{} faces, {:.1} mm³, {closed}", solid.faces, solid.volume_mm3);
                if row.on_hover_text(about).changed() {
                    let with = |s: &&SolidReport| if s.number == solid.number { is_taken } else { s.is_taken };
                    let numbers: Vec<u32> = all.iter().filter(with).map(|s| s.number).collect();
                    chosen = Some(if numbers.len() == all.len() { Vec::new() } else { numbers });
                }
            }
            if all.len() > LISTED {
                let text = format!("and {} more; give their numbers above", all.len() - LISTED);
                ui.label(RichText::new(text).small().color(palette(ui).faint));
            }
        });
    });
    chosen
}
