//! Checks of electrodes and their findings.

use files::Figures;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Subject of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CheckKind {
    /// The surface is closed.
    Watertight,
    /// The electrode keeps the gap in the burning position.
    Gouge,
    /// The electrode keeps the gap on its way in and out.
    Approach,
    /// The parts that the electrode was made for are burned.
    #[serde(rename = "leftover")]
    ResidualStock,
    /// The electrode can be milled.
    Machinable,
}

impl CheckKind {
    /// All checks, in the order in which they are made.
    pub const ALL: [Self; 5] = [Self::Watertight, Self::Gouge, Self::Approach, Self::ResidualStock, Self::Machinable];

    /// Name of the check.
    pub fn name(self) -> &'static str {
        match self {
            Self::Watertight => "watertight",
            Self::Gouge => "gouge",
            Self::Approach => "approach",
            Self::ResidualStock => "leftover",
            Self::Machinable => "machinable",
        }
    }
}

/// Finding of a check.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Subject of the check.
    pub kind: CheckKind,
    /// Whether the check holds.
    pub holds: bool,
    /// The finding in words, with its figures.
    pub text: String,
    /// Place of the finding, in the upright mold (mm).
    pub place: Option<DVec3>,
    /// Figures of a failed check; see [`Figures`].
    pub figures: Figures,
}

/// Figure of a failure without a number.
const WORST: f64 = 1e9;

impl Finding {
    /// A finding.
    pub(super) fn new(kind: CheckKind, holds: bool, text: String, place: Option<DVec3>) -> Self {
        Self { kind, holds, text, place, figures: Figures::new() }
    }

    /// A failed finding with this figure.
    pub(super) fn failed(kind: CheckKind, text: String, figure: (&str, f64)) -> Self {
        Self::new(kind, false, text, None).with(&[figure])
    }

    /// Sets the figures of the failure.
    pub(super) fn with(mut self, figures: &[(&str, f64)]) -> Self {
        let worst = |figure: f64| if figure.is_finite() { figure.clamp(0.0, WORST) } else { WORST };
        let wrong = figures.iter().filter(|_| !self.holds);
        self.figures.extend(wrong.map(|(name, figure)| ((*name).to_owned(), worst(*figure))));
        self
    }
}
