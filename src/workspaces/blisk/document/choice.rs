//! Choices of `[export]` beside the post: the files of a plan, and the frame of the meshes. By default all files are
//! written.

use serde::{Deserialize, Serialize};

/// Frame of the electrode meshes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MeshFrame {
    /// The frame of the loaded mesh.
    #[default]
    Mesh,
    /// The workpiece frame W, whose place in the coordinates of the loaded mesh stands in every result.
    W,
}

impl MeshFrame {
    /// Name of the frame for a reader.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh => "frame of the loaded mesh",
            Self::W => "workpiece frame W",
        }
    }
}

/// `[export.files]`: files that are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WrittenFiles {
    /// `electrode_K.stl`
    pub electrode: bool,
    /// `electrode_K.step`: the electrode with faces.
    pub step: bool,
    /// `path_K.csv`, and `path_K.unverified.csv` of a path that is not verified.
    pub path: bool,
    /// The NC program of a verified path.
    pub nc: bool,
    /// `report.json` and `report.html`
    pub report: bool,
    /// `leftover.ply`: the surface of the channel with the residual stock at every vertex, and `copying_K.csv`, the
    /// copying motion of a verified path.
    #[serde(rename = "leftover")]
    pub residual_stock: bool,
    /// The pictures as PNG files; the page of the report holds them in any case.
    pub pictures: bool,
}

impl Default for WrittenFiles {
    fn default() -> Self {
        Self { electrode: true, step: false, path: true, nc: true, report: true, residual_stock: true, pictures: true }
    }
}

impl WrittenFiles {
    /// Every kind of file with its key, in the order of the fields.
    pub fn kinds(&self) -> [(&'static str, bool); 7] {
        [
            ("electrode", self.electrode),
            ("step", self.step),
            ("path", self.path),
            ("nc", self.nc),
            ("report", self.report),
            ("leftover", self.residual_stock),
            ("pictures", self.pictures),
        ]
    }

    /// Whether any file is written.
    pub fn any(&self) -> bool {
        self.kinds().iter().any(|(_, wanted)| *wanted)
    }
}

/// `[export.pictures]`: pictures that are drawn, for the report and as files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DrawnPictures {
    /// The whole blisk with its electrodes.
    pub whole: bool,
    /// Whether each electrode is drawn in its final pose.
    pub final_pose: bool,
    /// Whether each electrode is drawn on its way.
    pub sweep: bool,
    /// A section where each electrode comes closest, or jams.
    pub closest: bool,
    /// The residual stock on the surfaces of the channel.
    #[serde(rename = "leftover")]
    pub residual_stock: bool,
}

impl Default for DrawnPictures {
    fn default() -> Self {
        Self { whole: true, final_pose: true, sweep: true, closest: true, residual_stock: true }
    }
}

impl DrawnPictures {
    /// Whether any picture is drawn.
    pub fn any(&self) -> bool {
        self.whole || self.final_pose || self.sweep || self.closest || self.residual_stock
    }
}

/// `channels` of `[export]`: channels in which the motion is simulated and the program burns.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "toml::Value", into = "String")]
pub enum Channels {
    /// The channel of the plan.
    #[default]
    Own,
    /// All channels of the blisk.
    All,
    /// The channels with these numbers.
    These(Vec<usize>),
}

/// Remedy for a wrong value.
const CHANNELS_FORM: &str = "give \"own\", \"all\", or numbers as in [0, 1, 2] or \"0,1,2\"";

impl TryFrom<toml::Value> for Channels {
    type Error = String;

    /// The choice in files: a word, numbers with commas between, a number, or a list.
    fn try_from(value: toml::Value) -> Result<Self, String> {
        let wrong = || format!("channels = {value}: {CHANNELS_FORM}");
        let number = |v: &toml::Value| v.as_integer().and_then(|n| usize::try_from(n).ok()).ok_or_else(wrong);
        match &value {
            toml::Value::String(text) => text.parse(),
            toml::Value::Array(list) if !list.is_empty() => {
                list.iter().map(number).collect::<Result<_, _>>().map(Self::These)
            }
            other => number(other).map(|n| Self::These(vec![n])),
        }
    }
}

impl std::str::FromStr for Channels {
    type Err = String;

    /// Reads a choice of channels from text. A list may be in brackets.
    fn from_str(text: &str) -> Result<Self, String> {
        let number = |n: &str| n.trim().parse::<usize>();
        match text.trim() {
            "own" => Ok(Self::Own),
            "all" => Ok(Self::All),
            list => {
                let inner = list.strip_prefix('[').and_then(|l| l.strip_suffix(']')).unwrap_or(list);
                let numbers = inner.split(',').map(number).collect::<Result<_, _>>();
                numbers.map(Self::These).map_err(|_| format!("channels = {list:?}: {CHANNELS_FORM}"))
            }
        }
    }
}

impl From<Channels> for String {
    fn from(channels: Channels) -> Self {
        match channels {
            Channels::Own => "own".to_owned(),
            Channels::All => "all".to_owned(),
            Channels::These(list) => list.iter().map(usize::to_string).collect::<Vec<_>>().join(","),
        }
    }
}

impl Channels {
    /// Numbers of the chosen channels, each once, in a blisk with `total` channels. `own` is the channel of the plan.
    ///
    /// # Errors
    /// One line if a number is that of no channel.
    pub fn numbers(&self, total: usize, own: usize) -> Result<Vec<usize>, String> {
        let mut numbers = match self {
            Self::Own => vec![own],
            Self::All => (0..total).collect(),
            Self::These(list) => list.clone(),
        };
        if let Some(wrong) = numbers.iter().find(|n| **n >= total) {
            return Err(format!("export.channels: there is no channel {wrong}; there are {total}, counted from 0"));
        }
        numbers.sort_unstable();
        numbers.dedup();
        Ok(numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_said_is_written_in_the_frame_of_the_loaded_mesh() {
        let files: WrittenFiles = toml::from_str("nc = false").unwrap();
        assert_eq!(files, WrittenFiles { nc: false, ..Default::default() });
        assert!(toml::from_str::<WrittenFiles>("stl = false").is_err(), "a misspelt key is no choice");
        assert_eq!(MeshFrame::default(), MeshFrame::Mesh);
    }
    #[test]
    fn channels_are_words_or_numbers() {
        let read = |text: &str| toml::from_str::<toml::Table>(text).unwrap()["c"].clone().try_into::<Channels>();
        assert_eq!(read("c = \"all\"").unwrap().numbers(4, 2), Ok(vec![0, 1, 2, 3]));
        assert_eq!(read("c = \"own\"").unwrap().numbers(4, 2), Ok(vec![2]));
        for text in ["c = [3, 1, 3]", "c = \"3, 1,3\"", "c = \"[3, 1]\""] {
            let channels = read(text).unwrap();
            assert_eq!(channels.numbers(4, 0), Ok(vec![1, 3]));
            assert!(channels.numbers(3, 0).unwrap_err().contains("no channel 3"));
        }
        assert_eq!(read("c = 3").unwrap(), Channels::These(vec![3]));
        for wrong in ["c = \"some\"", "c = []", "c = [-1]", "c = [0.5]", "c = \"\"", "c = true"] {
            let error = read(wrong).unwrap_err().to_string();
            assert!(error.contains("[0, 1, 2]") && error.contains("\"0,1,2\""), "{error}");
        }
    }
}
