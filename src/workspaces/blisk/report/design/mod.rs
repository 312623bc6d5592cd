//! Sets of electrodes side by side: hours against number of electrodes.

use serde::Serialize;

use crate::workspaces::blisk::job::design::{Design, DesignLimits, DesignRow};
use crate::workspaces::blisk::report::{InputFile, ReportError};
use burning::duration::Spread;
use files::report::plot::{Plot, Series};
use files::report::{Template, file_name, quoted};
use files::{Entry, ParameterList};

/// Version of the keys of `design.json`.
pub const SCHEMA: u32 = 2;

/// The answer of a joint search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DesignReport {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Version of the program.
    pub program_version: &'static str,
    /// Files that went in.
    pub inputs: Vec<InputFile>,
    /// The answer in a sentence.
    pub sentence: String,
    /// Limits of the sets.
    pub limits: DesignLimits,
    /// The sets, and what was left out.
    #[serde(flatten)]
    pub design: Design,
    /// Every parameter of the job, defaults included.
    pub parameters: ParameterList,
}

/// Columns of `design.csv`.
const COLUMNS: &str = "set,parts,columns,plane,enter,low_reduction_deg,high_reduction_deg,radial_reduction_mm,electrodes,needed,is_wear_known,\
    channel_min,wheel_h,residual_mm,is_more_left,left_mm3,least_thickness_mm,certified_mm,is_best,breaks";

/// The value with so many decimals, or nothing.
fn cell(value: Option<f64>, decimals: usize) -> String {
    value.map(|value| format!("{value:.decimals$}")).unwrap_or_default()
}

fn hours(row: &DesignRow) -> Option<f64> {
    row.wheel.map(|Spread { mean, .. }| mean / 60.0)
}

impl DesignReport {
    /// The answer as JSON.
    ///
    /// # Errors
    /// [`ReportError::Json`], which nothing in it could cause.
    pub fn json(&self) -> Result<String, ReportError> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// A row for each set; cells are empty where a figure is not known. Figures of stages have `+` between them, those of parts `/`.
    pub fn csv(&self) -> String {
        let mut csv = format!("{COLUMNS}\n");
        for (i, row) in self.design.rows.iter().enumerate() {
            let reduction = |wall: usize| row.stage_cell(|stage| stage.size.reduction_cells()[wall].clone());
            let cells = [
                (i + 1).to_string(),
                row.stage_cell(|stage| stage.size.parts.to_string()),
                row.stage_cell(|stage| stage.columns.to_string()),
                row.stage_cell(|stage| cell(stage.plane, 3)),
                row.stage_cell(|stage| stage.size.enter.name().to_owned()),
                reduction(0),
                reduction(1),
                row.stage_cell(|stage| stage.radial_reduction_mm.to_string()),
                row.electrodes.to_string(),
                row.needed.map(|needed| needed.to_string()).unwrap_or_default(),
                row.is_wear_known.to_string(),
                cell(row.channel.map(|channel| channel.mean), 3),
                cell(hours(row), 3),
                cell(row.residual_mm, 4),
                row.is_more_left.to_string(),
                cell(row.left_mm3, 3),
                format!("{:.4}", row.least_thickness_mm),
                format!("{:.4}", row.certified_mm),
                row.is_best.to_string(),
                quoted(&row.breaks.join("; ")),
            ];
            csv += &(cells.join(",") + "\n");
        }
        csv
    }

    /// The answer as one self-contained page.
    ///
    /// # Errors
    /// [`ReportError::Page`], which a test of the template keeps from happening.
    pub fn html(&self) -> Result<String, ReportError> {
        const TEMPLATE: Template = Template { name: "design.html.jinja", text: include_str!("design.html.jinja") };
        #[derive(Serialize)]
        struct Page<'a> {
            design: &'a DesignReport,
            parameters: &'a [Entry],
            part: &'a str,
            has_best: bool,
            words: Vec<String>,
            needed: Vec<String>,
            hours: Vec<String>,
            residual: Vec<String>,
            plot: Option<String>,
        }
        let rows = &self.design.rows;
        Ok(files::report::page(
            &TEMPLATE,
            &Page {
                design: self,
                parameters: &self.parameters.entries,
                part: self.inputs.first().map_or("", |input| file_name(&input.path)),
                has_best: self.design.fastest().is_some(),
                words: rows.iter().map(DesignRow::words).collect(),
                needed: rows.iter().map(DesignRow::needed_cell).collect(),
                hours: rows.iter().map(DesignRow::hours_cell).collect(),
                residual: rows.iter().map(DesignRow::residual_cell).collect(),
                plot: self.plot(),
            },
        )?)
    }

    /// Hours of the wheel against the electrodes that it needs: the best sets in the first colour, joined, the others in the
    /// second.
    fn plot(&self) -> Option<String> {
        let rows = || self.design.rows.iter().enumerate();
        let at = |row: &DesignRow| Some([row.needed? as f64, hours(row)?]);
        let points =
            |is_best: bool| rows().filter(move |(_, row)| row.is_best == is_best).filter_map(|(_, row)| at(row));
        let [best, others]: [Vec<[f64; 2]>; 2] = [true, false].map(|is_best| points(is_best).collect());
        let mut front = best.clone();
        front.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        let marks = rows().filter(|(_, row)| row.is_best).filter_map(|(i, row)| Some((at(row)?, (i + 1).to_string())));
        let series = vec![
            Series { points: front, class: "c0", dots: false },
            Series { points: others, class: "c1", dots: true },
            Series { points: best, class: "c0", dots: true },
        ];
        let has_points = series.iter().any(|series| !series.points.is_empty());
        let plot = Plot {
            title: "Hours of the wheel".to_owned(),
            x_label: "electrodes for the wheel".to_owned(),
            size: [1100.0, 320.0],
            marks: marks.collect(),
            least_range: 1.0,
            series,
            ..Plot::default()
        };
        has_points.then(|| plot.svg())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::blisk::document::job_file::PlanJob;
    use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
    use crate::workspaces::blisk::job::design::StageSet;
    use crate::workspaces::blisk::job::sizing::SizeRow;
    use wheel::electrode::{ElectrodeParams, EnterSide};

    fn row(wheel: Option<f64>, breaks: &[&str]) -> DesignRow {
        let size = SizeRow {
            stage: None,
            parts: 2,
            enter: EnterSide::MinusX,
            reduction_deg: vec![[1.0, 1.25]],
            part: Vec::new(),
            least_thickness_mm: 2.5,
            volume_mm3: 100.0,
            certified_mm: 0.0995,
            limit: None,
            raised_deg: 0.0,
        };
        DesignRow {
            stages: vec![StageSet { size, columns: 1, radial_reduction_mm: 0.5, plane: Some(0.4) }],
            least_thickness_mm: 2.5,
            certified_mm: 0.0995,
            electrodes: 2,
            needed: wheel.map(|_| 8),
            is_wear_known: wheel.is_some(),
            needed_text: vec!["4".to_owned(), "4".to_owned()],
            channel: wheel.map(|minutes| Spread::exactly(minutes / 60.0)),
            wheel: wheel.map(Spread::exactly),
            no_minutes: wheel.is_none().then(|| "the rate of step <S1> is missing".to_owned()),
            residual_mm: Some(0.25),
            is_more_left: false,
            left_mm3: Some(12.0),
            breaks: breaks.iter().map(|&word| word.to_owned()).collect(),
            is_best: wheel.is_some() && breaks.is_empty(),
            electrode: ElectrodeParams::default(),
        }
    }

    fn report() -> DesignReport {
        let design = Design {
            rows: vec![row(Some(6000.0), &[]), row(Some(5400.0), &["thickness 2.5 mm, for 3 mm"]), row(None, &[])],
            left_out: vec!["3 parts: too thin".to_owned()],
        };
        DesignReport {
            schema: SCHEMA,
            program_version: "0",
            inputs: Vec::new(),
            sentence: design.sentence(),
            limits: DesignLimits { residual_mm: None, thickness_mm: 3.0 },
            design,
            parameters: FIELDS.list(&PlanJob::demonstration()),
        }
    }

    #[test]
    fn figures_that_are_not_known_are_empty_and_never_zero() {
        let csv = report().csv();
        let rows: Vec<&str> = csv.lines().collect();
        assert_eq!(
            rows[1],
            "1,2,1,0.400,-x,1.000,1.250,0.5,2,8,true,100.000,100.000,0.2500,false,12.000,2.5000,0.0995,true,"
        );
        let mut staged = report();
        let first = &mut staged.design.rows[0].stages;
        first.push(first[0].clone());
        first[1].size.reduction_deg = vec![[0.5, 0.75], [1.0, 1.25]];
        let csv = staged.csv();
        let cells = csv.lines().nth(1).unwrap();
        assert!(
            cells.starts_with("1,2+2,1+1,0.400+0.400,-x+-x,1.000+0.500/1.000,1.250+0.750/1.250,0.5+0.5,2,8,"),
            "{cells}"
        );
        assert!(rows[2].ends_with(",false,\"thickness 2.5 mm, for 3 mm\""), "{csv}");
        assert!(rows[3].contains(",0.5,2,,false,,,0.2500,"), "{csv}");
        let json: serde_json::Value = serde_json::from_str(&report().json().unwrap()).unwrap();
        assert!(json["rows"][2]["wheel"].is_null() && json["rows"][0]["wheel"]["mean"] == 6000.0);
    }

    #[test]
    fn the_page_names_the_fastest_and_what_was_left_out() {
        let page = report().html().unwrap();
        assert!(page.contains("100.0 h for the wheel") && page.contains("3 parts: too thin"), "{page}");
        assert!(page.contains("rate of step &lt;S1&gt;") && page.contains("<svg"), "{page}");
        let none = DesignReport { design: Design::default(), ..report() };
        assert!(!none.html().unwrap().contains("<svg class=\"plot\""));
    }
}
