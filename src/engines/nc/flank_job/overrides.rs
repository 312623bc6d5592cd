//! Decisions to export a flank although a check fails.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize};

use files::word_or_table::word_or_table;

/// By how much a figure may be worse than when it was decided (mm, or the figure's own unit): what another run of the same
/// makes of it.
pub const NO_WORSE: f64 = 1e-3;

/// How bad what a check found is: for each of its figures, by name, a number that is greater the worse it is.
pub type Figures = BTreeMap<String, f64>;

/// A check that does not keep anything from being exported.
///
/// In files it is a name, `CHECK:FIGURE`, or a table with what it was decided for. What is worse now than it was then is
/// no longer let pass.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FlankOverride {
    /// The check, by name.
    pub check: String,
    /// The greatest that any figure of it may be; none for whatever it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// The figures when it was decided; empty for whatever they are.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub figures: Figures,
}

/// An override as files have it in a table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    check: String,
    #[serde(default)]
    most: Option<f64>,
    #[serde(default)]
    figures: Figures,
}

impl From<Table> for FlankOverride {
    fn from(Table { check, most, figures }: Table) -> Self {
        Self { check, most, figures }
    }
}

impl<'de> Deserialize<'de> for FlankOverride {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const EXPECTED: &str = "the name of a check, \"CHECK:FIGURE\", or a table with check, most, figures";
        word_or_table::<Self, Table, D>(deserializer, EXPECTED)
    }
}

impl FlankOverride {
    /// One for a check whatever it finds.
    pub fn whatever(check: &str) -> Self {
        Self { check: check.to_owned(), most: None, figures: Figures::new() }
    }

    /// One for a check as bad as it is now.
    pub fn of(check: &str, figures: &Figures) -> Self {
        Self { check: check.to_owned(), most: None, figures: figures.clone() }
    }

    /// Whether it names no figure, so that it holds whatever the check finds.
    pub fn is_for_whatever(&self) -> bool {
        self.most.is_none() && self.figures.is_empty()
    }

    /// Why it no longer holds for what a check of its name finds `now`: which figures are worse than when it was decided.
    /// None while it holds.
    pub fn lapsed(&self, now: &Figures) -> Option<String> {
        if self.is_for_whatever() {
            return None;
        }
        if now.is_empty() {
            let why = "the failed check has no figure to compare with the one it was decided for";
            return Some(format!(
                "{why}; the override does not hold: name the check alone to waive it unconditionally"
            ));
        }
        let allowed = |name: &str| {
            // What was not wrong when it was decided is not let pass now.
            let unknown = if self.figures.is_empty() { f64::INFINITY } else { 0.0 };
            self.figures.get(name).copied().or(self.most).unwrap_or(unknown)
        };
        let worse: Vec<String> = now
            .iter()
            // What is no number is worse than any.
            .filter(|(name, now)| now.is_nan() || **now > allowed(name) + NO_WORSE)
            .map(|(name, now)| {
                format!("{} is {now:.4}, more than the {:.4} that this was decided for", words(name), allowed(name))
            })
            .collect();
        (!worse.is_empty()).then(|| format!("{}; it does not hold: decide again", worse.join(", ")))
    }

    /// Finding that the override was decided for, in words; none for any finding.
    pub fn given_for(&self) -> Option<String> {
        let most = self.most.map(|most| format!("up to {most:.4}"));
        let figures = self.figures.iter().map(|(name, figure)| format!("{} {figure:.4}", words(name)));
        let all: Vec<String> = most.into_iter().chain(figures).collect();
        (!all.is_empty()).then(|| all.join(", "))
    }

    /// Whether it can be kept.
    ///
    /// # Errors
    /// One line saying what is wrong and what it may be.
    pub fn validate(&self) -> Result<(), String> {
        let numbers = self.most.iter().chain(self.figures.values());
        match numbers.copied().find(|n| !(0.0..=1e9).contains(n)) {
            Some(n) => Err(format!("override of {}: a figure is {n}: it must be 0 or more", self.check)),
            None if self.check.is_empty() => Err("an override names no check".to_owned()),
            None => Ok(()),
        }
    }
}

/// The name of a figure in words, as in `depth mm`.
fn words(name: &str) -> String {
    name.replace('_', " ")
}

/// `CHECK` or `CHECK:FIGURE`.
impl fmt::Display for FlankOverride {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.check)?;
        self.most.map_or(Ok(()), |most| write!(f, ":{most}"))
    }
}

impl FromStr for FlankOverride {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (check, most) = match text.split_once(':') {
            None => (text, None),
            Some((check, most)) => {
                let number = most.trim().parse::<f64>().ok().filter(|n| (0.0..=1e9).contains(n));
                let wrong =
                    || format!("{most:?} is no figure: give a check, or one with the greatest figure as in gouge:0.12");
                (check, Some(number.ok_or_else(wrong)?))
            }
        };
        let check = check.trim().to_owned();
        if check.is_empty() {
            return Err("expected the name of a check, or CHECK:FIGURE".to_owned());
        }
        Ok(Self { check, most, figures: Figures::new() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(all: &[(&str, f64)]) -> Figures {
        all.iter().map(|(name, figure)| ((*name).to_owned(), *figure)).collect()
    }

    #[test]
    fn what_is_worse_than_when_it_was_decided_is_not_let_pass() {
        let then = FlankOverride::of("deviation", &figures(&[("overcut_mm", 0.12), ("undercut_mm", 0.3)]));
        for now in [[("overcut_mm", 0.12), ("undercut_mm", 0.3)], [("overcut_mm", 0.1209), ("undercut_mm", 0.0)]] {
            assert_eq!(then.lapsed(&figures(&now)), None, "{now:?}");
        }
        let why = then.lapsed(&figures(&[("overcut_mm", 0.5), ("undercut_mm", 0.1)])).unwrap();
        assert!(why.contains("overcut mm is 0.5000, more than the 0.1200") && !why.contains("undercut"), "{why}");
        assert!(then.lapsed(&figures(&[("overcut_mm", f64::NAN)])).is_some());
        assert!(then.lapsed(&figures(&[("missed", 1.0)])).is_some(), "it was not wrong in this way then");
        let most: FlankOverride = "gouge:0.12".parse().unwrap();
        assert!(most.lapsed(&figures(&[("depth_mm", 0.12)])).is_none());
        assert!(most.lapsed(&figures(&[("depth_mm", 0.2)])).is_some());
        assert_eq!(FlankOverride::whatever("gouge").lapsed(&figures(&[("depth_mm", 9.0)])), None);
        // What cannot be counted is within no figure.
        for one in [then, most] {
            assert!(one.lapsed(&Figures::new()).is_some_and(|why| why.contains("name the check alone")), "{one}");
        }
        assert_eq!(FlankOverride::whatever("machine").lapsed(&Figures::new()), None);
    }

    #[test]
    fn it_is_a_name_a_name_with_a_figure_or_a_table() {
        #[derive(Debug, PartialEq, Serialize, Deserialize)]
        struct File {
            overrides: Vec<FlankOverride>,
        }
        let text = "overrides = [\"gouge\", \"holder:0.5\", { check = \"ruled\", figures = { off_mm = 0.1 } }]";
        let read: File = toml::from_str(text).unwrap();
        let told: Vec<String> = read.overrides.iter().map(ToString::to_string).collect();
        assert_eq!(told, ["gouge", "holder:0.5", "ruled"]);
        assert_eq!(read.overrides[2], FlankOverride::of("ruled", &figures(&[("off_mm", 0.1)])));
        assert_eq!(toml::from_str::<File>(&toml::to_string_pretty(&read).unwrap()).unwrap(), read);
        for wrong in ["", ":1", "gouge:", "gouge:-1", "gouge:deep", "gouge:nan"] {
            assert!(wrong.parse::<FlankOverride>().is_err(), "{wrong}");
        }
        let broken = FlankOverride::of("gouge", &figures(&[("depth_mm", f64::INFINITY)]));
        assert!(broken.validate().unwrap_err().contains("gouge"));
    }
}
