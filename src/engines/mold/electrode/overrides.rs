//! Decisions to use an electrode although a check fails.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize};

use super::check::CheckKind;
use files::word_or_table::word_or_table;

/// An electrode that is exported although a check fails.
///
/// In files it is a name, `NAME:check`, or a table with what it was decided for. A plan that gives the name to other parts
/// does not inherit a decision with parts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Override {
    /// The electrode, by name.
    pub electrode: String,
    /// The check; none for all of them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub check: Option<CheckKind>,
    /// The parts of regions that the electrode burned when it was decided, by name, in order; none for whatever it burns.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
}

/// An override as files have it in a table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    electrode: String,
    #[serde(default)]
    check: Option<CheckKind>,
    #[serde(default)]
    parts: Vec<String>,
}

impl From<Table> for Override {
    fn from(Table { electrode, check, parts }: Table) -> Self {
        Self { electrode, check, parts }
    }
}

impl<'de> Deserialize<'de> for Override {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const EXPECTED: &str = "a name, \"NAME:check\" with a check of watertight, gouge, approach, leftover, machinable, or a \
                                table with electrode, check, parts";
        word_or_table::<Self, Table, D>(deserializer, EXPECTED)
    }
}

/// Why an override overrides nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IdleOverride {
    /// No electrode has its name.
    NoElectrode,
    /// The electrode of its name burns other parts than when it was decided.
    OtherParts,
    /// The check does not fail.
    Holds,
}

impl IdleOverride {
    /// In words, after the override's name.
    pub fn text(self) -> &'static str {
        match self {
            Self::NoElectrode => "there is no electrode of that name",
            Self::OtherParts => {
                "the electrode of that name now burns other parts: the override does not hold, decide again"
            }
            Self::Holds => "the check does not fail: the override has no effect",
        }
    }
}

/// `NAME` or `NAME:check`.
impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.electrode)?;
        self.check.map_or(Ok(()), |check| write!(f, ":{}", check.name()))
    }
}

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (electrode, check) = match text.split_once(':') {
            None => (text, None),
            Some((electrode, name)) => {
                let check = CheckKind::ALL.into_iter().find(|kind| kind.name() == name.trim());
                let known = CheckKind::ALL.map(CheckKind::name).join(", ");
                (electrode, Some(check.ok_or_else(|| format!("{name:?} is no check: they are {known}"))?))
            }
        };
        let electrode = electrode.trim().to_owned();
        if electrode.is_empty() {
            return Err("expected the name of an electrode, or NAME:check".to_owned());
        }
        Ok(Self { electrode, check, parts: Vec::new() })
    }
}
