//! What a verification of a path file found, as `verify.json` for programs and `verify.html` for people.

use files::report::{Template, page};
use serde::Serialize;

use crate::workspaces::blisk::report::page::clearances_plot;
use crate::workspaces::blisk::report::{ClearancePlace, ReportError, VerifiedDigests};
use feed::certificate::{Certificate, TravelVerdict};
use feed::path::FeedPath;
use feed::verify::setting::{SettingErrors, SettingRoom, TooFar};
use files::report::plot::Plot;
use wheel::channel::Surface;

/// Version of the keys of `verify.json`.
pub const SCHEMA: u32 = 1;

/// A file that went into the verification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VerifiedFile {
    /// Role of the file: blisk, electrode, path.
    pub role: &'static str,
    /// Path that the file was read from.
    pub path: String,
    /// SHA-256 of its bytes, hex.
    pub sha256: String,
}

/// What is known of the travel of the axes; mm or degrees.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TravelReport {
    /// Whether limits were given.
    pub judged: bool,
    /// The first row that is beyond them, if one is.
    pub beyond: Option<BeyondTravelReport>,
}

/// A row beyond the travel of an axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[allow(missing_docs)]
pub struct BeyondTravelReport {
    pub axis: char,
    pub row: usize,
    pub value: f64,
    pub limit: f64,
    pub unit: &'static str,
}

impl From<TravelVerdict> for TravelReport {
    fn from(verdict: TravelVerdict) -> Self {
        let TravelVerdict::Beyond(b) = verdict else {
            return Self { judged: verdict != TravelVerdict::NotJudged, beyond: None };
        };
        let (value, limit, unit) = b.in_file_units();
        Self {
            judged: true,
            beyond: Some(BeyondTravelReport { axis: b.axis.letter(), row: b.row, value, limit, unit }),
        }
    }
}

/// The setting errors that a path bears.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SettingReport {
    /// The errors that were asked about.
    pub asked: SettingErrors,
    /// Whether the clearance is proven with all of them.
    pub holds: bool,
    /// Clearance that has to be left (mm).
    pub least_clearance_mm: f64,
    /// The largest errors of that shape with which it is proven.
    pub largest: SettingErrors,
    /// The largest as a multiple of those asked about.
    pub scale: f64,
    /// Errors just beyond that leave less.
    pub beyond: Option<TooFar>,
    /// Name of the surface that the electrode comes too near to with these.
    pub beyond_surface: Option<&'static str>,
    /// The answer in a sentence.
    pub sentence: String,
}

impl SettingReport {
    /// The figures of `room`, with the names of surfaces.
    pub fn of(room: &SettingRoom, surface_name: impl Fn(Surface) -> &'static str) -> Self {
        Self {
            asked: room.asked,
            holds: room.holds(),
            least_clearance_mm: room.least_mm,
            largest: room.largest(),
            scale: room.scale,
            beyond: room.beyond,
            beyond_surface: room.beyond.map(|beyond| surface_name(beyond.surface)),
            sentence: room.sentence(),
        }
    }
}

/// The verdict on a path file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VerifyReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the program.
    pub program_version: &'static str,
    /// The files.
    pub inputs: Vec<VerifiedFile>,
    /// Whether the clearance is proven from outside to the final pose, and no axis is beyond travel that is known.
    pub verified: bool,
    /// Spark gap (mm).
    pub required_clearance_mm: f64,
    /// How far below it is accepted (mm).
    pub tolerance_mm: f64,
    /// Proven lower bound (mm).
    pub certified_clearance_mm: f64,
    /// Smallest clearance met (mm).
    pub least_clearance_mm: f64,
    /// Place of the smallest clearance met.
    pub least_clearance_at: ClearancePlace,
    /// Whether the path leads from wholly outside the blisk to the final pose.
    pub starts_outside_and_ends_at_zero: bool,
    /// Travel of the axes.
    pub travel: TravelReport,
    /// What was verified: meshes in W, bit for bit.
    pub sha256: VerifiedDigests,
    /// Rows of the path.
    pub rows: usize,
    /// Setting errors that the path bears, where it was asked about them.
    pub setting: Option<SettingReport>,
    /// The verdict in a sentence.
    pub sentence: String,
    /// `[s, clearance]` at every row, for the plot (mm).
    #[serde(skip)]
    pub clearances: Vec<[f64; 2]>,
}

impl VerifyReport {
    /// The report on `path`; `surface` is the name of the surface that the least clearance is to.
    pub fn new(path: &FeedPath, certificate: &Certificate, surface: &str, inputs: Vec<VerifiedFile>) -> Self {
        let c = certificate;
        Self {
            schema: SCHEMA,
            program_version: env!("CARGO_PKG_VERSION"),
            inputs,
            verified: c.holds(),
            required_clearance_mm: c.required(),
            tolerance_mm: c.tolerance(),
            certified_clearance_mm: c.certified(),
            least_clearance_mm: c.least().distance,
            least_clearance_at: ClearancePlace::of(c.least(), surface),
            starts_outside_and_ends_at_zero: c.ends_right(),
            travel: c.travel().into(),
            sha256: VerifiedDigests::of(c),
            rows: path.rows.len(),
            setting: None,
            sentence: sentence(c, surface),
            clearances: path.rows.iter().zip(c.row_clearance()).map(|(row, &clearance)| [row.s, clearance]).collect(),
        }
    }

    /// The report with the setting errors that the path bears.
    pub fn with_setting(self, room: &SettingRoom, surface_name: impl Fn(Surface) -> &'static str) -> Self {
        Self { setting: Some(SettingReport::of(room, surface_name)), ..self }
    }

    /// The report as JSON.
    ///
    /// # Errors
    /// [`ReportError::Json`], which nothing in it could cause.
    pub fn json(&self) -> Result<String, ReportError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The report as one self-contained page.
    ///
    /// # Errors
    /// [`ReportError::Page`], which a test of the template keeps from happening.
    pub fn html(&self) -> Result<String, ReportError> {
        const TEMPLATE: Template = Template { name: "verify.html.jinja", text: include_str!("verify.html.jinja") };
        #[derive(Serialize)]
        struct Page<'a> {
            report: &'a VerifyReport,
            path_file: &'a str,
            plot: String,
        }
        let path_file = self.inputs.iter().find(|i| i.role == "path").map_or("", |i| i.path.as_str());
        Ok(page(&TEMPLATE, &Page { report: self, path_file, plot: self.plot().svg() })?)
    }

    fn plot(&self) -> Plot {
        clearances_plot(self.clearances.clone(), self.required_clearance_mm)
    }
}

fn sentence(c: &Certificate, surface: &str) -> String {
    let verdict = if c.holds() { "verified" } else { "NOT verified" };
    let ends = if c.ends_right() { "" } else { "; the path does not lead from outside the blisk to the final pose" };
    let travel = match c.travel() {
        TravelVerdict::NotJudged => "; travel of the axes not judged: no machine is known".to_owned(),
        TravelVerdict::Within => "; all axes within their travel".to_owned(),
        TravelVerdict::Beyond(beyond) => format!("; {beyond}"),
    };
    format!(
        "{verdict}: certified clearance {:.5} mm, least met {:.5} mm, required {:.5} mm less {:.5} mm; least against \
         the {surface} at row {:.2}, {:.3} mm before the final pose{ends}{travel}",
        c.certified(),
        c.least().distance,
        c.required(),
        c.tolerance(),
        c.least().row,
        c.least().s
    )
}

#[cfg(test)]
mod tests {
    use files::report::{escape, number};

    use super::*;
    use feed::machine::TravelLimits;
    use feed::pose::Axis;
    use feed::verify::VerifyOptions;
    use nc::fixtures;
    use wheel::electrode::EntrySide;

    fn verified(travel: Option<TravelLimits>) -> Certificate {
        let scene = fixtures::Scene::new(EntrySide::MinusX);
        scene.verified(&scene.path, &VerifyOptions::default(), travel).unwrap()
    }

    fn report(certificate: &Certificate) -> VerifyReport {
        let file = VerifiedFile { role: "path", path: "a/<b>.csv".to_owned(), sha256: "0".to_owned() };
        VerifyReport::new(&fixtures::path(), certificate, "hub", vec![file])
    }

    #[test]
    fn travel_that_was_not_judged_is_said_so_and_travel_beyond_is_named() {
        let none = report(&verified(None));
        assert!(none.verified && !none.travel.judged && none.sentence.contains("not judged"));
        let within = report(&verified(Some(TravelLimits::UNLIMITED)));
        assert!(within.verified && within.travel.judged);
        // C turns a little the other way first, seen from the final pose.
        let certificate = verified(Some(TravelLimits::UNLIMITED.with(Axis::C, [-0.001, 1.0])));
        let TravelVerdict::Beyond(found) = certificate.travel() else { panic!("{certificate:?}") };
        assert!(found.row > 0 && found.value < -0.001, "{found:?}");
        let beyond = report(&certificate);
        assert!(
            !beyond.verified && beyond.html().unwrap().contains("Not verified.") && beyond.sentence.contains("axis C")
        );
        let json: serde_json::Value = serde_json::from_str(&beyond.json().unwrap()).unwrap();
        let at = &json["travel"]["beyond"];
        assert_eq!((&at["axis"], &at["row"], &at["unit"]), (&"C".into(), &found.row.into(), &"deg".into()));
        assert!((at["value"].as_f64().unwrap() - found.value.to_degrees()).abs() < 1e-12);
    }

    #[test]
    fn the_page_escapes_names_and_needs_nothing_from_outside() {
        let report = report(&fixtures::certificate(&fixtures::path()));
        let html = report.html().unwrap();
        let at = &report.least_clearance_at;
        let [lengths, angles] =
            [[at.pose.x_mm, at.pose.y_mm, at.pose.z_mm], [at.pose.a_deg, at.pose.b_deg, at.pose.c_deg]];
        let numbers =
            |values: &[f64], between: &str| values.iter().map(|v| number(*v, 3)).collect::<Vec<_>>().join(between);
        for (name, value) in [
            ("Required, mm", number(report.required_clearance_mm, 5)),
            ("Tolerance, mm", number(report.tolerance_mm, 5)),
            ("Certified, at least, mm", number(report.certified_clearance_mm, 5)),
            ("Least met, mm", number(report.least_clearance_mm, 5)),
            ("To", at.surface.clone()),
            ("Withdrawn, mm", format!("{} (row {} of {})", number(at.s_mm, 3), number(at.row, 2), report.rows)),
            ("Pose X Y Z A B C", numbers(&[lengths, angles].concat(), " ")),
            ("On the electrode, W, mm", numbers(&at.on_electrode, ", ")),
            ("On the blisk, W, mm", numbers(&at.on_blisk, ", ")),
            ("From outside to the final pose", "yes".to_owned()),
            ("File", "<span class=\"path\">a/&lt;b&gt;.csv</span>".to_owned()),
            ("SHA-256", "<code>0</code>".to_owned()),
        ] {
            assert!(html.contains(&format!("<td>{name}</td><td>{value}</td>")), "{name}: {value}");
        }
        assert!(
            html.contains(&escape(&report.sentence)) && html.contains("<svg") && html.contains("schema 1</footer>")
        );
        assert!(html.contains("&lt;b&gt;.csv") && !html.contains("<b>.csv") && !html.contains("http"));
        for tag in ["section", "table", "tr", "td", "svg", "div", "p", "main"] {
            let opened = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
            assert_eq!(opened, html.matches(&format!("</{tag}>")).count(), "{tag}");
        }
    }
}
