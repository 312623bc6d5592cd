//! Overrides: decisions to export although a check fails.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::str::FromStr;

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::Invalid;

/// Tolerance by which a figure may be worse than at the decision (mm, or the figure's own unit): the difference between
/// two runs of the same computation.
pub const NO_WORSE: f64 = 1e-3;

/// Figures of a failed check, by name. A greater number is worse.
pub type Figures = BTreeMap<String, f64>;

/// A check that does not block the export, with the findings that this was decided for.
///
/// Files have a text or a table. An override does not cover findings that are worse than at the decision, nor other
/// parts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Override {
    /// Name of the checked object, such as an electrode; empty where there is only one.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub of: String,
    /// Name of the check.
    pub check: String,
    /// Greatest value that any figure may have; none for any value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<f64>,
    /// Checked parts at the decision: the parts that an electrode burned, or the digest of a surface; empty for any
    /// parts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<String>,
    /// Figures at the decision; empty for any figures.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub figures: Figures,
}

/// An override as files have it in a table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Table {
    #[serde(default)]
    of: String,
    check: String,
    #[serde(default)]
    most: Option<f64>,
    #[serde(default)]
    parts: Vec<String>,
    #[serde(default)]
    figures: Figures,
}

impl From<Table> for Override {
    fn from(Table { of, check, most, parts, figures }: Table) -> Self {
        Self { of, check, most, parts, figures }
    }
}

impl<'de> Deserialize<'de> for Override {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        const EXPECTED: &str = "the name of a check, \"CHECK:FIGURE\", \"NAME:CHECK\" or \"NAME:CHECK:FIGURE\", or a \
                                table with of, check, most, parts, figures";
        word_or_table::<Self, Table, D>(deserializer, EXPECTED)
    }
}

impl Override {
    /// An override of a check for any finding.
    pub fn whatever(check: &str) -> Self {
        let (of, parts) = (String::new(), Vec::new());
        Self { of, check: check.to_owned(), most: None, parts, figures: Figures::new() }
    }

    /// An override of a check of these parts, for the present figures.
    pub fn decided(check: &str, parts: Vec<String>, figures: &Figures) -> Self {
        Self { parts, figures: figures.clone(), ..Self::whatever(check) }
    }

    /// Whether the override names no figure and so covers any finding of the check.
    pub fn is_for_whatever(&self) -> bool {
        self.most.is_none() && self.figures.is_empty()
    }

    /// Reason why the override no longer covers what a check of its name finds `now` on `parts`: the parts are others,
    /// or a figure is worse than at the decision. None while the override holds.
    pub fn lapsed(&self, parts: &[String], now: &Figures) -> Option<String> {
        if !self.parts.is_empty() && self.parts != parts {
            return Some("this was decided for another part; it does not hold: decide again".to_owned());
        }
        if self.is_for_whatever() && !self.parts.is_empty() && !now.is_empty() {
            // Decided of a finding without figures, which is not to waive one that has some.
            return Some("this was decided for a finding without figures; it does not hold: decide again".to_owned());
        }
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

    /// Checks that the override names one of `checks`, and an object where it must (`is_named`).
    ///
    /// # Errors
    /// The wrong part, and what is allowed.
    pub fn validate(&self, checks: &[&str], is_named: bool) -> Result<(), Invalid> {
        let numbers = self.most.iter().chain(self.figures.values());
        if let Some(n) = numbers.copied().find(|n| !(0.0..=1e9).contains(n)) {
            return Err(Invalid::of("", format!("override of {}: a figure is {n}: it must be 0 or more", self.check)));
        }
        let all = checks.join(", ");
        match (checks.contains(&&*self.check), is_named, self.of.is_empty()) {
            (_, true, true) => Err(Invalid::of(
                "",
                format!("{self} names no check of an electrode: give NAME:CHECK with one of {all}"),
            )),
            (_, false, false) => Err(Invalid::of(
                "",
                format!("{self}: expected CHECK or CHECK:FIGURE with a number, as in gouge:0.12; checks are {all}"),
            )),
            (false, ..) => Err(Invalid::of("", format!("there is no check {:?}; there are {all}", self.check))),
            _ => Ok(()),
        }
    }
}

/// The name of a figure in words, as in `depth mm`.
fn words(name: &str) -> String {
    name.replace('_', " ")
}

/// `CHECK`, `CHECK:FIGURE`, `NAME:CHECK` or `NAME:CHECK:FIGURE`.
impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let colon = if self.of.is_empty() { "" } else { ":" };
        write!(f, "{}{colon}{}", self.of, self.check)?;
        self.most.map_or(Ok(()), |most| write!(f, ":{most}"))
    }
}

impl FromStr for Override {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut words: Vec<&str> = text.split(':').map(str::trim).collect();
        let is_number =
            |word: &&str| word.is_empty() || word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
        let figure = if words.len() > 1 { words.pop_if(|word| is_number(&&**word) || *word == "nan") } else { None };
        let most = figure.map(|figure| {
            let number = figure.parse::<f64>().ok().filter(|n| (0.0..=1e9).contains(n));
            number.ok_or_else(|| {
                format!("{figure:?} is no figure: give the greatest one after the check, as in gouge:0.12")
            })
        });
        let most = most.transpose()?;
        match words[..] {
            [check] if !check.is_empty() => Ok(Self { most, ..Self::whatever(check) }),
            [of, check] if !of.is_empty() => Ok(Self { of: of.to_owned(), most, ..Self::whatever(check) }),
            _ => Err("expected CHECK, CHECK:FIGURE, NAME:CHECK or NAME:CHECK:FIGURE".to_owned()),
        }
    }
}

/// Reads a value from a word, by [`FromStr`], or from the table `T`. `expected` describes the allowed values.
///
/// # Errors
/// The error of [`FromStr`] or of the table, or that the value is neither a word nor a table.
fn word_or_table<'de, V, T, D>(deserializer: D, expected: &'static str) -> Result<V, D::Error>
where
    V: FromStr<Err = String> + From<T>,
    T: DeserializeOwned,
    D: Deserializer<'de>,
{
    deserializer.deserialize_any(WordOrTable { expected, of: PhantomData::<(V, T)> })
}

struct WordOrTable<V, T> {
    expected: &'static str,
    of: PhantomData<(V, T)>,
}

impl<'de, V: FromStr<Err = String> + From<T>, T: DeserializeOwned> Visitor<'de> for WordOrTable<V, T> {
    type Value = V;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_str<E: Error>(self, word: &str) -> Result<V, E> {
        word.parse().map_err(E::custom)
    }

    fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<V, A::Error> {
        T::deserialize(MapAccessDeserializer::new(table)).map(V::from)
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
        let then = Override::decided("deviation", Vec::new(), &figures(&[("overcut_mm", 0.12), ("undercut_mm", 0.3)]));
        for now in [[("overcut_mm", 0.12), ("undercut_mm", 0.3)], [("overcut_mm", 0.1209), ("undercut_mm", 0.0)]] {
            assert_eq!(then.lapsed(&[], &figures(&now)), None, "{now:?}");
        }
        let why = then.lapsed(&[], &figures(&[("overcut_mm", 0.5), ("undercut_mm", 0.1)])).unwrap();
        assert!(why.contains("overcut mm is 0.5000, more than the 0.1200") && !why.contains("undercut"), "{why}");
        assert!(then.lapsed(&[], &figures(&[("overcut_mm", f64::NAN)])).is_some());
        assert!(then.lapsed(&[], &figures(&[("missed", 1.0)])).is_some(), "it was not wrong in this way then");
        let most: Override = "gouge:0.12".parse().unwrap();
        assert!(most.lapsed(&[], &figures(&[("depth_mm", 0.12)])).is_none());
        assert!(most.lapsed(&[], &figures(&[("depth_mm", 0.2)])).is_some());
        assert_eq!(Override::whatever("gouge").lapsed(&[], &figures(&[("depth_mm", 9.0)])), None);
        // What cannot be counted is within no figure.
        for one in [then, most] {
            assert!(one.lapsed(&[], &Figures::new()).is_some_and(|why| why.contains("name the check alone")), "{one}");
        }
        assert_eq!(Override::whatever("machine").lapsed(&[], &Figures::new()), None);
        // Decided in the window of a finding without figures: one that has some is another.
        let parts = vec!["R1".to_owned()];
        let without = Override::decided("machine", parts.clone(), &Figures::new());
        assert_eq!(without.lapsed(&parts, &Figures::new()), None);
        assert!(without.lapsed(&parts, &figures(&[("depth_mm", 0.1)])).is_some_and(|why| why.contains("decide again")));
    }

    #[test]
    fn it_is_a_name_a_name_with_a_figure_or_a_table() {
        #[derive(Debug, PartialEq, Serialize, Deserialize)]
        struct File {
            overrides: Vec<Override>,
        }
        let text = "overrides = [\"gouge\", \"holder:0.5\", { check = \"ruled\", figures = { off_mm = 0.1 } }]";
        let read: File = toml::from_str(text).unwrap();
        let told: Vec<String> = read.overrides.iter().map(ToString::to_string).collect();
        assert_eq!(told, ["gouge", "holder:0.5", "ruled"]);
        assert_eq!(read.overrides[2], Override::decided("ruled", Vec::new(), &figures(&[("off_mm", 0.1)])));
        assert_eq!(toml::from_str::<File>(&toml::to_string_pretty(&read).unwrap()).unwrap(), read);
        for wrong in ["", ":1", "gouge:", "gouge:-1", "gouge:nan", "a:b:c", "a:b:1:2"] {
            assert!(wrong.parse::<Override>().is_err(), "{wrong}");
        }
        let broken = Override::decided("gouge", Vec::new(), &figures(&[("depth_mm", f64::INFINITY)]));
        assert!(broken.validate(&["gouge"], false).unwrap_err().to_string().contains("gouge"));
    }

    #[test]
    fn it_names_a_check_of_something_and_holds_for_those_parts_alone() {
        let checks = ["gouge", "holder"];
        let of = |text: &str| text.parse::<Override>().unwrap();
        assert_eq!(
            (&*of("E04:gouge:0.1").of, &*of("E04:gouge").check, of("E04:gouge:0.1").most),
            ("E04", "gouge", Some(0.1))
        );
        assert!(of("E04:gouge").validate(&checks, true).is_ok() && of("gouge:2").validate(&checks, false).is_ok());
        for (text, is_named, words) in [
            ("E04", true, "names no check"),
            ("E04:gouges", true, "gouge, holder"),
            ("E04:gouge", false, "expected CHECK or CHECK:FIGURE"),
            ("nonsense", false, "no check \"nonsense\""),
        ] {
            let said = of(text).validate(&checks, is_named).unwrap_err().to_string();
            assert!(said.contains(words), "{text}: {said}");
        }
        let now = figures(&[("depth_mm", 0.1)]);
        let [one, both] = [vec!["R1.1".to_owned()], vec!["R1.1".to_owned(), "R1.2".to_owned()]];
        let decided = Override::decided("gouge", one.clone(), &now);
        assert_eq!(decided.lapsed(&one, &now), None);
        assert!(decided.lapsed(&both, &now).unwrap().contains("another part"));
        assert_eq!(of("gouge").lapsed(&both, &now), None, "what is said of no part is for any");
    }
}
