//! What is opened: read in the background, before it takes the place of what is open.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use task::{Cancel, Progress};

use super::workspace::Workspace;
use crate::workspaces::blisk::document::Document;
use crate::workspaces::blisk::job::stages;
use crate::workspaces::blisk::job::stages::Part;
use crate::workspaces::flank::document::FlankDocument;
use crate::workspaces::flank::work::{FlankWork, LoadedFlank};
use crate::workspaces::mold::document::MoldParams;
use crate::workspaces::mold::work::{LoadedMold, read_part};

/// A document, and its part once that was read.
#[derive(Debug, Clone)]
pub enum Incoming {
    /// A blisk.
    Blisk(Box<Document>, Option<Arc<Part>>),
    /// A mold: the file that holds it, or none of a bare mesh.
    Mold(Box<MoldParams>, Option<PathBuf>, Option<Arc<LoadedMold>>),
    /// A flank, and the file that holds it if there is one.
    Flank(Box<FlankDocument>, Option<PathBuf>, Option<Arc<LoadedFlank>>),
}

impl Incoming {
    /// The workspace where it belongs.
    pub fn workspace(&self) -> Workspace {
        match self {
            Self::Blisk(..) => Workspace::Blisk,
            Self::Mold(..) => Workspace::Mold,
            Self::Flank(..) => Workspace::Flank,
        }
    }

    /// Whether it is a mesh of a mold, with which everything that was chosen before there was a mold goes on.
    pub fn is_bare_mold(&self) -> bool {
        matches!(self, Self::Mold(_, None, _))
    }

    /// What to call it before it is open: its file, or else the document.
    pub fn name(&self) -> String {
        let file = match self {
            Self::Blisk(document, _) => document.file().or(document.job().blisk.mesh.as_deref()),
            Self::Mold(params, file, _) => file.as_deref().or(params.mesh.as_deref()),
            Self::Flank(_, file, _) => file.as_deref(),
        };
        match (self, file.and_then(Path::file_name)) {
            (_, Some(name)) => name.to_string_lossy().into_owned(),
            (Self::Flank(document, ..), None) => document.name(),
            (_, None) => "the part".to_owned(),
        }
    }

    /// The same with its part, which is read from its files.
    ///
    /// # Errors
    /// One line naming file, place and remedy.
    pub fn read(&self, progress: &Progress, cancel: &Cancel) -> Result<Self, String> {
        Ok(match self {
            Self::Blisk(document, _) => {
                let part = stages::load(document.job(), progress, cancel)?;
                Self::Blisk(document.clone(), Some(Arc::new(part)))
            }
            Self::Mold(params, file, _) => {
                let part = params.mesh.as_ref().map(|mesh| read_part(mesh, params.units, progress, cancel));
                Self::Mold(params.clone(), file.clone(), part.transpose()?.map(Arc::new))
            }
            Self::Flank(document, file, _) => {
                let part = FlankWork::read(document, progress, cancel)?;
                Self::Flank(document.clone(), file.clone(), Some(Arc::new(part)))
            }
        })
    }
}
