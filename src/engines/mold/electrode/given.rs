//! What the user gives single electrodes: number, name, holder, blank and material.

use files::Invalid;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::params::{ElectrodeParams, is_plain};

/// A number given to an electrode, with the places it burned then and what the user gave it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenName {
    /// The number: 4 of `E04`.
    pub number: usize,
    /// A place of each burned part of a region, in the upright mold (mm).
    pub places: Vec<DVec3>,
    /// Properties that the user gave the electrode.
    #[serde(default, skip_serializing_if = "Given::is_nothing")]
    pub given: Given,
}

/// Properties that the user gives one electrode; a property that is none is as for all electrodes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Given {
    /// Number in its name, instead of the one that it got.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<usize>,
    /// Name, instead of `E` and the number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Name of the holder.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub holder: Option<String>,
    /// Sides of the rectangular blank along X and Y (mm).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blank_mm: Option<[f64; 2]>,
    /// Material.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

impl Given {
    /// The name of an electrode of this number without its stage, if no other one has that name.
    pub fn short_name(&self, number: usize) -> String {
        self.name.clone().unwrap_or_else(|| numbered(self.number.unwrap_or(number)))
    }

    /// Whether it gives nothing.
    pub fn is_nothing(&self) -> bool {
        *self == Self::default()
    }

    pub(super) fn validate(&self) -> Result<(), Invalid> {
        if self.name.as_ref().is_some_and(|name| !is_plain(name)) {
            return Err(Invalid::of("name", "must consist of letters, digits, - and _: file names carry it"));
        }
        if self.name.as_ref().is_some_and(|name| is_numbered(name)) {
            return Err(Invalid::of("name", "E and a number is the name of electrodes without another: give a number"));
        }
        match self.blank_mm {
            Some(sides) => {
                sides.into_iter().try_for_each(|side| Invalid::unless_within("blank_mm", side, [1.0, 1000.0], "mm"))
            }
            None => Ok(()),
        }
    }
}

/// The name of an electrode without one of its own: `E04` of 4.
pub fn numbered(number: usize) -> String {
    format!("E{number:02}")
}

/// Whether a name is `E` and a number.
fn is_numbered(name: &str) -> bool {
    let digits = name.strip_prefix(['E', 'e']).unwrap_or_default();
    !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit())
}

impl ElectrodeParams {
    /// Gives properties to the electrode of the name at this place of the list. Overrides that name it, of any stage,
    /// follow a new name, unless another electrode has that: then it keeps its number.
    pub fn give(&mut self, at: usize, given: Given) {
        let Some(named) = self.names.get_mut(at) else { return };
        let [before, after] = [&named.given, &given].map(|given| given.short_name(named.number));
        named.given = given;
        // File names tell neither case nor hyphens from underscores.
        let plain = |name: &str| name.to_ascii_lowercase().replace('_', "-");
        let others = self.names.iter().enumerate().filter(|(other, _)| *other != at);
        let is_taken =
            others.map(|(_, other)| other.given.short_name(other.number)).any(|name| plain(&name) == plain(&after));
        if is_taken {
            return;
        }
        for one in &mut self.overrides {
            let stage = one.of.strip_prefix(&before);
            let of_stage = |rest: &str| self.stages.iter().any(|s| rest.strip_prefix('-') == Some(s.name.as_str()));
            if let Some(stage) = stage.filter(|rest| rest.is_empty() || of_stage(rest)) {
                one.of = format!("{after}{stage}");
            }
        }
    }
}
