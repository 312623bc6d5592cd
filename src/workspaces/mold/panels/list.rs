//! The lists: that of regions, sorted, filtered, selected, and in its place that of electrodes.

use crate::workspaces::commands::CommandSet;
use crate::workspaces::context::Context;
use crate::workspaces::mold::commands::MoldCommand;
use egui::{Align, Align2, DragValue, Layout, RichText, Role, Sense, TextStyle, Ui, WidgetInfo, vec2};
use egui_extras::{Column as Width, TableBuilder};

use super::desk::{Column, MoldDesk};
use super::electrode;
use crate::widgets::panel_parts::fact;
use crate::widgets::theme::{palette, tick};
use crate::workspaces::mold::report::uncut::CadFaceReport;
use crate::workspaces::mold::scene::region_colour;

impl Column {
    /// Columns that there is always room for.
    const NEEDED: [Self; 3] = [Self::Index, Self::Volume, Self::Height];

    fn name(self) -> &'static str {
        ["#", "volume mm³", "area mm²", "height", "nearest"][self as usize]
    }

    /// Width (points); none for the remaining width.
    fn width(self) -> Option<f32> {
        [Some(40.0), None, Some(66.0), Some(52.0), Some(58.0)][self as usize]
    }
}

/// Below this width (points) there are the most needed columns only.
const NARROW: f32 = 326.0;

/// The list of regions or that of electrodes.
pub(super) fn lists(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
    if desk.electrodes.designed().is_some() {
        ui.add_space(2.0);
        ui.horizontal(|ui| {
            for (name, is_shown) in [("Regions", false), ("Electrodes", true)] {
                let is_on = desk.electrodes.is_shown == is_shown;
                let response = ui.selectable_label(is_on, name).on_hover_text(MoldCommand::Electrodes.hint(ui.ctx()));
                response.widget_info(|| WidgetInfo::selected(Role::Tab, true, is_on, format!("List of {name}")));
                if response.clicked() && !is_on {
                    cx.push(MoldCommand::Electrodes);
                }
            }
        });
    }
    if desk.electrodes.seen().is_some() { electrode::list(ui, desk, cx) } else { show(ui, desk, cx) }
}

/// Draws the list of regions.
fn show(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context) {
    ui.add_space(4.0);
    let is_narrow = ui.available_width() < NARROW;
    let listed = desk.listed();
    let all = desk.regions().len();
    ui.horizontal(|ui| {
        ui.strong("Regions");
        let count = if listed.len() == all { all.to_string() } else { format!("{} of {all}", listed.len()) };
        ui.label(RichText::new(count).color(palette(ui).faint));
        stale(ui, desk);
        let words = if is_narrow { "\u{2265}" } else { "not below" };
        let label = ui.label(RichText::new(words).color(palette(ui).faint)).on_hover_text("The least volume shown");
        let least = DragValue::new(&mut desk.least_volume).range(0.0..=1e9).speed(0.01).max_decimals(3);
        ui.add_sized(vec2(58.0, 22.0), least).labelled_by(label.id);
        ui.label(RichText::new("mm³").color(palette(ui).faint));
    });
    if desk.work.other().is_some() {
        tick(ui, &mut desk.only_vanishing, "Only regions that the other cutters would remove");
    }
    // What is known of the selected region stands below, whatever room the list takes.
    let below =
        desk.selected.map_or(0.0, |selected| if cad_faces_of(desk, selected).is_empty() { 264.0 } else { 286.0 });
    let room = vec2(ui.available_width(), (ui.available_height() - below).max(80.0));
    ui.allocate_ui(room, |ui| {
        ui.set_max_height(room.y);
        dim(ui, desk);
        table(ui, desk, &listed);
    });
    if let Some(selected) = desk.selected {
        ui.separator();
        ui.scope(|ui| {
            dim(ui, desk);
            details(ui, desk, cx, selected);
        });
    }
}

/// Shows a word if the result is out of date.
pub(super) fn stale(ui: &mut Ui, desk: &MoldDesk) {
    if let Some(others) = desk.found_of_others() {
        let text = RichText::new("out of date").color(palette(ui).warning);
        ui.label(text).on_hover_text(format!("{others}: these figures are out of date"));
    }
}

/// Lets what follows stand back if it is not of the present question.
pub(super) fn dim(ui: &mut Ui, desk: &MoldDesk) {
    if desk.found_of_others().is_some() {
        ui.multiply_opacity(0.7);
    }
}

fn table(ui: &mut Ui, mold: &mut MoldDesk, listed: &[usize]) {
    let columns: &[Column] = if ui.available_width() < NARROW { &Column::NEEDED } else { &Column::ALL };
    let gap = ui.spacing().item_spacing.x;
    let taken: f32 = columns.iter().map(|column| column.width().unwrap_or(0.0) + gap).sum();
    let rest = (ui.available_width() - taken + gap).max(64.0);
    let widths: Vec<f32> = columns.iter().map(|column| column.width().unwrap_or(rest)).collect();
    heads(ui, mold, columns, &widths);
    let mut table = TableBuilder::new(ui)
        .id_salt(("regions", columns.len()))
        .striped(true)
        .sense(Sense::click())
        .cell_layout(Layout::right_to_left(Align::Center))
        .min_scrolled_height(0.0)
        .auto_shrink([false, false]);
    for width in &widths {
        table = table.column(Width::exact(*width));
    }
    // One that was clicked in the view may be far down the list.
    let place = mold.selected.and_then(|selected| listed.iter().position(|i| *i == selected));
    if std::mem::replace(&mut mold.scrolled_to, mold.selected) != mold.selected
        && let Some(row) = place
    {
        table = table.scroll_to_row(row, None);
    }
    let mut clicked = None;
    table.body(|body| {
        body.rows(19.0, listed.len(), |mut row| {
            let i = listed[row.index()];
            let is_selected = mold.selected == Some(i);
            row.set_selected(is_selected);
            columns.iter().for_each(|column| drop(row.col(|ui| cell(ui, mold, *column, i))));
            let response = row.response();
            let name = format!("Region {}", i + 1);
            response.widget_info(|| WidgetInfo::selected(Role::Row, true, is_selected, &name));
            if response.clicked() || response.double_clicked() {
                clicked = Some((i, response.double_clicked()));
            }
        });
    });
    if let Some((i, twice)) = clicked {
        // The second click of two is no second thought.
        mold.selected = Some(i);
        mold.fly_to = twice.then_some(i);
    }
}

/// The heads of the columns. The table's own would catch the clicks on each other.
fn heads(ui: &mut Ui, mold: &mut MoldDesk, columns: &[Column], widths: &[f32]) {
    ui.horizontal(|ui| {
        for (column, width) in columns.iter().zip(widths) {
            head(ui, mold, *column, *width);
        }
    });
}

/// The head of a column, which sorts by it; once more the other way round. All of it can be pressed.
fn head(ui: &mut Ui, mold: &mut MoldDesk, column: Column, width: f32) {
    let (by, falls) = mold.sort;
    let sign = match (by == column, falls) {
        (false, _) => "",
        (true, true) => "\u{23f7}",
        (true, false) => "\u{23f6}",
    };
    let (rect, response) = ui.allocate_exact_size(vec2(width, 20.0), Sense::click());
    response.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Sort by {}", column.name())));
    let is_lit = by == column || response.hovered();
    let colour = if is_lit { ui.visuals().strong_text_color() } else { palette(ui).faint };
    let (text, font) = (format!("{}{sign}", column.name()), TextStyle::Small.resolve(ui.style()));
    ui.painter().text(rect.right_center(), Align2::RIGHT_CENTER, text, font, colour);
    if response.on_hover_cursor(egui::CursorIcon::PointingHand).clicked() {
        // Of sizes one looks for the greatest first.
        let falls_first = matches!(column, Column::Volume | Column::Area | Column::Height);
        mold.sort = (column, if by == column { !falls } else { falls_first });
    }
}

fn cell(ui: &mut Ui, mold: &MoldDesk, column: Column, i: usize) {
    let region = &mold.regions()[i];
    let number = |ui: &mut Ui, value: f64, decimals: usize| {
        ui.label(RichText::new(format!("{value:.decimals$}")).monospace());
    };
    match column {
        Column::Index => {
            number(ui, (i + 1) as f64, 0);
            let (rect, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
            let c = region_colour(i);
            ui.painter().rect_filled(rect, 2.0, egui::Color32::from_rgb(c.r, c.g, c.b));
        }
        Column::Volume => number(ui, region.volume, 3),
        Column::Area => number(ui, region.plan_area, 3),
        Column::Height => number(ui, region.depth, 2),
        Column::Nearest => {
            ui.add(egui::Label::new(RichText::new(mold.nearest(region)).small()).truncate());
        }
    }
}

/// Facts about the selected region.
fn details(ui: &mut Ui, desk: &mut MoldDesk, cx: &mut Context, selected: usize) {
    let Some(region) = desk.regions().get(selected).cloned() else { return };
    let length = cx.preferences.length;
    ui.horizontal(|ui| {
        ui.strong(format!("Region {}", selected + 1));
        cx.button(ui, desk, MoldCommand::FlyToRegion, "Fly to", false);
        let text = if desk.isolated { "Show all" } else { "Isolate" };
        cx.button(ui, desk, MoldCommand::Isolate, text, false);
    });
    fact(ui, "Volume", format!("{:.4} mm³", region.volume));
    fact(ui, "Plan area", format!("{:.4} mm²", region.plan_area));
    fact(ui, "Surface", format!("{:.4} mm²", region.surface_area));
    fact(ui, "Greatest height", length.show(region.depth, 3));
    fact(ui, "Thickness across the surface", length.show(region.thickness, 3));
    let Some(bounds) = desk.bounds(selected) else { return };
    for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
        let [low, high] = [bounds.min, bounds.max].map(|p| p.to_array()[axis]);
        fact(ui, name, format!("{low:.2} to {high:.2} mm"));
    }
    let remains = desk.work.other().and_then(|other| other.1.remains.get(selected).copied());
    match remains {
        Some(volume) => fact(ui, "With the other cutters", format!("{volume:.4} mm³")),
        None => fact(ui, "Best cutter", desk.nearest(&region)),
    }
    cad_faces(ui, desk, selected);
}

/// The CAD faces that bound region `selected`, the largest first.
fn cad_faces_of(desk: &MoldDesk, selected: usize) -> &[CadFaceReport] {
    let region = desk.found().and_then(|found| found.report.regions.get(selected));
    region.map_or(&[], |region| &region.cad_faces)
}

/// The CAD faces of region `selected` in a line: the largest, and all of them on hovering.
fn cad_faces(ui: &mut Ui, desk: &MoldDesk, selected: usize) {
    let all = cad_faces_of(desk, selected);
    let Some(largest) = all.first() else { return };
    let more = if all.len() > 1 { format!(" and {} more", all.len() - 1) } else { String::new() };
    let words = all.iter().map(|f| format!("Face {}: {}, {:.3} mm²", f.number, f.face, f.area_mm2));
    let words = words.collect::<Vec<_>>().join("\n");
    let line = ui.scope(|ui| fact(ui, "On CAD faces", format!("{}{more}", largest.number)));
    line.response.on_hover_text(words);
}
