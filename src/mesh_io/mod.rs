//! mesh_io
