//! The tables of the report page.

use std::fmt::Write;

use crate::workspaces::blisk::report::{
    BliskSummary, ElectrodeReport, Failure, InputFile, NodeReport, PoseReport, Smoothness, StageTime, Symbol, Written,
};
use files::svg_plot::escape;

pub use files::report::{file_name, number, small};

/// A table with a caption; cells are HTML. Columns whose header starts with `#` are numbers.
pub fn table(out: &mut String, class: &str, caption: &str, head: &[&str], rows: impl IntoIterator<Item = Vec<String>>) {
    let _ = write!(out, "<table class=\"{class}\"><caption>{}</caption>", escape(caption));
    if !head.is_empty() {
        out.push_str("<thead><tr>");
        for title in head {
            let (class, title) = title.strip_prefix('#').map_or(("", *title), |t| (" class=\"num\"", t));
            let _ = write!(out, "<th{class}>{}</th>", escape(title));
        }
        out.push_str("</tr></thead>");
    }
    out.push_str("<tbody>");
    for row in rows {
        out.push_str("<tr>");
        for (i, cell) in row.iter().enumerate() {
            let number = head.get(i).is_some_and(|t| t.starts_with('#'));
            let _ = write!(out, "<td{}>{cell}</td>", if number { " class=\"num\"" } else { "" });
        }
        out.push_str("</tr>");
    }
    out.push_str("</tbody></table>");
}

fn point(p: [f64; 3]) -> String {
    p.map(|v| number(v, 3)).join(", ")
}

pub fn row(name: &str, value: impl Into<String>) -> Vec<String> {
    vec![escape(name), value.into()]
}

fn range([lo, hi]: [f64; 2]) -> String {
    format!("{} to {}", number(lo, 3), number(hi, 3))
}

pub(super) fn blisk(out: &mut String, b: &BliskSummary) {
    let tips = if b.shrouded { "Shroud radius, mm" } else { "Blade tip radius, mm" };
    let mut rows = vec![
        row("Blades", b.blades.to_string()),
        row("Channel", b.channel.to_string()),
        row("Shrouded", if b.shrouded { "yes" } else { "no" }),
        row("Hub radius, mm", range(b.hub_radius_mm)),
        row(tips, range(b.shroud_radius_mm)),
        row("Blades along X, mm", range(b.span_x_mm)),
        row("Throat, mm", number(b.throat_mm, 3)),
        row("Turning", format!("{}\u{b0}", number(b.turning_deg, 2))),
        row("Walls, low and high theta", escape(&format!("{}, {}", b.low_wall, b.high_wall))),
        row("W origin in the mesh, mm", point(b.frame.origin.to_array())),
        row("W x axis in the mesh", point(b.frame.x.to_array())),
        row("W z axis in the mesh", point(b.frame.z.to_array())),
    ];
    rows.extend(b.assumed.iter().map(|a| row("Assumed", escape(a))));
    table(out, "pairs", "Channel", &[], rows);
}

pub(super) fn inputs(out: &mut String, inputs: &[InputFile]) {
    for i in inputs {
        let mut rows = vec![
            row("File", format!("<span class=\"path\">{}</span>", escape(&i.path))),
            row("SHA-256", format!("<code>{}</code>", escape(&i.sha256))),
            row("Triangles", i.triangles.to_string()),
            row("Unit", escape(&format!("{}: {}", i.unit, i.unit_reason))),
        ];
        rows.extend(i.repairs.iter().map(|r| row("Repaired", escape(r))));
        table(out, "pairs", &format!("Input: {}, {}", i.role, file_name(&i.path)), &[], rows);
    }
}

pub(super) fn symbols(out: &mut String, symbols: &[Symbol]) {
    let rows = symbols
        .iter()
        .map(|s| vec![format!("<i>{}</i>", escape(&s.symbol)), escape(&s.meaning), escape(&s.value), escape(&s.unit)]);
    if !symbols.is_empty() {
        table(out, "", "Symbols of the papers", &["symbol", "meaning", "#value", "unit"], rows);
    }
}

pub fn parameters(out: &mut String, parameters: &serde_json::Value) {
    let mut rows = Vec::new();
    flatten(&mut rows, "", parameters);
    table(out, "pairs", "Job, defaults included", &[], rows);
}

/// One row per leaf, named by its dotted path.
fn flatten(rows: &mut Vec<Vec<String>>, name: &str, value: &serde_json::Value) {
    match value {
        serde_json::Value::Object(map) => {
            for (key, value) in map {
                let name = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
                flatten(rows, &name, value);
            }
        }
        serde_json::Value::Null => {}
        serde_json::Value::String(text) => rows.push(row(name, escape(text))),
        other => rows.push(row(name, escape(&other.to_string().replace(',', ", ")))),
    }
}

pub(super) fn times(out: &mut String, times: &[StageTime]) {
    let total: f64 = times.iter().map(|t| t.seconds).sum();
    let rows = times.iter().map(|t| {
        let share = if total > 0.0 { t.seconds / total * 100.0 } else { 0.0 };
        let bar = format!("<span class=\"bar\" style=\"width:{share:.1}%\"></span>");
        vec![escape(&t.stage), number(t.seconds, 2), bar]
    });
    let sum = vec!["<b>Total</b>".to_owned(), format!("<b>{}</b>", number(total, 2)), String::new()];
    table(out, "times", "Stages", &["stage", "#seconds", "share"], rows.chain([sum]));
}

pub(super) fn failure(out: &mut String, failure: &Failure) {
    let _ = write!(out, "<div class=\"jam\"><p>{}</p>", escape(&failure.sentence));
    let at = format!("node {}, retract distance {} mm", failure.node, number(failure.s_mm, 2));
    let mut rows = vec![row("Fails at", at)];
    rows.extend(failure.wall.iter().map(|wall| row("Blocked by", escape(wall))));
    rows.extend(failure.place.iter().map(|&place| row("Place in W, mm", point(place))));
    table(out, "pairs", "Where it fails", &[], rows);
    out.push_str("</div>");
}

pub(super) fn smoothness(out: &mut String, axes: &[Smoothness]) {
    if axes.is_empty() {
        return;
    }
    let rows = axes.iter().map(|a| {
        vec![
            format!("{} <small>{}</small>", a.axis, a.unit),
            small(a.total_variation),
            small(a.rms_second_difference),
            small(a.max_second_difference),
            a.sign_changes_first_difference.to_string(),
        ]
    });
    let head = ["axis", "#total variation", "#RMS 2nd difference", "#greatest", "#turns back"];
    table(out, "", "Smoothness over equal steps", &head, rows);
}

pub(super) fn least_clearance(out: &mut String, e: &ElectrodeReport) {
    if let (Some(at), Some(mm)) = (&e.least_clearance_at, e.least_clearance_mm) {
        let rows = [
            row("Distance, mm", number(mm, 5)),
            row("To", escape(&at.surface)),
            row("Withdrawn, mm", format!("{} (row {})", number(at.s_mm, 3), number(at.row, 2))),
            row("Pose X Y Z A B C", pose_cells(&at.pose).join(" ")),
            row("On the electrode, W, mm", point(at.on_electrode)),
            row("On the blisk, W, mm", point(at.on_blisk)),
        ];
        table(out, "pairs", "Least clearance", &[], rows);
    }
}

fn pose_cells(p: &PoseReport) -> Vec<String> {
    let mm = [p.x_mm, p.y_mm, p.z_mm].map(|v| number(v, 3));
    let deg = [p.a_deg, p.b_deg, p.c_deg].map(|v| number(v, 3));
    mm.into_iter().chain(deg).collect()
}

pub(super) fn files(out: &mut String, files: &[String]) {
    if !files.is_empty() {
        // Links stay inside the folder of the report.
        let name = |f: &String| {
            let f = escape(file_name(f));
            vec![format!("<a href=\"./{f}\">{f}</a>")]
        };
        table(out, "pairs", "Files", &[], files.iter().map(name));
    }
}

/// What was written, and in which frame.
pub(super) fn written(out: &mut String, written: &Written) {
    let mut rows = vec![
        row("Electrode meshes", written.electrode_frame.name()),
        row("Path rows", "workpiece frame W"),
        row("NC programs", format!("post {}, all axes zero in the final pose", escape(&written.post))),
        row("Files", written.files.iter().map(|f| escape(file_name(f))).collect::<Vec<_>>().join(", ")),
    ];
    if !written.not_asked_for.is_empty() {
        rows.push(row("Not requested", written.not_asked_for.join(", ")));
    }
    table(out, "pairs", "Written", &[], rows);
}

pub(super) fn nodes(out: &mut String, nodes: &[NodeReport]) {
    if nodes.is_empty() {
        return;
    }
    let objective = nodes.iter().any(|n| n.objective.is_some());
    let distances = nodes.iter().any(|n| n.distances_mm.is_some());
    let rows = nodes.iter().map(|n| {
        let mut cells = vec![n.node.to_string(), number(n.s_mm, 2)];
        cells.extend(pose_cells(&n.pose));
        cells.push(number(n.clearance_mm, 4));
        if objective {
            let values = n.objective.map(|o| [o.smoothness, o.centring, o.total]);
            cells.extend((0..3).map(|i| values.map_or("\u{2013}".to_owned(), |v| small(v[i]))));
        }
        if distances {
            let four = n.distances_mm.map(|d| [Some(d.low_wall), Some(d.high_wall), d.hub, d.shroud]);
            let cell = |d: Option<f64>| d.map_or("\u{2013}".to_owned(), |d| number(d, 3));
            cells.extend(four.unwrap_or_default().map(cell));
        }
        cells
    });
    let mut head =
        vec!["#node", "#s mm", "#X mm", "#Y mm", "#Z mm", "#A \u{b0}", "#B \u{b0}", "#C \u{b0}", "#clearance mm"];
    if objective {
        head.extend(["#Obj1", "#Obj2", "#objective"]);
    }
    if distances {
        head.extend(["#low wall mm", "#high wall mm", "#hub mm", "#shroud mm"]);
    }
    table(out, "nodes", "Nodes, final pose first", &head, rows);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_listed_leaf_by_leaf() {
        let mut rows = Vec::new();
        flatten(
            &mut rows,
            "",
            &serde_json::json!({"plan": {"weights": {"a1": 0.5}}, "blisk": {"mesh": "<x>"}, "n": [1, 2]}),
        );
        let expected = [["blisk.mesh", "&lt;x&gt;"], ["n", "[1, 2]"], ["plan.weights.a1", "0.5"]];
        assert_eq!(rows, expected.map(|r| r.map(str::to_owned).to_vec()));
    }
}
