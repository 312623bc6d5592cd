//! Parts that several journeys share.

use geometry::mesh::Mesh;
use wheel::parametric::{MeshResolution, ParametricBlisk};

/// A blisk with wide channels of little turning, so that small populations do.
pub fn easy_blisk() -> ParametricBlisk {
    ParametricBlisk {
        blades: 24,
        hub_radius_mm: 42.0,
        shroud_radius_mm: 50.0,
        bore_radius_mm: 28.0,
        width_mm: 14.0,
        chord_mm: 10.0,
        beta_in_deg: 20.0,
        beta_out_deg: -25.0,
        twist_deg: 2.0,
        ..Default::default()
    }
}

/// The same with channels so curved that an electrode which fills them cannot come out.
pub fn curved_blisk() -> ParametricBlisk {
    ParametricBlisk { beta_in_deg: 45.0, beta_out_deg: -45.0, ..easy_blisk() }
}

/// The mesh of a parametric blisk at the usual resolution.
pub fn mesh(blisk: &ParametricBlisk) -> Mesh {
    blisk.mesh(&MeshResolution::default()).unwrap()
}
