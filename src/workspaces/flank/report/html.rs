//! The report on a flank path as one page without scripts: the answer first, then maps, figures, plots, checks.

use std::fmt::Write;

use crate::workspaces::blisk::report::html::{STYLE, data_url};
use crate::workspaces::blisk::report::tables::{number, parameters, row, table};
use crate::workspaces::flank::report::{
    AxisEntry, CheckEntry, ClearanceEntry, DeviationMaps, Figures, FlankPicture, FlankReport, MachineEntry, PathEntry,
    SlowedEntry, SurfaceEntry,
};
use files::svg_plot::{Plot, Series, escape};
use flank::plan::WITHIN_ROUNDING;

/// Ranks whose sum is up to this share of the initial one are shown closely.
const CLOSE: f64 = 1.25;

/// The whole page.
pub(super) fn page(report: &FlankReport, maps: &DeviationMaps) -> String {
    let name = escape(&report.name);
    let mut out = format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>Flank: {name}</title>\
         <style>{STYLE}</style></head><body><main>"
    );
    let class = if report.holds { "ok" } else { "no" };
    let sentence = escape(&report.sentence);
    let _ =
        write!(out, "<header><h1>Flank <span>{name}</span></h1><p class=\"verdict {class}\">{sentence}</p></header>");
    troubles(&mut out, report);
    key_figures(&mut out, report);
    deviation_maps(&mut out, report, maps);
    figures(&mut out, report);
    ranks(&mut out, report);
    checks(&mut out, report);
    if let Some(entry) = &report.machine {
        machine(&mut out, entry);
    }
    warnings(&mut out, &report.warnings);
    out.push_str("<section><h2>Surface and cutter</h2><div class=\"cols\">");
    surface(&mut out, &report.surface, report.grid);
    cutter(&mut out, report);
    out.push_str("</div></section><section><h2>Parameters</h2>");
    parameters(&mut out, &report.parameters);
    let (version, schema) = (escape(report.program_version), report.schema);
    let _ = writeln!(out, "</section><footer>Sparkpath {version}, flank schema {schema}</footer></main></body></html>");
    out
}

/// What is not as it should be, in banners.
fn troubles(out: &mut String, report: &FlankReport) {
    let mut banner = |name: &str, text: &str| {
        let _ = write!(out, "<p class=\"banner no\"><b>{}</b> {}</p>", escape(name), escape(text));
    };
    for CheckEntry { name, is_overridden, text, lapsed, given_for, .. } in report.checks.iter().filter(|c| !c.holds) {
        let decided = match (is_overridden, given_for) {
            (true, Some(figures)) => format!(" (released, decided for {figures})"),
            (true, None) => " (released)".to_owned(),
            (false, _) => String::new(),
        };
        let lapsed = lapsed.as_ref().map_or_else(String::new, |why| format!("; the override: {why}"));
        banner(&format!("Check {name} fails{decided}."), &format!("{text}{lapsed}"));
    }
    if report.blocked.is_some() {
        banner("No program was written.", "A check fails; override it by its name if it does not matter.");
    }
}

fn key_figures(out: &mut String, report: &FlankReport) {
    let Some(path) = report.milled() else { return };
    let mut figures = vec![
        ("path milled", path.name.to_owned(), ""),
        ("total absolute deviation", number(path.standing.sum_mm, 3), "mm"),
        ("ratio to initial", ratio(path.ratio, 3), ""),
        ("mean of absolute values", number(1e3 * path.standing.mean_absolute_mm, 2), "\u{b5}m"),
        ("rms", number(1e3 * path.standing.rms_mm, 2), "\u{b5}m"),
        ("overcut up to", number(1e3 * report.moving_most_mm[0], 1), "\u{b5}m"),
        ("undercut up to", number(1e3 * report.moving_most_mm[1], 1), "\u{b5}m"),
        ("grid, u by v", format!("{} \u{d7} {}", report.grid[0], report.grid[1]), ""),
    ];
    if let Some(machine) = report.machine.as_ref().filter(|m| m.trouble.is_none()) {
        figures.push(("positions", machine.positions.to_string(), ""));
        figures.push(("milling", number(60.0 * machine.minutes, 1), "s"));
    }
    out.push_str("<dl class=\"key\">");
    for (name, value, unit) in figures {
        let _ = write!(out, "<div><dt>{name}</dt><dd>{value} <small>{unit}</small></dd></div>");
    }
    out.push_str("</dl>");
}

/// A share of the initial sum, unless that is nothing but rounding.
fn ratio(share: Option<f64>, decimals: usize) -> String {
    share.map_or_else(|| WITHIN_ROUNDING.to_owned(), |share| number(share, decimals))
}

fn image(out: &mut String, alt: &str, png: &[u8], style: &str) {
    let (alt, data) = (escape(alt), data_url("image/png", png));
    let _ = write!(out, "<img alt=\"{alt}\" style=\"{style}\" src=\"{data}\">");
}

fn deviation_maps(out: &mut String, report: &FlankReport, maps: &DeviationMaps) {
    const MAP: &str = "image-rendering:pixelated;aspect-ratio:2";
    const BAR: &str = "width:100%;height:12px;border:1px solid var(--rule)";
    if maps.maps.is_empty() {
        return;
    }
    let [nu, nv] = report.grid;
    let _ = write!(
        out,
        "<section><h2>Deviation over the surface</h2><p class=\"soft\">The standing cutter at {nu} \u{d7} {nv} places: u along \
         the guides to the right, v from the lower guide up. Red: stock is left (undercut). Blue: too much is taken \
         (overcut). One scale for all.</p><div class=\"plot three\">"
    );
    for FlankPicture { title, caption, png } in &maps.maps {
        out.push_str("<figure>");
        image(out, &format!("Deviation map of {title}"), png, MAP);
        let (title, caption) = (escape(title), escape(caption));
        let _ = write!(out, "<figcaption><b>{title}</b> {caption}</figcaption></figure>");
    }
    out.push_str("</div><div class=\"plot\"><div>");
    image(out, "Colours of the deviation maps", &maps.bar_png, BAR);
    // Enough to tell half of the end from all of it.
    let decimals = (2.0 - (1e3 * maps.end_mm).max(1e-6).log10().ceil()).clamp(1.0, 6.0) as usize;
    let ticks = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|share| {
        let um = 1e3 * share * maps.end_mm;
        let sign = if um > 0.0 { "+" } else { "" };
        format!("<span>{sign}{} \u{b5}m</span>", number(um, decimals))
    });
    let _ = write!(
        out,
        "<div class=\"soft\" style=\"display:flex;justify-content:space-between;font-size:12px\">{}</div></div></div></section>",
        ticks.concat()
    );
}

fn figures(out: &mut String, report: &FlankReport) {
    let [nu, nv] = report.grid;
    out.push_str("<section><h2>Figures</h2>");
    let line = |path: &PathEntry, what: &str, f: &Figures, share: Option<f64>| {
        let milled = if path.is_milled { " <small>milled</small>" } else { "" };
        let mut cells = vec![format!("<b>{}</b>{milled}", path.name), what.to_owned()];
        cells.push(number(f.sum_mm, 4));
        cells.push(ratio(share, 4));
        let micrometres =
            [f.mean_absolute_mm, f.rms_mm, f.most_overcut_mm, f.most_undercut_mm].map(|v| number(1e3 * v, 2));
        cells.extend(micrometres);
        cells.extend([number(f.sum_overcut_mm, 3), number(f.sum_undercut_mm, 3)]);
        cells
    };
    let rows = report.paths.iter().flat_map(|path| {
        let standing = line(path, "standing", &path.standing, path.ratio);
        let mut moving = line(path, "swept envelope", &path.moving, path.moving_ratio);
        moving[0] = String::new();
        [standing, moving]
    });
    let head = [
        "path",
        "cutter",
        "#sum mm",
        "#of initial",
        "#mean of absolutes \u{b5}m",
        "#rms \u{b5}m",
        "#overcut \u{b5}m",
        "#undercut \u{b5}m",
        "#sum overcut mm",
        "#sum undercut mm",
    ];
    let caption = format!("Absolute deviations over the grid of {nu} x {nv} places of the surface, edges included");
    table(out, "", &caption, &head, rows);
    comparison(out, report);
    let rows = report.paths.iter().map(|p| {
        let [first, last] = p.t_range;
        let [low, high] = p.height_range_mm;
        vec![
            p.name.to_owned(),
            if p.covers { "yes".to_owned() } else { "no".to_owned() },
            format!("{} to {}", number(first, 4), number(last, 4)),
            format!("{} to {}", number(low, 3), number(high, 3)),
            number(1e3 * p.greatest_difference_mm, 2),
            p.without.to_string(),
        ]
    });
    let head = [
        "path",
        "covers the surface",
        "#t over the surface",
        "#heights that touch mm",
        "#envelope against static, most \u{b5}m",
        "#samples not touched",
    ];
    table(out, "", "Coverage and envelope", &head, rows);
    let places = &report.locations;
    let _ = write!(
        out,
        "<p class=\"soft\">First locations: {} from u0 = {} to {}; {} touch as asked, {} were put where they come nearest. The \
         curves through them have {} control points each{} and are off them by {} \u{b5}m at most.</p></section>",
        places.count,
        number(places.u0_range[0], 4),
        number(places.u0_range[1], 4),
        places.touching,
        places.nearest,
        places.control_points,
        if places.control_points > places.control_points_asked {
            format!(", more than the {} asked for, as a ring needs them,", places.control_points_asked)
        } else {
            String::new()
        },
        number(1e3 * places.fit_mm, 2)
    );
}

/// Our ratios beside those of the paper.
fn comparison(out: &mut String, report: &FlankReport) {
    let paper = &report.paper;
    let ours: Vec<f64> = report.paths.iter().filter_map(|p| p.ratio).collect();
    let [_, chosen, refined] = ours[..] else { return };
    let text = match paper.comparable {
        Some(ratio) => format!(
            "Against the paper (P4): its method leaves {} of the initial sum on this surface; here one pass over every rank \
             leaves {}, the refined path {}.",
            number(ratio, 3),
            number(chosen, 3),
            number(refined, 3)
        ),
        None => format!(
            "For reference: the paper's method (P4) left {} of the initial sum on its surface A and {} on its surface B, with \
             a cone of 5 degrees. This is another case: here one pass over every rank leaves {}, the refined path {}.",
            number(paper.ratio_a, 3),
            number(paper.ratio_b, 3),
            number(chosen, 3),
            number(refined, 3)
        ),
    };
    let _ = write!(
        out,
        "<p>{} <span class=\"soft\">The paper's sums themselves were taken on grids that it does not give.</span></p>",
        escape(&text)
    );
}

fn ranks(out: &mut String, report: &FlankReport) {
    let ranks = &report.ranks;
    let Some(start) = report.paths.first().map(|p| p.standing.sum_mm) else { return };
    let points: Vec<[f64; 2]> =
        ranks.sums_mm.iter().enumerate().map(|(i, sum)| [(i + 1) as f64, sum.unwrap_or(f64::NAN)]).collect();
    let best = points.iter().find(|p| p[0] == ranks.best as f64);
    let marks: Vec<([f64; 2], String)> =
        best.map(|p| (*p, format!("k = {}: {}", ranks.best, number(p[1], 3)))).into_iter().collect();
    let plot = |title: &str, log_y: bool, points: Vec<[f64; 2]>, marks: &[([f64; 2], String)], size| {
        let series = vec![Series { points, class: "c0", dots: false }];
        let (title, levels) = (title.to_owned(), vec![(start, format!("initial {}", number(start, 3)))]);
        Plot {
            title,
            x_label: "rank k".to_owned(),
            log_y,
            size,
            series,
            levels,
            marks: marks.to_vec(),
            ..Plot::default()
        }
    };
    // Its figure stands in the other plot; here it would lie on the axis.
    let circles: Vec<([f64; 2], String)> = marks.iter().map(|(place, _)| (*place, String::new())).collect();
    let close = points.iter().map(|p| if p[1] <= CLOSE * start { *p } else { [p[0], f64::NAN] }).collect();
    out.push_str("<section><h2>Error over rank</h2><div class=\"plot two\">");
    out.push_str(&plot("Sum of deviations, mm, every rank", true, points, &marks, [620.0, 260.0]).svg());
    out.push_str(&plot("Near the best", false, close, &circles, [360.0, 260.0]).svg());
    let words = match ranks.best {
        0 => "The initial path is kept: it is good enough, or no rank makes its sum less.".to_owned(),
        k => format!(
            "Least at k = {k} of {}. Each candidate is measured with its true deviation, not with the linear model; what is \
             not drawn could not be measured.",
            ranks.sums_mm.len()
        ),
    };
    let _ = write!(out, "</div><p class=\"soft\">{}</p></section>", escape(&words));
}

fn place([x, y, z]: [f64; 3]) -> String {
    [x, y, z].map(|v| number(v, 3)).join(", ")
}

fn checks(out: &mut String, report: &FlankReport) {
    out.push_str("<section><h2>Checks</h2>");
    let rows = report.checks.iter().map(|c| {
        let state = match (c.holds, c.is_overridden) {
            (true, _) => "holds",
            (false, true) => "fails, overridden",
            (false, false) if c.lapsed.is_some() => "<b>fails</b>, override no longer holds",
            (false, false) => "<b>fails</b>",
        };
        let at = c.t.map_or(String::new(), |t| number(t, 4));
        vec![c.name.to_owned(), state.to_owned(), escape(&c.text), c.place.map_or(String::new(), place), at]
    });
    let milled = report.milled().map_or("", |p| p.name);
    let head = ["check", "state", "what was found", "where, mm", "#t"];
    // Columns that would be empty are left out.
    let columns = if report.checks.iter().any(|c| c.place.is_some() || c.t.is_some()) { 5 } else { 3 };
    let rows = rows.map(|row| row.into_iter().take(columns).collect::<Vec<String>>());
    table(out, "", &format!("Of the {milled} path"), &head[..columns], rows);
    if !report.clearances.is_empty() {
        let rows = report.clearances.iter().map(|ClearanceEntry { part, distance_mm, place: at, t }| {
            vec![escape(part), number(*distance_mm, 4), place(*at), number(*t, 4)]
        });
        let head = ["part of the tool", "#least clearance mm", "where, mm", "#t"];
        table(out, "", "Clearances all along the path; negative: gouge", &head, rows);
    }
    out.push_str("</section>");
}

fn machine(out: &mut String, entry: &MachineEntry) {
    let _ = write!(out, "<section><h2>Machine <small>{}</small></h2>", escape(&entry.name));
    if let Some(trouble) = &entry.trouble {
        let _ = write!(out, "<p class=\"banner no\"><b>It cannot follow.</b> {}</p></section>", escape(trouble));
        return;
    }
    let _ = write!(
        out,
        "<p>{} positions; between them tip and flutes' top leave the path by {} \u{b5}m at most, allowed: {} \u{b5}m. \
         {} seconds from the first position to the last.</p>",
        entry.positions,
        number(1e3 * entry.deviation_mm, 3),
        number(1e3 * entry.linearisation_mm, 3),
        number(60.0 * entry.minutes, 2)
    );
    slowed(out, entry.slowed.as_ref());
    out.push_str("<div class=\"plot three\">");
    entry.axes.iter().enumerate().for_each(|(i, axis)| out.push_str(&axis_plot(axis, i).svg()));
    out.push_str("</div>");
    out.push_str("</section>");
}

/// Moves that do not have the feed that was asked for.
fn slowed(out: &mut String, slowed: Option<&SlowedEntry>) {
    let Some(SlowedEntry { moves, least_share, for_axes, short }) = slowed else { return };
    let _ = write!(
        out,
        "<p class=\"soft\">{moves} moves are slower than asked for, at most down to {} % of the feed",
        number(100.0 * least_share, 1)
    );
    if let Some(axes) = for_axes {
        let _ = write!(out, "; {} so that no axis exceeds its speed, most for {}", axes.moves, axes.axis);
    }
    if let Some(short) = short {
        let _ = write!(out, "; {} as no block is shorter than the control takes", short.moves);
    }
    out.push_str(".</p>");
}

fn axis_plot(axis: &AxisEntry, i: usize) -> Plot {
    let AxisEntry { letter, unit, limits: [low, high], values } = axis;
    let limits = format!("limits {} to {}", number(*low, 0), number(*high, 0));
    Plot {
        title: format!("{letter}, {unit} ({limits})"),
        x_label: "s".to_owned(),
        least_range: 1e-3,
        size: [360.0, 190.0],
        series: vec![Series {
            points: values.clone(),
            class: ["c0", "c1", "c2", "c3", "c4", "c5"][i % 6],
            dots: false,
        }],
        ..Plot::default()
    }
}

fn warnings(out: &mut String, warnings: &[String]) {
    if warnings.is_empty() {
        return;
    }
    out.push_str("<section><h2>Notes</h2><ul>");
    for warning in warnings {
        let _ = write!(out, "<li>{}</li>", escape(warning));
    }
    out.push_str("</ul></section>");
}

/// The side of the cutter, as u runs and as the guides were given.
fn side(surface: &SurfaceEntry) -> String {
    let sign = |side: i8| if side > 0 { "+1" } else { "\u{2212}1" };
    let mut text = format!("{} as u runs, +1 where R_u \u{d7} R_v points", sign(surface.side));
    if surface.is_reversed {
        text += &format!("; u runs against the guides as given, of which it is {}", sign(-surface.side));
    }
    text
}

fn surface(out: &mut String, surface: &SurfaceEntry, [nu, nv]: [usize; 2]) {
    let range = |[a, b]: [f64; 2]| format!("{} to {}", number(a, 3), number(b, 3));
    let mut rows = vec![
        row("From", escape(&surface.source)),
        row("Side of the cutter", side(surface)),
        row("Rulings, mm", range(surface.ruling_mm)),
        row("Lower guide, mm", number(surface.guide_mm[0], 3)),
        row("Upper guide, mm", number(surface.guide_mm[1], 3)),
        row("Grid of deviations", format!("{nu} \u{d7} {nv}, even in u and v, edges included")),
    ];
    if let Some(fit) = &surface.fit {
        rows.push(row("Ruled", if fit.is_ruled { "within the tolerance" } else { "not within the tolerance" }));
        rows.push(row("Tolerance of the fit, mm", number(fit.tolerance_mm, 4)));
        rows.push(row("Face from surface, greatest, mm", number(fit.error.greatest_mm, 5)));
        rows.push(row("Face from surface, rms, mm", number(fit.error.rms_mm, 5)));
        rows.push(row("Corners alone, greatest, mm", number(fit.error_corners.greatest_mm, 5)));
        rows.push(row("Greatest at", place(fit.worst)));
        rows.push(row("Triangles themselves, up to, mm", number(fit.chord_mm, 5)));
        rows.extend(fit.words.iter().map(|w| row("Fit", escape(w))));
    }
    table(out, "pairs", "Surface", &[], rows);
}

fn cutter(out: &mut String, report: &FlankReport) {
    let cutter = &report.cutter;
    let kind = if cutter.taper_deg == 0.0 { "cylinder" } else { "cone" };
    let mut rows = vec![
        row("Name", escape(&cutter.name)),
        row("Kind", kind),
        row("Radius of the bottom, mm", number(cutter.radius_mm, 4)),
        row("Taper from axis to flute", format!("{}\u{b0}", number(cutter.taper_deg, 4))),
        row("Flutes, mm", number(cutter.length_mm, 3)),
    ];
    rows.extend(cutter.holder.iter().enumerate().map(|(i, part)| {
        let (length, low, high) = (part.length_mm, part.lower_radius_mm, part.upper_radius_mm);
        let text = format!("{} long, radius {} to {}", number(length, 2), number(low, 2), number(high, 2));
        row(&format!("Holder part {}, mm", i + 1), text)
    }));
    table(out, "pairs", "Cutter", &[], rows);
}
