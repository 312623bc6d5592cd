//! A mesh inside a document, which is in no file of its own.

use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use geometry::mesh::Mesh;
use import::obj_bytes;

/// A mesh as the text of an OBJ file (mm), shared by copies. The text holds the mesh exactly.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeptMesh {
    /// Name of the mesh.
    pub name: String,
    /// Name of the part that the mesh belongs to, such as a mold; may be empty.
    #[serde(default)]
    pub of: String,
    /// The mesh.
    #[serde(serialize_with = "as_text", deserialize_with = "from_text")]
    pub obj: Arc<str>,
}

// Its text would fill pages.
impl fmt::Debug for KeptMesh {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "KeptMesh({} of {}, {} bytes)", self.name, self.of, self.obj.len())
    }
}

impl KeptMesh {
    /// Keeps `mesh` (mm).
    ///
    /// # Errors
    /// One line if the mesh cannot be kept.
    pub fn new(name: &str, of: &str, mesh: &Mesh) -> Result<Self, String> {
        let wrong = |why: String| format!("{name} cannot be kept: {why}; make it again");
        let bytes = obj_bytes(name, mesh).map_err(|e| wrong(e.to_string()))?;
        let obj = String::from_utf8(bytes).map_err(|e| wrong(e.to_string()))?;
        Ok(Self { name: name.to_owned(), of: of.to_owned(), obj: obj.into() })
    }

    /// Name of the mesh with that of the part it belongs to.
    pub fn words(&self) -> String {
        if self.of.is_empty() { self.name.clone() } else { format!("{} of {}", self.name, self.of) }
    }
}

fn as_text<S: Serializer>(text: &Arc<str>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(text)
}

fn from_text<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<str>, D::Error> {
    String::deserialize(deserializer).map(Into::into)
}
