//! The report on electrodes as one page without scripts: the answer first, then figures, electrodes, regions.

use std::fmt::Write;

use crate::workspaces::blisk::report::html::{STYLE, data_url};
use crate::workspaces::blisk::report::tables::{number, parameters, row, table};
use crate::workspaces::mold::report::{Division, ElectrodesReport, RegionEntry};
use files::svg_plot::escape;
use nc::burn_table::{BurnEntry, BurnTable, CheckState, ElectrodeEntry, ElectrodeState, method_name, shape_name};

/// What is not there.
const NONE: &str = "\u{2013}";

/// The whole page.
pub(super) fn page(report: &ElectrodesReport, pictures: &[(String, Vec<u8>)]) -> String {
    let mold = escape(&report.table.mold);
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>Electrodes: {mold}</title>\
         <style>{STYLE}</style></head><body><main>"
    );
    let class = if report.holds { "ok" } else { "no" };
    let sentence = escape(&report.sentence);
    let _ = write!(
        out,
        "<header><h1>Electrodes <span>{mold}</span></h1><p class=\"verdict {class}\">{sentence}</p></header>"
    );
    troubles(&mut out, report);
    key_figures(&mut out, report);
    figures(&mut out, pictures);
    overview(&mut out, &report.table);
    report.table.electrodes.iter().for_each(|e| electrode(&mut out, e));
    regions(&mut out, &report.regions);
    let mut burns = report.table.electrodes.iter().flat_map(|e| &e.burns);
    if stages(&report.table) > 1 || burns.any(|burn| burn.parts.len() > 1) {
        let _ = write!(out, "<p class=\"soft\">{}</p>", escape(report.model));
    }
    out.push_str("<section><h2>Parameters</h2>");
    parameters(&mut out, &report.parameters);
    let (version, schema) = (escape(report.table.program_version), report.schema);
    let _ = writeln!(
        out,
        "</section><footer>Sparkpath {version}, electrodes schema {schema}</footer></main></body></html>"
    );
    out
}

/// What is not as it should be, in banners.
fn troubles(out: &mut String, report: &ElectrodesReport) {
    let mut banner = |name: &str, text: &str| {
        let _ = write!(out, "<p class=\"banner no\"><b>{}</b> {}</p>", escape(name), escape(text));
    };
    for blocked in &report.blocked {
        banner(&format!("{} is blocked.", blocked.electrode), &blocked.why);
    }
    for region in &report.regions {
        if let Some(trouble) = &region.trouble {
            banner(&format!("Region {}.", region.index), trouble);
        }
    }
    for name in &report.overridden {
        banner(&format!("{name} is overridden."), "Released despite a failed check.");
    }
    for e in &report.table.electrodes {
        e.warnings.iter().for_each(|text| banner(&format!("{}.", e.name), text));
    }
    for edit in &report.unmet_edits {
        let edit = escape(edit);
        let _ = write!(out, "<p class=\"soft\">The change “{edit}” has no effect.</p>");
    }
    for idle in &report.idle_overrides {
        let (name, why) = (escape(&idle.name), escape(idle.why));
        let _ = write!(out, "<p class=\"soft\">Override of {name}: {why}.</p>");
    }
}

/// How many stages there are electrodes for.
fn stages(table: &BurnTable) -> usize {
    table.electrodes.iter().map(|e| e.stage.as_str()).collect::<std::collections::BTreeSet<_>>().len()
}

fn key_figures(out: &mut String, report: &ElectrodesReport) {
    let table = &report.table;
    // A body that several stages share is one piece.
    let mut bodies = std::collections::BTreeMap::new();
    for e in &table.electrodes {
        let body = bodies.entry(e.family.as_ref().map_or(&e.name, |family| &family.name)).or_insert(0);
        *body = e.quantity.max(*body);
    }
    let made = bodies.into_values().fold(0, u32::saturating_add);
    let without = report.regions.iter().filter(|r| r.trouble.is_some()).count();
    let thickest = report.regions.iter().map(|r| r.left_thickness_mm).fold(0.0, f64::max);
    let left = report.regions.iter().map(|r| r.left_volume_mm3).sum();
    let figures = [
        ("regions", report.regions.len().to_string(), ""),
        ("not wholly burned", without.to_string(), ""),
        ("electrodes", table.electrodes.len().to_string(), ""),
        ("pieces to make", made.to_string(), ""),
        ("burns", table.burns.to_string(), ""),
        ("burning", number(table.minutes, 0), "min"),
        ("blocked", report.blocked.len().to_string(), ""),
        ("overridden", report.overridden.len().to_string(), ""),
        ("residual stock, thickest", number(thickest, 4), "mm"),
        ("left", number(left, 3), "mm\u{b3}"),
    ];
    out.push_str("<dl class=\"key\">");
    for (name, value, unit) in figures {
        let _ = write!(out, "<div><dt>{name}</dt><dd>{value} <small>{unit}</small></dd></div>");
    }
    out.push_str("</dl>");
}

fn figures(out: &mut String, pictures: &[(String, Vec<u8>)]) {
    if pictures.is_empty() {
        return;
    }
    out.push_str("<section class=\"pictures\">");
    for (caption, png) in pictures {
        let (caption, data) = (escape(caption), data_url("image/png", png));
        let _ =
            write!(out, "<figure><img alt=\"{caption}\" src=\"{data}\"><figcaption>{caption}</figcaption></figure>");
    }
    out.push_str("</section>");
}

fn overview(out: &mut String, burn_table: &BurnTable) {
    let rows = burn_table.electrodes.iter().map(|e| {
        vec![
            format!("<b>{}</b>", escape(&e.name)),
            escape(&e.stage),
            number(e.gap_mm, 4),
            orbit(e),
            e.quantity.to_string(),
            blank(e),
            e.holder.as_ref().map_or("none is large enough".to_owned(), |h| escape(&h.name)),
            method_name(e.method).to_owned(),
            e.burns.len().to_string(),
            number(e.volume_mm3, 2),
            number(e.minutes, 1),
            e.state.name().to_owned(),
        ]
    });
    let head = [
        "electrode",
        "stage",
        "#gap mm",
        "orbit",
        "#pieces",
        "blank mm",
        "holder",
        "method",
        "#burns",
        "#mm\u{b3}",
        "#min",
        "checks",
    ];
    out.push_str("<section><h2>Electrodes</h2>");
    table(
        out,
        "",
        &format!("Of {}; files hold the {} shape", burn_table.material, shape_name(burn_table.shape)),
        &head,
        rows,
    );
    let _ = write!(
        out,
        "<p class=\"soft\">Positions below are those of the middle of the base's underside, in the axes of the upright mold, \
         whose opening looks along +Z ({} of its file). C turns counter-clockwise seen from the machine's head, along the burn. Every electrode is \
         lifted {} mm.</p></section>",
        escape(&burn_table.opening.to_uppercase().replace('-', "\u{2212}")),
        number(burn_table.lift_mm, 1)
    );
}

fn orbit(e: &ElectrodeEntry) -> String {
    match e.orbit.pattern {
        "none" => NONE.to_owned(),
        pattern => format!("{pattern} {}", number(e.orbit.radius_mm, 4)),
    }
}

fn blank(e: &ElectrodeEntry) -> String {
    if e.blank.is_round {
        return format!("round {} \u{d7} {}", number(e.blank.sides_mm[0], 1), number(e.blank.length_mm, 1));
    }
    let round = e.blank.diameter_mm.map_or(String::new(), |d| format!(", or round {}", number(d, 1)));
    let [x, y] = e.blank.sides_mm.map(|side| number(side, 1));
    format!("{x} \u{d7} {y} \u{d7} {}{round}", number(e.blank.length_mm, 1))
}

/// Electrodes of other stages on the same base.
fn family(e: &ElectrodeEntry) -> String {
    let Some(family) = &e.family else { return NONE.to_owned() };
    let [x, y] = family.offset_mm.map(|v| number(v, 4));
    format!(
        "{}: {}, heads {x}, {y} mm from the middle of the base",
        escape(&family.others.join(", ")),
        escape(&family.name)
    )
}

/// The burn sheet of an electrode with its checks.
fn electrode(out: &mut String, e: &ElectrodeEntry) {
    let _ = write!(out, "<section><h2>{} <span>{}</span></h2>", escape(&e.name), escape(&e.stage));
    let (class, word, text) = match e.state {
        ElectrodeState::Ok => ("ok", "Approved.", "Every check holds."),
        ElectrodeState::Overridden => ("no", "Overridden.", "Released despite a failed check."),
        ElectrodeState::Blocked => ("no", "Blocked.", "A check fails; it has no file and must not be used."),
    };
    let _ = write!(out, "<p class=\"banner {class}\"><b>{word}</b> {text}</p><div class=\"cols\">");
    let head =
        ["#burn", "#X mm", "#Y mm", "#Z mm", "#C \u{b0}", "#depth mm", "#mm\u{b3}", "#min", "its X axis", "parts"];
    table(out, "", "Burns", &head, e.burns.iter().map(burn));
    let rows = e.checks.iter().map(|c| {
        let state = match c.state {
            CheckState::Ok => "ok",
            CheckState::Overridden => "<b>overridden</b>",
            CheckState::Failed => "<b>failed</b>",
            CheckState::NotMade => "not made",
        };
        let place = c.place_mm.map_or(String::new(), |p| format!(", at {}", point(p)));
        vec![c.kind.name().to_owned(), state.to_owned(), escape(&c.text) + &place]
    });
    table(out, "", "Checks", &["check", "", "found"], rows);
    let rows = [
        row(
            "Undersize, side and bottom, mm",
            format!("{}, {}", number(e.undersize_wall_mm, 4), number(e.undersize_floor_mm, 4)),
        ),
        row("Finish", format!("VDI {}, Ra {} \u{b5}m", number(e.finish_vdi, 0), number(e.roughness_um, 2))),
        row("Lifted along", e.lift.map(|v| number(v, 4)).join(", ")),
        row("Area seen along the burn, mm\u{b2}", number(e.front_area_mm2, 2)),
        row("Area that burns, mm\u{b2}", number(e.burn_area_mm2, 2)),
        row("Base, high, mm", number(e.base_height_mm, 3)),
        row(
            "Orbit's axes",
            format!(
                "{}; {}",
                e.orbit.x_axis.map(|v| number(v, 4)).join(", "),
                e.orbit.y_axis.map(|v| number(v, 4)).join(", ")
            ),
        ),
        row("Blank, mm", blank(e)),
        row("One body with", family(e)),
    ];
    table(out, "pairs", "Electrode", &[], rows);
    out.push_str("</div></section>");
}

fn burn(burn: &BurnEntry) -> Vec<String> {
    let mut cells = vec![burn.number.to_string()];
    cells.extend([burn.x_mm, burn.y_mm, burn.z_mm, burn.c_deg, burn.depth_mm].map(|v| number(v, 4)));
    cells.extend([number(burn.volume_mm3, 3), number(burn.minutes, 1)]);
    cells.extend([burn.x_axis.map(|v| number(v, 4)).join(", "), escape(&burn.parts.join(", "))]);
    cells
}

fn point(p: [f64; 3]) -> String {
    p.map(|v| number(v, 3)).join(", ")
}

fn regions(out: &mut String, regions: &[RegionEntry]) {
    out.push_str("<section><h2>Regions</h2>");
    let rows = regions.iter().map(|r| {
        let electrodes = if r.electrodes.is_empty() { NONE.to_owned() } else { escape(&r.electrodes.join(", ")) };
        vec![
            r.index.to_string(),
            r.parts.to_string(),
            electrodes,
            r.method.to_owned(),
            r.direction.map(|v| number(v, 3)).join(", "),
            number(r.left_thickness_mm, 4),
            number(r.left_volume_mm3, 4),
            point(r.left_at_mm),
            r.trouble.as_deref().map_or(String::new(), escape),
        ]
    });
    let head = [
        "#region",
        "#parts",
        "electrodes",
        "method",
        "burned along",
        "#residual mm",
        "#residual mm\u{b3}",
        "at",
        "not burned",
    ];
    table(out, "", "Residual stock after all burns", &head, rows);
    let divided: Vec<&RegionEntry> =
        regions.iter().filter(|r| r.parts > 1 || !r.earlier_divisions.is_empty()).collect();
    if !divided.is_empty() {
        out.push_str("<h3>Divisions <small>in plan, mm, seen along the burn</small></h3><ul>");
        for region in divided {
            let _ = write!(out, "<li>Region {}", region.index);
            if let Some(tree) = &region.division {
                out.push_str(": ");
                division(out, tree);
            }
            for earlier in &region.earlier_divisions {
                let _ = write!(out, "<br>{} stage: ", escape(&earlier.stage));
                division(out, &earlier.division);
            }
            out.push_str("</li>");
        }
        out.push_str("</ul>");
    }
    out.push_str("</section>");
}

fn division(out: &mut String, node: &Division) {
    out.push_str(&escape(&node.text));
    if node.parts.is_empty() {
        return;
    }
    out.push_str("<ul>");
    for part in &node.parts {
        out.push_str("<li>");
        division(out, part);
        out.push_str("</li>");
    }
    out.push_str("</ul>");
}
