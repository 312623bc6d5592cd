//! Stages in which a channel is burned: roughing, semi-finishing, finishing.

use files::Invalid;
use serde::{Deserialize, Serialize};

use super::params::{COLUMNS, GAP, PARTS, RADIAL, TURN};
use super::{ElectrodeParams, EnterSide, PartParams};

/// Most stages of a channel.
const MOST: usize = 8;
/// Finishes (VDI 3400).
const VDI: [f64; 2] = [-20.0, 60.0];

/// A stage: every part of the channel is burned in it with electrodes of its own, before the next stage begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StageParams {
    /// Name in lists.
    pub name: String,
    /// Spark gap of the stage (mm).
    pub spark_gap_mm: f64,
    /// Stock that it leaves for the later stages on every surface (mm).
    pub stock_mm: f64,
    /// Number of parts along the passage; none for that of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<usize>,
    /// 1, or 2 to divide every part left and right; none for that of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<usize>,
    /// Side of entry; none for that of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub enter: Option<EnterSide>,
    /// Own values of single parts in this stage (`[[electrode.stage.part]]`). Where there are any, or where the stage has another
    /// number of parts, nothing of `[[electrode.part]]` holds.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub part: Vec<PartParams>,
    /// Circumferential reduction of the low wall (deg); none for that of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub low_reduction_deg: Option<f64>,
    /// Circumferential reduction of the high wall (deg); none for that of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub high_reduction_deg: Option<f64>,
    /// Radial reduction (mm); none for that of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radial_reduction_mm: Option<f64>,
    /// Name of the step of the technology at which its burns end; empty to end at its finish.
    pub last_step: String,
    /// Finish at which its burns end (VDI 3400); none if it is not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finish_vdi: Option<f64>,
}

impl Default for StageParams {
    fn default() -> Self {
        Self {
            name: String::new(),
            spark_gap_mm: ElectrodeParams::default().spark_gap_mm,
            stock_mm: 0.0,
            parts: None,
            columns: None,
            enter: None,
            part: Vec::new(),
            low_reduction_deg: None,
            high_reduction_deg: None,
            radial_reduction_mm: None,
            last_step: String::new(),
            finish_vdi: None,
        }
    }
}

impl StageParams {
    fn validate(&self) -> Result<(), Invalid> {
        if self.name.trim().is_empty() {
            return Err(Invalid::of("name", "is empty; give the stage a name"));
        }
        Invalid::unless_within("spark_gap_mm", self.spark_gap_mm, GAP, "mm")?;
        Invalid::unless_within("stock_mm", self.stock_mm, [0.0, GAP[1] - self.spark_gap_mm], "mm")?;
        if let Some(vdi) = self.finish_vdi {
            Invalid::unless_within("finish_vdi", vdi, VDI, "VDI")?;
        }
        let own = [
            ("parts", self.parts.map(|n| n as f64), PARTS, ""),
            ("columns", self.columns.map(|n| n as f64), COLUMNS, ""),
            ("low_reduction_deg", self.low_reduction_deg, TURN, "deg"),
            ("high_reduction_deg", self.high_reduction_deg, TURN, "deg"),
            ("radial_reduction_mm", self.radial_reduction_mm, RADIAL, "mm"),
        ];
        let mut given = own.into_iter().filter_map(|(key, value, range, unit)| Some((key, value?, range, unit)));
        given.try_for_each(|(key, value, range, unit)| Invalid::unless_within(key, value, range, unit))
    }

    /// How much smaller than the finished surface an electrode of the stage is (mm).
    fn undersize_mm(&self) -> f64 {
        // A sum of decimal fractions is rounded back to one.
        ((self.spark_gap_mm + self.stock_mm) * 1e9).round() / 1e9
    }
}

impl ElectrodeParams {
    /// Checks that every stage is possible, that names differ, that each comes nearer to the surface than the one before or as
    /// near, and that the last one leaves nothing.
    pub(super) fn validate_stages(&self) -> Result<(), Invalid> {
        let Some(last) = self.stage.len().checked_sub(1) else { return Ok(()) };
        let rows = || format!("a list of {} rows", self.stage.len());
        if self.mesh.is_some() {
            return Err(Invalid::new("stage", rows(), "an electrode mesh of your own has no stages; remove them"));
        }
        if self.stage.len() > MOST {
            return Err(Invalid::new("stage", rows(), format!("at most {MOST} stages are possible")));
        }
        for (i, stage) in self.stage.iter().enumerate() {
            stage.validate().map_err(|problem| problem.within(&format!("stage[{i}]")))?;
            if !stage.part.is_empty() {
                self.of_stage(i).validate_parts().map_err(|problem| problem.within(&format!("stage[{i}]")))?;
            }
            if self.stage[..i].iter().any(|before| before.name.trim() == stage.name.trim()) {
                let remedy = "another stage has this name; give each its own";
                return Err(Invalid::new(format!("stage[{i}].name"), &stage.name, remedy));
            }
        }
        for (i, pair) in self.stage.windows(2).enumerate() {
            let [before, after] = [&pair[0], &pair[1]].map(StageParams::undersize_mm);
            if after > before {
                let remedy = format!(
                    "with its stock the stage stays {after} mm away from the surface, and {before} mm are left to it: it has \
                     nothing to burn; give it less, or put it before stage[{i}]"
                );
                return Err(Invalid::new(format!("stage[{}].spark_gap_mm", i + 1), pair[1].spark_gap_mm, remedy));
            }
        }
        if self.stage[last].stock_mm > 0.0 {
            let remedy = "the last stage leaves no stock; add a stage after it, or give it 0";
            return Err(Invalid::new(format!("stage[{last}].stock_mm"), self.stage[last].stock_mm, remedy));
        }
        Ok(())
    }

    /// Parameters that electrodes and paths depend on: without the ends of burning.
    #[must_use]
    pub fn searched(&self) -> Self {
        let mut searched = self.clone();
        for stage in &mut searched.stage {
            (stage.last_step, stage.finish_vdi) = Default::default();
        }
        searched
    }

    /// Number of stages; 1 where none is given.
    pub fn stages(&self) -> usize {
        self.stage.len().max(1)
    }

    /// Stage of electrode number `number`, and its number in that stage. Electrodes count from 0, those of the first stage
    /// first; a number beyond them is taken for the last.
    pub fn in_stage(&self, number: usize) -> (usize, usize) {
        let mut in_stage = number;
        for stage in 0..self.stages() {
            let count = self.of_stage(stage).count();
            if in_stage < count {
                return (stage, in_stage);
            }
            in_stage -= count;
        }
        let last = self.stages() - 1;
        (last, self.of_stage(last).count().saturating_sub(1))
    }

    /// Parameters that hold for electrode number `number`: those of its stage and part.
    #[must_use]
    pub fn of_electrode(&self, number: usize) -> Self {
        let (stage, number) = self.in_stage(number);
        let of_stage = self.of_stage(stage);
        let (part, _) = of_stage.place_of(number);
        of_stage.of_part(part)
    }

    /// Row of the stage of electrode number `number`; none where no stages are given.
    pub fn stage_of(&self, number: usize) -> Option<&StageParams> {
        self.stage.get(self.in_stage(number).0)
    }

    /// Words for electrode number `number` in lists, as [`Electrode::label`](super::Electrode::label) has them.
    pub fn label(&self, number: usize) -> String {
        label(number, self.stage_of(number).map(|stage| stage.name.as_str()))
    }

    /// Spark gap in which electrode number `number` burns (mm). It stands that and the stock of its stage away from the
    /// finished surface.
    pub fn burned_gap_mm(&self, number: usize) -> f64 {
        self.stage_of(number).map_or(self.spark_gap_mm, |stage| stage.spark_gap_mm)
    }

    /// Parameters of the last stage, which makes the surface.
    #[must_use]
    pub fn of_last_stage(&self) -> Self {
        self.of_stage(self.stages() - 1)
    }

    /// Parameters of the electrodes of stage `stage` as if there were no stages: the spark gap is the distance to the finished
    /// surface, the stock of the stage included.
    #[must_use]
    pub fn of_stage(&self, stage: usize) -> Self {
        let Some(own) = self.stage.get(stage) else { return self.clone() };
        let [low, high] = self.circumferential_reduction_deg;
        let parts = own.parts.unwrap_or(self.parts);
        Self {
            spark_gap_mm: own.undersize_mm(),
            parts,
            part: if own.part.is_empty() && parts == self.parts { self.part.clone() } else { own.part.clone() },
            columns: own.columns.unwrap_or(self.columns),
            enter: own.enter.unwrap_or(self.enter),
            circumferential_reduction_deg: [
                own.low_reduction_deg.unwrap_or(low),
                own.high_reduction_deg.unwrap_or(high),
            ],
            radial_reduction_mm: own.radial_reduction_mm.unwrap_or(self.radial_reduction_mm),
            stage: Vec::new(),
            ..self.clone()
        }
    }
}

/// Number of an electrode, counted from 1, and the name of its stage.
pub(super) fn label(index: usize, stage: Option<&str>) -> String {
    let stage = stage.map(|name| format!(" ({name})"));
    format!("{}{}", index + 1, stage.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::electrode::{Column, PartParams};

    fn staged() -> ElectrodeParams {
        let rough = StageParams {
            name: "rough".to_owned(),
            spark_gap_mm: 0.2,
            stock_mm: 0.1,
            low_reduction_deg: Some(2.0),
            ..StageParams::default()
        };
        let finish = StageParams { name: "finish".to_owned(), spark_gap_mm: 0.05, ..StageParams::default() };
        ElectrodeParams { parts: 2, columns: 2, stage: vec![rough, finish], ..ElectrodeParams::default() }
    }

    #[test]
    fn electrodes_are_counted_through_the_stages() {
        let params = staged();
        assert_eq!((params.validate(), params.count()), (Ok(()), 8));
        assert_eq!([0, 3, 4, 7].map(|n| params.in_stage(n)), [(0, 0), (0, 3), (1, 0), (1, 3)]);
        assert_eq!(params.place_of(params.in_stage(6).1), (1, Some(Column::Low)));
        assert_eq!([3, 4].map(|n| params.stage_of(n).unwrap().name.as_str()), ["rough", "finish"]);
        assert_eq!([3, 4].map(|n| params.burned_gap_mm(n)), [0.2, 0.05]);
        assert_eq!(params.label(4), "5 (finish)");
        let mut uneven = params.clone();
        (uneven.stage[0].parts, uneven.stage[0].columns) = (Some(3), Some(1));
        assert_eq!((uneven.validate(), uneven.count()), (Ok(()), 7));
        assert_eq!([0, 2, 3, 6].map(|n| uneven.in_stage(n)), [(0, 0), (0, 2), (1, 0), (1, 3)]);
        assert_eq!(uneven.in_stage(7), (1, 3), "beyond the last");
        let none = ElectrodeParams { stage: Vec::new(), ..params };
        assert_eq!((none.count(), none.in_stage(3), none.stage_of(3)), (4, (0, 3), None));
        assert_eq!(none.label(3), "4");
        assert_eq!(none.burned_gap_mm(3), none.spark_gap_mm);
    }

    #[test]
    fn a_stage_has_its_own_distance_and_reductions_and_a_part_has_the_last_word() {
        let mut params = staged();
        let [rough, finish] = [0, 1].map(|stage| params.of_stage(stage));
        assert!(rough.spark_gap_mm == 0.3 && rough.stage.is_empty() && rough.count() == 4);
        assert_eq!(rough.circumferential_reduction_deg, [2.0, 0.8]);
        assert_eq!((finish.spark_gap_mm, finish.circumferential_reduction_deg), (0.05, [0.8, 0.8]));
        params.part = vec![PartParams { low_reduction_deg: Some(3.0), ..PartParams::default() }];
        assert_eq!(params.of_stage(0).of_part(0).circumferential_reduction_deg, [3.0, 0.8]);
        assert_eq!(params.of_stage(0).of_part(1).circumferential_reduction_deg, [2.0, 0.8]);
        params.stage[1].enter = Some(EnterSide::MinusX);
        params.stage[1].part = vec![PartParams { high_reduction_deg: Some(0.5), ..PartParams::default() }];
        let finish = params.of_electrode(4);
        assert_eq!((finish.circumferential_reduction_deg, finish.enter), ([0.8, 0.5], EnterSide::MinusX));
        params.stage[0].parts = Some(1);
        assert_eq!(params.of_electrode(0).circumferential_reduction_deg, [2.0, 0.8], "rows of two parts");
    }

    #[test]
    fn stages_that_cannot_be_burned_are_named() {
        let said = |change: &dyn Fn(&mut ElectrodeParams)| {
            let mut params = staged();
            change(&mut params);
            params.validate().unwrap_err().to_string()
        };
        assert!(said(&|p| p.stage[1].name = "rough".to_owned()).contains("electrode.stage[1].name is rough"));
        assert!(said(&|p| p.stage[0].name = " ".to_owned()).contains("electrode.stage[0].name"));
        assert!(said(&|p| p.stage[1].stock_mm = 0.1).contains("electrode.stage[1].stock_mm is 0.1"));
        assert!(said(&|p| p.stage[1].spark_gap_mm = 0.4).contains("electrode.stage[1].spark_gap_mm is 0.4"));
        assert!(said(&|p| p.stage[0].spark_gap_mm = 0.0).contains("electrode.stage[0].spark_gap_mm is 0"));
        assert!(
            said(&|p| p.stage[0].stock_mm = 1.9).contains("electrode.stage[0].stock_mm is 1.9"),
            "2 mm with the gap"
        );
        assert!(said(&|p| p.stage[0].finish_vdi = Some(99.0)).contains("electrode.stage[0].finish_vdi is 99"));
        assert!(said(&|p| p.stage[0].parts = Some(21)).contains("electrode.stage[0].parts is 21"));
        assert!(said(&|p| p.stage[0].columns = Some(3)).contains("electrode.stage[0].columns is 3"));
        let divided = |until| PartParams { until: Some(until), ..PartParams::default() };
        let rows = said(&|p| p.stage[1].part = vec![divided(0.5); 3]);
        assert!(rows.contains("electrode.stage[1].part is a list of 3 rows"), "{rows}");
        let far = said(&|p| p.stage[1].part = vec![divided(0.995)]);
        assert!(far.contains("electrode.stage[1].part[0].until is 0.995"), "{far}");
        assert!(said(&|p| p.mesh = Some("own.stl".into())).contains("electrode.stage"));
        assert!(said(&|p| p.stage = vec![p.stage[1].clone(); 9]).contains("at most 8"));
    }
}
