//! The report as one page without scripts: verdicts first, then figures, plots and tables.

use std::fmt::Write;

use crate::workspaces::blisk::report::curves::{axis_plots, moving_axes};
use crate::workspaces::blisk::report::leftover;
use crate::workspaces::blisk::report::tables;
use crate::workspaces::blisk::report::{Convergence, ElectrodeReport, Motion, Picture, Report};
use files::svg_plot::{Plot, Series, escape};

pub use files::report::{STYLE, data_url, file_name};

/// Nodes whose search is shown generation by generation, beside that of the first.
const CONVERGENCE_PLOTS: usize = 3;

/// The whole page.
pub(super) fn page(report: &Report) -> String {
    let part = report.inputs.first().map_or("", |input| file_name(&input.path));
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>Feed path report: {part}</title>\
         <style>{STYLE}</style></head><body><main>",
        part = escape(part)
    );
    header(&mut out, report, part);
    pictures(&mut out, report);
    report.electrodes.iter().for_each(|e| electrode(&mut out, e));
    left(&mut out, report);
    out.push_str("<section><h2>Blisk and inputs</h2><div class=\"cols\">");
    tables::blisk(&mut out, &report.blisk);
    tables::inputs(&mut out, &report.inputs);
    out.push_str("</div></section><section><h2>Parameters</h2><div class=\"cols\">");
    tables::symbols(&mut out, &report.symbols);
    tables::parameters(&mut out, &report.parameters);
    out.push_str("</div></section><section><h2>Files and time</h2>");
    tables::written(&mut out, &report.written);
    tables::times(&mut out, &report.times);
    let version = escape(&report.program_version);
    let _ = write!(out, "</section><footer>Sparkpath {version}, report schema {}</footer>", report.schema);
    out.push_str("</main></body></html>\n");
    out
}

fn header(out: &mut String, report: &Report, part: &str) {
    let class = if report.verdict.exit_code == 0 { "ok" } else { "no" };
    let _ = write!(
        out,
        "<header><h1>Feed path report <span>{}</span></h1><p class=\"verdict {class}\">{}</p></header>",
        escape(part),
        escape(&report.verdict.sentence)
    );
}

fn pictures(out: &mut String, report: &Report) {
    if let Some(why) = &report.no_pictures {
        let _ = write!(out, "<p class=\"soft\">This report has no pictures: {}</p>", escape(why));
    }
    if report.pictures.is_empty() {
        return;
    }
    out.push_str("<section class=\"pictures\">");
    report.pictures.iter().for_each(|picture| figure(out, picture));
    out.push_str("</section>");
}

fn figure(out: &mut String, picture: &Picture) {
    let (title, caption) = (escape(&picture.title), escape(&picture.caption));
    let data = data_url("image/png", &picture.png);
    let _ = write!(out, "<figure><img alt=\"{title}\" src=\"{data}\"><figcaption><b>{title}.</b> {caption}");
    if !picture.legend.is_empty() {
        out.push_str("<span class=\"legend\">");
        for (colour, what) in &picture.legend {
            let (colour, what) = (escape(colour), escape(what));
            let _ = write!(out, "<span><i style=\"background:{colour}\"></i>{what}</span>");
        }
        out.push_str("</span>");
    }
    out.push_str("</figcaption></figure>");
}

fn left(out: &mut String, report: &Report) {
    if let Some(leftover) = &report.leftover {
        leftover::section(out, leftover);
    } else if let Some(why) = &report.no_leftover {
        let _ = write!(out, "<section><h2>Residual stock</h2><p class=\"soft\">{}</p></section>", escape(why));
    }
}

fn electrode(out: &mut String, e: &ElectrodeReport) {
    let share = if e.share.is_empty() { String::new() } else { format!(" <span>{}</span>", escape(&e.share)) };
    let _ = write!(out, "<section><h2>Electrode {}{share}</h2>", e.index);
    let (class, word, sentence) = verdict(e);
    let _ = write!(out, "<p class=\"banner {class}\"><b>{word}</b> {sentence}</p>");
    key_figures(out, e);
    if let Some(copying) = &e.copying {
        let _ = write!(out, "<p>{}</p>", escape(&copying.sentence));
    }
    if let Some(simulation) = &e.simulation {
        simulation.html(out);
    }
    if let Some(failure) = &e.failure {
        tables::failure(out, failure);
    }
    if let Some(motion) = e.motion.as_ref().filter(|m| m.rows.len() > 1) {
        plots(out, e, motion);
    }
    convergence(out, &e.ga_convergence);
    out.push_str("<div class=\"cols\">");
    tables::smoothness(out, &e.smoothness);
    tables::least_clearance(out, e);
    tables::files(out, &e.files);
    out.push_str("</div>");
    tables::nodes(out, &e.nodes);
    out.push_str("</section>");
}

fn verdict(e: &ElectrodeReport) -> (&'static str, &'static str, String) {
    let required = format!("{:.4} mm less the tolerance of {:.4} mm", e.required_clearance_mm, e.tolerance_mm);
    match (e.extractable, e.verified, e.certified_clearance_mm) {
        (true, true, Some(certified)) => {
            let sentence = format!(
                "The whole motion is proven to keep {certified:.4} mm from the finished blisk; {required} are required."
            );
            ("ok", "Verified.", sentence)
        }
        (true, _, certified) => {
            let proven = certified.map_or("nothing is proven".to_owned(), |c| format!("only {c:.4} mm are proven"));
            let sentence =
                format!("A path was found, but {proven} where {required} are required. It must not be used.");
            ("no", "Not verified.", sentence)
        }
        (false, ..) => {
            ("no", "No path.", "Not feasible: the electrode has no extraction path at this size.".to_owned())
        }
    }
}

fn key_figures(out: &mut String, e: &ElectrodeReport) {
    let mm = |v: Option<f64>, decimals: usize| v.map(|v| format!("{v:.decimals$}"));
    let rows = e.motion.as_ref().map(|m| m.rows.len().to_string());
    let some = |text: String| Some(text);
    let figures = [
        ("required", some(format!("{:.3}", e.required_clearance_mm)), "mm"),
        ("certified, at least", mm(e.certified_clearance_mm, 4), "mm"),
        ("least met", mm(e.least_clearance_mm, 4), "mm"),
        ("enters from", Some(e.enters_from.to_uppercase()).filter(|t| !t.is_empty()), ""),
        ("nodes", Some(e.nodes.len()).filter(|n| *n > 0).map(|n| n.to_string()), ""),
        ("path rows", rows, ""),
        ("volume", some(format!("{:.0}", e.volume_mm3)), "mm\u{b3}"),
        ("least thickness", mm(e.least_thickness_mm, 2), "mm"),
        ("burn area", mm(e.burn_area_mm2, 0), "mm\u{b2}"),
    ];
    out.push_str("<dl class=\"key\">");
    for (name, value, unit) in figures {
        if let Some(value) = value {
            let value = escape(&value).replace('-', "\u{2212}");
            let _ = write!(out, "<div><dt>{name}</dt><dd>{value} <small>{unit}</small></dd></div>");
        }
    }
    out.push_str("</dl>");
}

fn plots(out: &mut String, e: &ElectrodeReport, motion: &Motion) {
    let _ = write!(out, "<div class=\"plot\">{}</div>", clearance_plot(e, motion).svg());
    out.push_str(
        "<h3>Axes against retract distance <small>dots are search nodes; feed runs from right to left</small></h3>",
    );
    let nodes: Vec<f64> = e.nodes.iter().map(|n| n.s_mm).collect();
    for axis in moving_axes(motion) {
        out.push_str("<div class=\"plot three\">");
        axis_plots(motion, axis, &nodes).iter().for_each(|plot| out.push_str(&plot.svg()));
        out.push_str("</div>");
    }
}

fn clearance_plot(e: &ElectrodeReport, motion: &Motion) -> Plot {
    let mut points: Vec<_> = motion.rows.iter().zip(&motion.clearance).map(|(r, &c)| [r.s, c]).collect();
    points.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let least = e.least_clearance_at.as_ref().zip(e.least_clearance_mm);
    let mark = least.map(|(at, mm)| ([at.s_mm, mm], format!("{mm:.4} mm, {}", at.surface)));
    Plot {
        title: "Clearance to the finished blisk, mm".to_owned(),
        x_label: "s, mm retracted".to_owned(),
        log_y: true,
        size: [1100.0, 260.0],
        series: vec![Series { points, class: "c0", dots: false }],
        levels: vec![(e.required_clearance_mm, "required gap".to_owned())],
        marks: mark.into_iter().collect(),
        ..Plot::default()
    }
}

/// First and last best objective over the nodes, then a few nodes generation by generation.
fn convergence(out: &mut String, all: &[Convergence]) {
    if all.is_empty() {
        return;
    }
    out.push_str("<h3>Genetic search <small>best objective of each node at its first and last generation; mean dashed</small></h3>");
    let of = |value: fn(&Vec<f64>) -> Option<&f64>| -> Vec<[f64; 2]> {
        all.iter().filter_map(|c| value(&c.best).map(|v| [c.node as f64, *v])).collect()
    };
    let overview = Plot {
        title: "Best objective, first and last generation".to_owned(),
        x_label: "node".to_owned(),
        size: [720.0, 190.0],
        series: vec![
            Series { points: of(|b| b.first()), class: "faint", dots: false },
            Series { points: of(|b| b.last()), class: "c0", dots: false },
        ],
        ..Plot::default()
    };
    let _ = write!(out, "<div class=\"plot two\">{}", overview.svg());
    // A few nodes from the final pose outwards, evenly spread.
    let last = all.len() - 1;
    let mut shown: Vec<usize> = (0..=CONVERGENCE_PLOTS).map(|i| i * last / CONVERGENCE_PLOTS).collect();
    shown.dedup();
    let plots: Vec<_> = shown.into_iter().map(|i| generation_plot(&all[i]).svg()).collect();
    let _ = write!(out, "{}</div><div class=\"plot three\">{}</div>", plots[0], plots[1..].concat());
}

fn generation_plot(c: &Convergence) -> Plot {
    let curve = |values: &[f64]| values.iter().enumerate().map(|(i, v)| [i as f64, *v]).collect();
    Plot {
        title: format!("Node {}", c.node),
        x_label: "generation".to_owned(),
        size: [360.0, 190.0],
        series: vec![
            Series { points: curve(&c.mean), class: "mean", dots: false },
            Series { points: curve(&c.best), class: "c0", dots: false },
        ],
        ..Plot::default()
    }
}
