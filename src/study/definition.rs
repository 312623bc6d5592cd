//! The file of a study.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use files::{Invalid, TomlFile, Validate};

/// Files of studies, of which those with long lists of values are large.
pub const STUDIES: TomlFile<Study> = TomlFile::new("study").at_most(16 << 20);
/// Greatest number of points.
pub const MOST_POINTS: usize = 100_000;
/// Greatest number of parameters that are varied.
pub const MOST_PARAMETERS: usize = 64;

/// A command on many variants of a project.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Kind of the file.
    pub kind: StudyKind,
    /// The project that is varied, or the mesh of a part, for which all else is at its default.
    pub project: PathBuf,
    /// The command.
    pub command: StudyCommand,
    /// Choice of the points among the values of the parameters.
    #[serde(default)]
    pub sampling: Sampling,
    /// The parameters that are varied.
    pub parameter: Vec<Parameter>,
    /// Columns and goals of the table.
    #[serde(default)]
    pub collect: Collect,
}

/// Kind of a file, which tells it from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StudyKind {
    /// A study.
    Study,
}

/// A command of which a study is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StudyCommand {
    /// Certified feed paths of a blisk's electrodes.
    Plan,
    /// Least reductions of a blisk's electrodes, in as many parts as the project has.
    Size,
    /// Uncut regions: what milling cutters leave of a mold.
    Uncut,
    /// Electrodes for what milling cutters leave of a mold.
    Electrodes,
}

impl StudyCommand {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Size => "size",
            Self::Uncut => "uncut",
            Self::Electrodes => "electrodes",
        }
    }

    /// Name in the window.
    pub fn title(self) -> &'static str {
        match self {
            Self::Plan => "Plan",
            Self::Size => "Size",
            Self::Uncut => "Rest material",
            Self::Electrodes => "Electrodes",
        }
    }
}

/// Choice of the points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sampling {
    /// Method.
    pub method: Method,
    /// Number of points of random and Latin-hypercube samples; none for the other methods, which have as many as their values
    /// give.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Seed of the samples: the same seed gives the same points.
    pub seed: u64,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { method: Method::Grid, count: None, seed: 1 }
    }
}

/// Method by which points are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Every value of each parameter with every value of the others. The last parameter changes first.
    Grid,
    /// The first values of all parameters, then the second ones, and so on.
    List,
    /// Points that are drawn independently.
    Random,
    /// Latin-hypercube samples: each parameter has one value in each of as many equal parts of its range as there are points.
    Latin,
}

impl Method {
    /// Whether the number of points is asked for.
    pub fn is_drawn(self) -> bool {
        matches!(self, Self::Random | Self::Latin)
    }
}

/// A parameter that is varied. It has a list of values, a range, or a folder of meshes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Key of the parameter, as for `--set`; of a mold also `library`, a file of cutters.
    pub key: String,
    /// Values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<toml::Value>,
    /// Least value of a range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Greatest value of a range.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
    /// Number of values in the range, both ends included; for whole numbers all of them by default. Drawn samples need none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub steps: Option<usize>,
    /// Folder whose meshes are the values.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub folder: Option<PathBuf>,
}

/// Columns and goals of the table of a study.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Collect {
    /// Results: names such as `certified_mm`, or places in the report of the command such as `electrodes[0].volume_mm3`. All
    /// named results where none are given.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<String>,
    /// Results of which less is better.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub less: Vec<String>,
    /// Results of which more is better.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub more: Vec<String>,
}

impl Validate for Study {
    /// Checks what can be told without the project.
    fn validate(&self) -> Result<(), Invalid> {
        if self.project.as_os_str().is_empty() {
            return Err(Invalid::of("project", "it is empty; give a project (.sparkpath) or the mesh of a part"));
        }
        self.sampling.validate().map_err(|problem| problem.within("sampling"))?;
        let count = self.parameter.len();
        if !(1..=MOST_PARAMETERS).contains(&count) {
            return Err(Invalid::new(
                "parameter",
                count,
                format!("must be from 1 to {MOST_PARAMETERS}, each as [[parameter]]"),
            ));
        }
        for (i, parameter) in self.parameter.iter().enumerate() {
            parameter.validate().map_err(|problem| problem.within(&format!("parameter[{i}]")))?;
            if self.parameter[..i].iter().any(|before| before.key == parameter.key) {
                let remedy = "is varied by an earlier parameter already; give all its values there";
                return Err(Invalid::new(format!("parameter[{i}].key"), &parameter.key, remedy));
            }
        }
        self.collect.validate().map_err(|problem| problem.within("collect"))
    }
}

impl Validate for Sampling {
    fn validate(&self) -> Result<(), Invalid> {
        match (self.method.is_drawn(), self.count) {
            (true, None) => Err(Invalid::of("count", "it is missing; give the number of points")),
            (false, Some(count)) => {
                let remedy = "only random and latin have it; remove it, the values of the parameters give the number";
                Err(Invalid::new("count", count, remedy))
            }
            (true, Some(count)) if !(1..=MOST_POINTS).contains(&count) => {
                Err(Invalid::new("count", count, format!("must be from 1 to {MOST_POINTS}")))
            }
            _ => Ok(()),
        }
    }
}

impl Validate for Parameter {
    fn validate(&self) -> Result<(), Invalid> {
        let is_range = self.from.is_some() || self.to.is_some() || self.steps.is_some();
        let given = [!self.values.is_empty(), is_range, self.folder.is_some()];
        if given.iter().filter(|is_given| **is_given).count() != 1 {
            let remedy = format!("{}: give either values, or from and to, or a folder of meshes", self.key);
            return Err(Invalid::of("key", remedy));
        }
        if self.values.len() > MOST_POINTS {
            return Err(Invalid::of("values", format!("there are {}: at most {MOST_POINTS}", self.values.len())));
        }
        if !is_range {
            return Ok(());
        }
        let [Some(from), Some(to)] = [self.from, self.to] else {
            let missing = if self.from.is_none() { "from" } else { "to" };
            return Err(Invalid::of(missing, "it is missing; a range has both ends"));
        };
        let ends = [f64::NEG_INFINITY, f64::INFINITY];
        Invalid::unless_within("from", from, ends, "")?;
        Invalid::unless_within("to", to, ends, "")?;
        if !(to - from).is_finite() || to <= from {
            return Err(Invalid::new("to", to, format!("must be greater than from, which is {from}")));
        }
        match self.steps {
            Some(steps) if !(2..=MOST_POINTS).contains(&steps) => {
                Err(Invalid::new("steps", steps, format!("must be from 2 to {MOST_POINTS}, both ends included")))
            }
            _ => Ok(()),
        }
    }
}

impl Validate for Collect {
    fn validate(&self) -> Result<(), Invalid> {
        for (list, names) in [("columns", &self.columns), ("less", &self.less), ("more", &self.more)] {
            if names.len() > 256 {
                return Err(Invalid::of(list, format!("there are {}: at most 256", names.len())));
            }
            if let Some(i) = (0..names.len()).find(|&i| names[i].trim().is_empty() || names[..i].contains(&names[i])) {
                let remedy = "must be the name of a result, given once";
                return Err(Invalid::new(format!("{list}[{i}]"), format!("{:?}", names[i]), remedy));
            }
        }
        match self.more.iter().position(|name| self.less.contains(name)) {
            Some(i) => Err(Invalid::new(format!("more[{i}]"), &self.more[i], "is in less, too; remove one of them")),
            None => Ok(()),
        }
    }
}

/// `value` as the command line would give it.
pub fn text_of(value: &toml::Value) -> String {
    match value {
        toml::Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    const HEAD: &str = "kind = \"study\"\nproject = \"a.sparkpath\"\ncommand = \"plan\"\n";

    fn said(text: &str) -> String {
        STUDIES.parse(&format!("{HEAD}{text}"), Path::new("s.toml")).map_or_else(|e| e.to_string(), |_| String::new())
    }

    #[test]
    fn every_mistake_is_named_with_its_line_and_remedy() {
        let one = "[[parameter]]\nkey = \"a.b\"\nvalues = [1]\n";
        for (text, words) in [
            (String::new(), "missing field `parameter`"),
            ("parameter = []".to_owned(), "parameter is 0: must be from 1 to 64"),
            ("[[parameter]]\nkey = \"a\"".to_owned(), "line 5: parameter[0].key: a: give either values"),
            ("[[parameter]]\nkey = \"a\"\nvalues = [1]\nfolder = \"x\"".to_owned(), "give either values"),
            ("[[parameter]]\nkey = \"a\"\nfrom = 1".to_owned(), "parameter[0].to: it is missing"),
            ("[[parameter]]\nkey = \"a\"\nfrom = 1\nto = 1".to_owned(), "must be greater than from, which is 1"),
            ("[[parameter]]\nkey = \"a\"\nfrom = 1\nto = inf".to_owned(), "parameter[0].to is inf"),
            ("[[parameter]]\nkey = \"a\"\nfrom = 1\nto = 2\nsteps = 1".to_owned(), "steps is 1: must be from 2"),
            (format!("{one}{one}"), "parameter[1].key is a.b: is varied by an earlier"),
            (format!("[sampling]\nmethod = \"latin\"\n{one}"), "sampling.count: it is missing"),
            (format!("[sampling]\ncount = 3\n{one}"), "line 5: sampling.count is 3: only random and latin"),
            (format!("[sampling]\nmethod = \"random\"\ncount = 100001\n{one}"), "from 1 to 100000"),
            (format!("{one}[collect]\nless = [\"x\"]\nmore = [\"x\"]"), "more[0] is x: is in less, too"),
            (format!("{one}[collect]\ncolumns = [\"x\", \"x\"]"), "columns[1] is \"x\": must be the name"),
            (format!("{one}stpes = 2"), "unknown field `stpes`"),
        ] {
            let said = said(&text);
            assert!(said.starts_with("s.toml: ") && said.contains(words) && !said.contains('\n'), "{text}: {said}");
        }
        assert_eq!(said(one), "");
    }

    #[test]
    fn a_study_is_read_as_it_was_written() {
        let text = format!(
            "{HEAD}[sampling]\nmethod = \"latin\"\ncount = 7\n[[parameter]]\nkey = \"a\"\nfrom = 0.1\nto = 1\n\
             [[parameter]]\nkey = \"b\"\nvalues = [1, 2.5, true, \"x\", [1, 2.5]]\n[collect]\nless = [\"d\"]\n"
        );
        let study = STUDIES.parse(&text, Path::new("s.toml")).unwrap();
        let again = STUDIES.text(Path::new("s.toml"), &study).unwrap();
        assert_eq!(STUDIES.parse(&again, Path::new("s.toml")).unwrap(), study);
        let texts: Vec<String> = study.parameter[1].values.iter().map(text_of).collect();
        assert_eq!(texts, ["1", "2.5", "true", "x", "[1, 2.5]"]);
    }
}
