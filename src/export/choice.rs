//! What of a plan is written, and in which frame: the choices of `[export]` beside the post. By default all of it.

use serde::{Deserialize, Serialize};

/// The frame that electrode meshes are written in.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MeshFrame {
    /// That of the loaded mesh.
    #[default]
    Mesh,
    /// The workpiece frame W, whose place in the coordinates of the loaded mesh stands in every result.
    W,
}

impl MeshFrame {
    /// Its name for a reader.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mesh => "frame of the loaded mesh",
            Self::W => "workpiece frame W",
        }
    }
}

/// `[export.files]`: which files are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct WrittenFiles {
    /// `electrode_K.stl`
    pub electrode: bool,
    /// `path_K.csv`, and `path_K.unverified.csv` of a path that is not verified.
    pub path: bool,
    /// The NC program of a verified path.
    pub nc: bool,
    /// `report.json` and `report.html`
    pub report: bool,
    /// `leftover.ply`: the surface of the channel with the stock left at every vertex, and `copying_K.csv`, the copying
    /// motion of a verified path.
    pub leftover: bool,
    /// The pictures as PNG files; the page of the report holds them in any case.
    pub pictures: bool,
}

impl Default for WrittenFiles {
    fn default() -> Self {
        Self { electrode: true, path: true, nc: true, report: true, leftover: true, pictures: true }
    }
}

impl WrittenFiles {
    /// Every kind with its key, in the order of the fields.
    pub fn kinds(&self) -> [(&'static str, bool); 6] {
        [
            ("electrode", self.electrode),
            ("path", self.path),
            ("nc", self.nc),
            ("report", self.report),
            ("leftover", self.leftover),
            ("pictures", self.pictures),
        ]
    }

    /// Whether anything is written at all.
    pub fn any(&self) -> bool {
        self.kinds().iter().any(|(_, wanted)| *wanted)
    }
}

/// `[export.pictures]`: which pictures are drawn, for the report and as files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DrawnPictures {
    /// The whole blisk with its electrodes.
    pub whole: bool,
    /// Each electrode in its final pose.
    pub final_pose: bool,
    /// Each electrode on its way.
    pub sweep: bool,
    /// A section where each electrode comes closest, or jams.
    pub closest: bool,
    /// The stock left on the surfaces of the channel.
    pub leftover: bool,
}

impl Default for DrawnPictures {
    fn default() -> Self {
        Self { whole: true, final_pose: true, sweep: true, closest: true, leftover: true }
    }
}

impl DrawnPictures {
    /// Whether any picture is drawn.
    pub fn any(&self) -> bool {
        self.whole || self.final_pose || self.sweep || self.closest || self.leftover
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
}
