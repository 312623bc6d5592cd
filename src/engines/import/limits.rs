//! Limits of an import, checked by arithmetic before anything is allocated.

use serde::{Deserialize, Serialize};

use super::error::ImportError;

/// The most an import may take; what exceeds it is refused before it is allocated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImportLimits {
    /// Size of a file, and of all its buffer files together (bytes).
    pub max_file_bytes: u64,
    /// Triangles of a mesh.
    pub max_triangles: u64,
    /// Estimated memory while importing (bytes).
    pub max_memory_bytes: u64,
}

impl Default for ImportLimits {
    fn default() -> Self {
        Self { max_file_bytes: 2 << 30, max_triangles: 20_000_000, max_memory_bytes: 8 << 30 }
    }
}

/// Vertex numbers are 32 bits wide and a triangle may bring three of its own, so no mesh can be larger than this.
pub(super) const TRIANGLES_ADDRESSABLE: u64 = u32::MAX as u64 / 3;

/// Working memory of welding and repair per triangle and per vertex (bytes), from the sizes of their tables.
const BYTES_PER_TRIANGLE: u64 = 100;
const BYTES_PER_VERTEX: u64 = 100;

impl ImportLimits {
    /// Checks these limits.
    ///
    /// # Errors
    /// [`ImportError::BadOption`] for a limit of zero or more triangles than can be numbered.
    pub fn validate(&self) -> Result<(), ImportError> {
        let bad = |problem: &str| Err(ImportError::BadOption { problem: problem.to_owned() });
        if self.max_file_bytes == 0 || self.max_triangles == 0 || self.max_memory_bytes == 0 {
            return bad("an import limit is 0; give a positive number of bytes or triangles");
        }
        if self.max_triangles > TRIANGLES_ADDRESSABLE {
            return bad("max_triangles is beyond what 32-bit vertex numbers can address; give at most 1431655765");
        }
        Ok(())
    }

    /// Refuses a file of `bytes` bytes that is too long.
    pub(super) fn check_file(&self, file: &str, bytes: u64) -> Result<(), ImportError> {
        within(file, "bytes", bytes, self.max_file_bytes, "max_file_bytes")
    }

    /// Refuses a mesh of so many triangles and vertices, read from `bytes` bytes, before it is allocated.
    pub(super) fn check_mesh(&self, file: &str, bytes: u64, triangles: u64, vertices: u64) -> Result<(), ImportError> {
        within(file, "triangles", triangles, self.max_triangles, "max_triangles")?;
        let memory = triangles
            .saturating_mul(BYTES_PER_TRIANGLE)
            .saturating_add(vertices.saturating_mul(BYTES_PER_VERTEX))
            .saturating_add(bytes);
        within(file, "bytes of memory", memory, self.max_memory_bytes, "max_memory_bytes")
    }

    /// Refuses tables of `memory` bytes in all.
    pub(super) fn check_memory(&self, file: &str, memory: u64) -> Result<(), ImportError> {
        within(file, "bytes of memory", memory, self.max_memory_bytes, "max_memory_bytes")
    }
}

fn within(file: &str, what: &'static str, found: u64, limit: u64, option: &'static str) -> Result<(), ImportError> {
    if found <= limit {
        return Ok(());
    }
    Err(ImportError::TooLarge { file: file.to_owned(), what, found, limit, option })
}
