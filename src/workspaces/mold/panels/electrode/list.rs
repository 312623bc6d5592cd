//! The list of electrodes, and what is known of the selected one.

use crate::workspaces::context::Context;
use crate::workspaces::mold::commands::MoldCommand;
use crate::workspaces::mold::panels::desk::MoldDesk;
use egui::{Align, Layout, RichText, Role, Sense, Ui, WidgetInfo, vec2};
use egui_extras::{Column as Width, TableBuilder};

use super::{arrangement, checks, division};
use crate::widgets::panel_parts::{fact, notice};
use crate::widgets::theme::palette;
use crate::workspaces::mold::scene::electrodes::{BurnOf, electrode_colour};
use crate::workspaces::mold::work::Designed;
use files::Override;
use mold::electrode::design::Electrode;
use nc::burn_table::{BurnEntry, CheckState, ElectrodeEntry};

/// The columns with their widths (points); the name takes what the others leave. Regions and blank need room.
const COLUMNS: [(&str, f32); 6] =
    [("name", 0.0), ("burns", 30.0), ("regions", 42.0), ("blank", 60.0), ("min", 28.0), ("checks", 64.0)];
/// Width of the bar that scrolls, with room beside it (points).
const BAR: f32 = 6.0;
/// Width below which only the most needed columns are shown (points).
const NARROW: f32 = 330.0;
/// Numbers of the most needed columns.
const NEEDED: [usize; 4] = [0, 1, 4, 5];

/// Draws the list.
pub fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
    let Some(made) = desk.electrodes.designed().cloned() else { return };
    let is_stale = !desk.is_designed();
    ui.horizontal(|ui| {
        ui.strong("Electrodes");
        ui.label(RichText::new(made.set.electrodes.len().to_string()).color(palette(ui).faint));
        if is_stale {
            let text = RichText::new("out of date").color(palette(ui).warning);
            ui.label(text).on_hover_text("Out of date");
        }
        stages(ui, desk, &made);
    });
    let rows = made.set.electrodes.len() as f32;
    let room = vec2(ui.available_width(), (24.0 + 26.0 * rows).min(0.4 * ui.available_height()).max(96.0));
    ui.scope(|ui| {
        if is_stale {
            ui.multiply_opacity(0.7);
        }
        ui.allocate_ui(room, |ui| {
            ui.set_max_height(room.y);
            table(ui, desk, cx, &made);
        });
        ui.separator();
        // Another electrode begins with its name, however far the last one was read.
        let of = desk.electrodes.selected.map(|at| at.electrode);
        let scroll = egui::ScrollArea::vertical().id_salt(("electrode", of)).auto_shrink([false, false]);
        scroll.show(ui, |ui| {
            // Nothing ends below the bar.
            ui.set_max_width(ui.available_width() - BAR);
            without(ui, desk, &made);
            match desk.electrodes.selected {
                Some(at) => details(ui, desk, cx, &made, at),
                None => {
                    drop(ui.label(RichText::new("Select an electrode here or in the view.").color(palette(ui).faint)))
                }
            }
        });
    });
}

/// The stage whose electrodes the view shows, where there are several.
fn stages(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed) {
    if made.set.params.stages.len() < 2 {
        return;
    }
    for (i, stage) in made.set.params.stages.iter().enumerate() {
        let is_on = desk.electrodes.stage == i;
        if ui.selectable_label(is_on, &stage.name).on_hover_text("Show the electrodes of this stage").clicked() {
            desk.electrodes.stage = i;
            if desk.electrodes.chosen().is_some_and(|(e, _)| e.stage != i) {
                desk.electrodes.deselect();
            }
        }
    }
}

fn table(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context, made: &Designed) {
    ui.spacing_mut().item_spacing.x = 4.0;
    let is_narrow = ui.available_width() < NARROW;
    let columns: Vec<usize> = if is_narrow { NEEDED.to_vec() } else { (0..COLUMNS.len()).collect() };
    let mut builder = TableBuilder::new(ui)
        .id_salt(("electrodes", columns.len()))
        .striped(true)
        .sense(Sense::click())
        .cell_layout(Layout::left_to_right(Align::Center))
        .min_scrolled_height(0.0)
        .auto_shrink([false, false]);
    for column in &columns {
        let width = COLUMNS[*column].1;
        builder = builder.column(if width > 0.0 { Width::exact(width) } else { Width::remainder().clip(true) });
    }
    let overrides = &desk.document.params().electrodes.overrides;
    let desk = &mut desk.electrodes;
    let selected = desk.selected.map(|at| at.electrode);
    if std::mem::replace(&mut desk.scrolled_to, selected) != selected
        && let Some(row) = selected
    {
        builder = builder.scroll_to_row(row, None);
    }
    let mut clicked = None;
    let headed = builder.header(18.0, |mut header| {
        for column in &columns {
            header.col(|ui| {
                let text = RichText::new(COLUMNS[*column].0).small().color(palette(ui).faint);
                ui.add(egui::Label::new(text).selectable(false));
            });
        }
    });
    headed.body(|body| {
        body.rows(20.0, made.report.table.electrodes.len(), |mut row| {
            let i = row.index();
            let entry = &made.report.table.electrodes[i];
            let is_selected = selected == Some(i);
            row.set_selected(is_selected);
            columns.iter().for_each(|column| drop(row.col(|ui| cell(ui, (made, overrides), (i, entry), *column))));
            let response = row.response();
            response.widget_info(|| {
                WidgetInfo::selected(Role::Row, true, is_selected, format!("Electrode {}", entry.name))
            });
            if response.clicked() || response.double_clicked() {
                clicked = Some((i, response.double_clicked()));
            }
        });
    });
    if let Some((electrode, twice)) = clicked {
        if selected != Some(electrode) {
            desk.select(BurnOf { electrode, burn: 0 });
        }
        if twice {
            cx.push(MoldCommand::FlyToRegion);
        }
    }
}

/// The regions that an electrode burns, rising.
fn regions(entry: &ElectrodeEntry) -> Vec<usize> {
    let mut regions: Vec<usize> = entry.burns.iter().flat_map(|b| b.regions.iter().copied()).collect();
    regions.sort_unstable();
    regions.dedup();
    regions
}

fn cell(ui: &mut Ui, (made, overrides): (&Designed, &[Override]), (i, entry): (usize, &ElectrodeEntry), column: usize) {
    let text = |ui: &mut Ui, text: String| drop(ui.add(egui::Label::new(text).selectable(false).truncate()));
    match column {
        0 => {
            let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
            let c = electrode_colour(&made.set, i);
            ui.painter().rect_filled(rect, 2.0, egui::Color32::from_rgb(c.r, c.g, c.b));
            if !entry.warnings.is_empty() {
                let sign = egui::Label::new(RichText::new("!").strong().color(palette(ui).warning)).selectable(false);
                ui.add(sign).on_hover_text(entry.warnings.join("\n"));
            }
            text(ui, entry.name.clone());
        }
        1 => text(ui, entry.burns.len().to_string()),
        2 => text(ui, joined(&regions(entry))),
        3 => {
            text(ui, entry.blank.text("×"));
        }
        4 => {
            let minutes = entry.minutes.map_or_else(|| "\u{2013}".to_owned(), |minutes| format!("{minutes:.0}"));
            let label = egui::Label::new(minutes).selectable(false).truncate();
            ui.add(label).on_hover_text(entry.rests_on.join("\n"));
        }
        _ => {
            ui.spacing_mut().item_spacing.x = 0.0;
            for check in &entry.checks {
                let is_decided = made.set.is_overridden(i, check.kind, overrides);
                let (sign, colour) = match check.state {
                    CheckState::Failed if is_decided => ("\u{2716}", palette(ui).warning),
                    CheckState::Failed => ("\u{2716}", palette(ui).bad),
                    CheckState::NotMade => ("\u{2013}", palette(ui).faint),
                    _ => ("\u{2714}", palette(ui).good),
                };
                let label = egui::Label::new(RichText::new(sign).small().color(colour)).selectable(false);
                ui.add(label).on_hover_text(format!("{}: {}", check.kind.name(), check.text));
            }
        }
    }
}

fn joined(numbers: &[usize]) -> String {
    numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// Regions that have no electrode for all of them, and why.
fn without(ui: &mut Ui, desk: &mut MoldDesk, made: &Designed) {
    for region in made.set.without_electrode() {
        let axes = desk.params().datum.of_upright(made.opening);
        let why = made.set.regions[region].reason_at(&axes).unwrap_or_default();
        ui.horizontal(|ui| {
            let place = made.places.get(region).copied().flatten();
            let text = format!("Region {} has no electrode: {why}", region + 1);
            let name = format!("Show region {}", region + 1);
            let button = ui.add_enabled_ui(place.is_some(), |ui| checks::show_button(ui, &name)).inner;
            if button.clicked()
                && let (Some(place), Some(mold)) = (place, desk.work.mold())
            {
                let bounds = mold.shape.bounds();
                desk.electrodes.deselect();
                desk.electrodes.point_at(place, text.clone(), &bounds);
            }
            ui.add(egui::Label::new(RichText::new(text).color(palette(ui).bad)).wrap());
        });
    }
}

/// Facts about the selected electrode.
fn details(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context, made: &Designed, at: BurnOf) {
    let Some(entry) = made.report.table.electrodes.get(at.electrode) else { return };
    ui.horizontal(|ui| {
        ui.strong(&entry.name);
        cx.button(ui, desk, MoldCommand::FlyToRegion, "Fly to", false);
        let text = if desk.electrodes.is_alone { "Show all" } else { "Isolate" };
        cx.button(ui, desk, MoldCommand::Isolate, text, false);
        let text = if desk.electrodes.cut.is_some() { "No cut" } else { "Cut" };
        cx.button(ui, desk, MoldCommand::Section, text, false);
        cx.button(ui, desk, MoldCommand::MillFlanks, "Mill its flanks", false);
    });
    for warning in &entry.warnings {
        notice(ui, palette(ui).warning, warning);
    }
    checks::show(ui, desk, cx, made, at.electrode);
    if let Some((electrode, burn)) = at.find(&made.set) {
        let axes = desk.params().datum.of_upright(made.opening);
        let burn = BurnEntry::of(at.burn + 1, burn, electrode.direction, &axes);
        burns(ui, desk, (at, entry.burns.len()), &burn);
    }
    fact(ui, "Blank", format!("{} mm", entry.blank.text(" × ")));
    fact(ui, "Holder", entry.holder.as_ref().map_or("none large enough: add a holder".to_owned(), |h| h.name.clone()));
    if let Some(family) = &entry.family {
        let [x, y] = family.offset_mm;
        fact(ui, "Same body as", format!("{}; heads at {x}, {y} mm", family.others.join(", ")));
    }
    let orbit = if entry.orbit.radius_mm > 0.0 {
        format!(", {} {} mm", entry.orbit.pattern, entry.orbit.radius_mm)
    } else {
        String::new()
    };
    fact(ui, "Gap", format!("{} mm{orbit}", entry.gap_mm));
    burning(ui, &made.set.electrodes[at.electrode], entry);
    arrangement::show(ui, desk, made, at.electrode);
    division::show(ui, desk, made, (at.electrode, &regions(entry)));
}

/// Minutes and wear of an electrode, with what they rest on as a hint.
fn burning(ui: &mut Ui, electrode: &Electrode, entry: &ElectrodeEntry) {
    let shown = ui.scope(|ui| {
        fact(ui, "Time", electrode.figures.minutes_text());
        let wear = |wear: Option<f64>| wear.map_or_else(|| "not considered".to_owned(), |wear| format!("{wear:.4} mm"));
        if entry.end_wear_mm.is_none() && entry.corner_wear_mm.is_none() {
            fact(ui, "Wear", "not considered");
        } else {
            fact(ui, "End wear", wear(entry.end_wear_mm));
            fact(ui, "Corner wear", wear(entry.corner_wear_mm));
        }
        fact(ui, "Needed", entry.needed.clone());
    });
    shown.response.on_hover_text(entry.rests_on.join("\n"));
}

/// The burn that is looked at.
fn burns(ui: &mut Ui, desk: &mut MoldDesk, (at, count): (BurnOf, usize), burn: &BurnEntry) {
    ui.horizontal(|ui| {
        let mut chosen = at.burn;
        if ui.add_enabled(chosen > 0, egui::Button::new("\u{23f4}")).on_hover_text("Previous burn").clicked() {
            chosen -= 1;
        }
        ui.label(format!("Burn {} of {count}", at.burn + 1));
        if ui.add_enabled(chosen + 1 < count, egui::Button::new("\u{23f5}")).on_hover_text("Next burn").clicked() {
            chosen += 1;
        }
        if chosen != at.burn {
            desk.electrodes.select(BurnOf { burn: chosen, ..at });
        }
        ui.label(RichText::new(burn.parts.join(" ")).color(palette(ui).faint));
    });
    fact(ui, "X, Y", format!("{:.3}, {:.3} mm", burn.x_mm, burn.y_mm));
    fact(ui, "Z", format!("{:.3} mm", burn.z_mm));
    fact(ui, "C angle", format!("{:.2}°", burn.c_deg));
    fact(ui, "Depth", format!("{:.3} mm", burn.depth_mm));
}
