//! Subjects of the checks of electrodes, and what such a check finds.

use files::Figures;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Subject of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckKind {
    /// The surface is closed.
    Watertight,
    /// The electrode keeps the gap where it burns.
    Gouge,
    /// The electrode keeps the gap on its way in and out.
    Approach,
    /// The parts that the electrode was made for are burned.
    Leftover,
    /// The electrode can be milled.
    Machinable,
}

impl CheckKind {
    /// All checks, in the order in which they are made.
    pub const ALL: [Self; 5] = [Self::Watertight, Self::Gouge, Self::Approach, Self::Leftover, Self::Machinable];

    /// How it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::Gouge => "gouge",
            Self::Approach => "approach",
            Self::Leftover => "leftover",
            Self::Machinable => "machinable",
        }
    }
}

/// Finding of a check.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Subject of the check.
    pub kind: CheckKind,
    /// Whether it holds.
    pub holds: bool,
    /// The finding in words, with its figures.
    pub text: String,
    /// Where, in the upright mold (mm).
    pub place: Option<DVec3>,
    /// How bad it is, if it fails; see [`Figures`].
    pub figures: Figures,
}

/// The greatest figure of what is wrong: what is no number is as bad as that.
const WORST: f64 = 1e9;

impl Finding {
    /// A finding.
    pub(super) fn new(kind: CheckKind, holds: bool, text: String, place: Option<DVec3>) -> Self {
        Self { kind, holds, text, place, figures: Figures::new() }
    }

    /// One that does not hold, as bad as this figure says.
    pub(super) fn failed(kind: CheckKind, text: String, figure: (&str, f64)) -> Self {
        Self::new(kind, false, text, None).with(&[figure])
    }

    /// This finding with the figures of its failure.
    pub(super) fn with(mut self, figures: &[(&str, f64)]) -> Self {
        let worst = |figure: f64| if figure.is_finite() { figure.clamp(0.0, WORST) } else { WORST };
        let wrong = figures.iter().filter(|_| !self.holds);
        self.figures.extend(wrong.map(|(name, figure)| ((*name).to_owned(), worst(*figure))));
        self
    }
}
