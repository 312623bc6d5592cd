//! Settings of the milling: path, direction, machine, post.

use serde::{Deserialize, Serialize};

use flank::machine::linearise::LinearisationParams;
use flank::machine::milling_machine::Workpiece;

use crate::flank_program::settings::{FlankNcSettings, milling_post};

/// Path of a plan that is milled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PathChoice {
    /// Path of the offset.
    Initial,
    /// Path of the best rank.
    Chosen,
    /// The refined one.
    #[default]
    Refined,
}

impl PathChoice {
    /// All paths, in the order in which they are made.
    pub const ALL: [Self; 3] = [Self::Initial, Self::Chosen, Self::Refined];

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Initial => "initial",
            Self::Chosen => "chosen",
            Self::Refined => "refined",
        }
    }
}

/// Direction of the cutter's rotation relative to its travel. The spindle turns clockwise, seen from above.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CutDirection {
    /// The flutes move against the travel where they cut: the surface is to the right of the travel, and chips begin
    /// thick. What flanks are finished with.
    #[default]
    Climb,
    /// The surface is to the left of the travel, and chips begin thin.
    Conventional,
}

impl CutDirection {
    /// Both directions.
    pub const ALL: [Self; 2] = [Self::Climb, Self::Conventional];

    /// Name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Climb => "climb",
            Self::Conventional => "conventional",
        }
    }
}

/// Settings of the milling on a machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MillingSettings {
    /// Name of a machine, a TOML file with one, or one of several in such a file as `FILE.toml#NAME`; empty for none.
    pub machine: String,
    /// Position of the workpiece on the machine, if not that of the machine's file.
    pub workpiece: Option<Workpiece>,
    /// Length from the spindle nose to the tip (mm), if not that of the machine's file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gauge_length_mm: Option<f64>,
    /// Direction along the surface.
    pub cut: CutDirection,
    /// Name of the post.
    pub post: String,
    /// The furthest that tip and flutes' top may leave the path between programmed points (mm).
    pub linearisation_mm: f64,
    /// Passing the machine's pole within this angle is reported (deg).
    pub singular_cone_deg: f64,
    /// Length of lead-in and lead-out from the side, at both ends of the path (mm).
    pub aside_mm: f64,
    /// Retract distance along its axis (mm).
    pub retract_mm: f64,
    /// Speeds and words of the program.
    pub program: FlankNcSettings,
}

impl Default for MillingSettings {
    fn default() -> Self {
        let LinearisationParams { linearisation_mm, singular_cone_deg, .. } = LinearisationParams::default();
        Self {
            machine: "trunnion-ac".to_owned(),
            workpiece: None,
            gauge_length_mm: None,
            cut: CutDirection::default(),
            post: "milling".to_owned(),
            linearisation_mm,
            singular_cone_deg,
            aside_mm: 3.0,
            retract_mm: 30.0,
            program: FlankNcSettings::default(),
        }
    }
}

impl MillingSettings {
    /// Takes another machine. Where the workpiece stands on the former one, and how long the tool is on it, says
    /// nothing of this one: both are then as its file says. Returns in words what was forgotten, if anything.
    pub fn take_machine(&mut self, machine: &str) -> Option<String> {
        if self.machine == machine {
            return None;
        }
        self.machine = machine.to_owned();
        let clamped = self.workpiece.take().map(|_| "how the workpiece was clamped");
        let tool = self.gauge_length_mm.take().map(|_| "the gauge length of the tool");
        let forgotten: Vec<&str> = clamped.into_iter().chain(tool).collect();
        let what = forgotten.join(" and ");
        (!forgotten.is_empty()).then(|| {
            format!(
                "the machine is another: {what} was of the former one, and is now as the machine's file says; see to it"
            )
        })
    }

    /// Parameters of linearisation, with flutes of this length (mm).
    pub fn linearisation(&self, flutes_mm: f64) -> LinearisationParams {
        LinearisationParams {
            linearisation_mm: self.linearisation_mm,
            reach_mm: flutes_mm,
            singular_cone_deg: self.singular_cone_deg,
            interpolation: self.program.tip_control.interpolation(),
        }
    }

    /// Checks the ranges; `flutes_mm` is the length of the cutter's flutes.
    ///
    /// # Errors
    /// One line naming the setting and what it may be.
    pub fn validate(&self, flutes_mm: f64) -> Result<(), String> {
        if flutes_mm > LinearisationParams::LONGEST_REACH_MM {
            return Err(format!(
                "the flutes are {flutes_mm} mm long: a machine's moves are measured up to {} mm",
                LinearisationParams::LONGEST_REACH_MM
            ));
        }
        self.linearisation(flutes_mm).validate().map_err(|e| e.to_string())?;
        self.program.validate().map_err(|e| e.to_string())?;
        milling_post(&self.post).map_err(|e| e.to_string())?;
        for (name, value) in [("aside_mm", self.aside_mm), ("retract_mm", self.retract_mm)] {
            if !(0.0..=1000.0).contains(&value) {
                return Err(format!("{name} is {value}: it must be from 0 to 1000 mm"));
            }
        }
        Ok(())
    }
}
