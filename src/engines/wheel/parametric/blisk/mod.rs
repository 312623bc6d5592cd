//! Axial blisks whose walls are known exactly.
//!
//! The axis is X and the blades stand between `x = 0` (leading edge at mid-span) and `x = chord`. Channel 0, between
//! blade 0 and blade 1, has its middle at mid-chord on +Z, so that for it the workpiece frame W is the mesh's own.
//! Sections follow [`BladeProfile`]; they are turned, leant and scaled linearly from the hub to the tip.

use std::f64::consts::TAU;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::channel::BladeSide;
use crate::profile::{BladeProfile, ProfileParams};
use geometry::frame::Cylindrical;
use geometry::mesh::Mesh;
use mesher::Mesher;

mod mesher;

/// A blisk described by parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ParametricBlisk {
    /// Number of blades.
    pub blades: usize,
    /// Hub radius at mid-chord (mm).
    pub hub_radius_mm: f64,
    /// Shroud radius at mid-chord, or blade tip radius without a shroud (mm).
    pub shroud_radius_mm: f64,
    /// Growth of the hub radius along X (mm per mm).
    pub hub_slope: f64,
    /// Growth of the shroud or tip radius along X (mm per mm).
    pub shroud_slope: f64,
    /// Radius of the bore (mm).
    pub bore_radius_mm: f64,
    /// Least thickness of the ring outside the shroud (mm).
    pub wall_mm: f64,
    /// Width of the blisk between its faces (mm).
    pub width_mm: f64,
    /// Axial chord of the blades at the hub, between the tips of the edges (mm).
    pub chord_mm: f64,
    /// Blade angle at the leading edge, at mid-span, measured from the axis; beta_in (deg).
    pub beta_in_deg: f64,
    /// Blade angle at the trailing edge, at mid-span, measured from the axis; beta_out (deg).
    pub beta_out_deg: f64,
    /// Wedge angle of the leading edge (deg).
    pub wedge_in_deg: f64,
    /// Wedge angle of the trailing edge (deg).
    pub wedge_out_deg: f64,
    /// Greatest thickness of the blades, at mid-chord, at the hub (mm).
    pub max_thickness_mm: f64,
    /// Radius of the leading edge at the hub (mm).
    pub leading_radius_mm: f64,
    /// Radius of the trailing edge at the hub (mm).
    pub trailing_radius_mm: f64,
    /// Growth of both blade angles from the hub to the tip (deg).
    pub twist_deg: f64,
    /// Lean of the stacking line towards greater theta (deg).
    pub lean_deg: f64,
    /// Taper: 0 for the same section at tip and hub, 0.2 for a tip smaller by a fifth.
    pub taper: f64,
    /// Whether a ring closes the channels outside.
    pub shrouded: bool,
}

impl Default for ParametricBlisk {
    fn default() -> Self {
        Self {
            blades: 60,
            hub_radius_mm: 110.0,
            shroud_radius_mm: 125.0,
            hub_slope: 0.0,
            shroud_slope: 0.0,
            bore_radius_mm: 60.0,
            wall_mm: 5.0,
            width_mm: 26.0,
            chord_mm: 20.0,
            beta_in_deg: 45.0,
            beta_out_deg: -50.0,
            wedge_in_deg: 20.0,
            wedge_out_deg: 14.0,
            max_thickness_mm: 3.2,
            leading_radius_mm: 0.4,
            trailing_radius_mm: 0.3,
            twist_deg: 6.0,
            lean_deg: 0.0,
            taper: 0.0,
            shrouded: true,
        }
    }
}

/// Resolution of the mesh of a parametric blisk: numbers of intervals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshResolution {
    /// Round each edge, from its tip.
    pub edge: usize,
    /// Along the chord between the edges.
    pub chord: usize,
    /// From hub to tip.
    pub span: usize,
    /// Across a channel, from blade to blade.
    pub pitch: usize,
    /// Along X on the rings before and behind the blades.
    pub ring: usize,
}

impl Default for MeshResolution {
    fn default() -> Self {
        Self { edge: 6, chord: 22, span: 4, pitch: 3, ring: 1 }
    }
}

/// Reason why a parametric blisk cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ParametricError {
    /// A parameter is out of its range.
    #[error("{name} is {value}: it must be {must}")]
    OutOfRange {
        /// The parameter's name.
        name: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Range of valid values.
        must: String,
    },
    /// The two sides of a blade cross.
    #[error(
        "the blade section at radius {radius:.2} mm has no thickness at x = {x:.2} mm: \
         raise max_thickness_mm, or lower wedge_in_deg and wedge_out_deg"
    )]
    SidesCross {
        /// Radius of the section (mm).
        radius: f64,
        /// Where along the axis (mm).
        x: f64,
    },
    /// Neighbouring blades touch.
    #[error(
        "neighbouring blades leave only {passage:.3} mm between them at x = {x:.2} mm, radius {radius:.2} mm: \
         use fewer blades, thinner blades, or a greater hub radius"
    )]
    BladesTouch {
        /// Free width along the circumference (mm).
        passage: f64,
        /// Place along the axis (mm).
        x: f64,
        /// Radius of the place (mm).
        radius: f64,
    },
}

/// One of the two walls of channel 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChannelSide {
    /// The wall on the side of smaller theta.
    Low,
    /// The wall on the side of greater theta.
    High,
}

/// The least passage between neighbouring blades that is still meshed (mm).
const LEAST_PASSAGE: f64 = 0.2;

impl ParametricBlisk {
    /// A shrouded turbine wheel of moderate turning whose electrode comes out in one part.
    pub fn turbine() -> Self {
        Self {
            blades: 44,
            hub_radius_mm: 96.0,
            shroud_radius_mm: 112.0,
            shroud_slope: 0.06,
            bore_radius_mm: 58.0,
            wall_mm: 5.0,
            width_mm: 28.0,
            chord_mm: 20.0,
            beta_in_deg: 30.0,
            beta_out_deg: -40.0,
            wedge_in_deg: 20.0,
            wedge_out_deg: 12.0,
            max_thickness_mm: 3.4,
            leading_radius_mm: 0.5,
            trailing_radius_mm: 0.35,
            twist_deg: 5.0,
            lean_deg: 1.0,
            taper: 0.05,
            ..Self::default()
        }
    }

    /// The angle from blade to blade (rad).
    pub fn pitch(&self) -> f64 {
        TAU / self.blades as f64
    }

    /// Hub radius and shroud (or tip) radius at `x` (mm).
    pub fn radii(&self, x: f64) -> (f64, f64) {
        let from_middle = x - 0.5 * self.chord_mm;
        (self.hub_radius_mm + self.hub_slope * from_middle, self.shroud_radius_mm + self.shroud_slope * from_middle)
    }

    /// The two faces of the blisk (mm along X).
    pub fn faces_x(&self) -> [f64; 2] {
        [0.5 * (self.chord_mm - self.width_mm), 0.5 * (self.chord_mm + self.width_mm)]
    }

    /// Radius of the outside of the ring (mm).
    pub fn outer_radius(&self) -> f64 {
        self.faces_x().map(|x| self.radii(x).1).into_iter().fold(0.0, f64::max) + self.wall_mm
    }

    /// Tip of the leading edge at radius `r` (mm along X).
    pub fn x_le(&self, r: f64) -> f64 {
        0.5 * self.chord_mm * (1.0 - self.scale(r))
    }

    /// Tip of the trailing edge at radius `r` (mm along X).
    pub fn x_te(&self, r: f64) -> f64 {
        0.5 * self.chord_mm * (1.0 + self.scale(r))
    }

    /// The angle theta of a wall of channel 0 at `x` (taken into the blade's span) and radius `r`, edges included:
    /// the low wall is the upper side of blade 0, the high wall the lower side of blade 1 (rad).
    pub fn wall_theta(&self, side: ChannelSide, x: f64, r: f64) -> f64 {
        let profile = self.profile(r);
        let along = x - self.x_le(r);
        let lean = self.lean_deg.to_radians().tan() * (r - 0.5 * (self.hub_radius_mm + self.shroud_radius_mm));
        match side {
            ChannelSide::Low => (profile.upper_y(along) + lean) / r - 0.5 * self.pitch(),
            ChannelSide::High => (profile.lower_y(along) + lean) / r + 0.5 * self.pitch(),
        }
    }

    /// Point of a wall of channel 0 (mm) at a share of the chord, from the leading edge, and a share of the height, from
    /// the hub; and the unit normal there, into the channel.
    pub fn wall_at(&self, side: ChannelSide, along: f64, height: f64) -> [DVec3; 2] {
        const STEP: f64 = 1e-4;
        let at = |along: f64, height: f64| {
            let (mut x, mut r) = (0.5 * self.chord_mm, 0.0);
            for _ in 0..40 {
                let (hub, tip) = self.radii(x);
                r = hub + height * (tip - hub);
                x = self.x_le(r) + along * (self.x_te(r) - self.x_le(r));
            }
            Cylindrical { x, r, theta: self.wall_theta(side, x, r) }.point()
        };
        let chordwise = at((along + STEP).min(1.0), height) - at((along - STEP).max(0.0), height);
        let normal = chordwise.cross(at(along, height + STEP) - at(along, height - STEP)).normalize_or(DVec3::Z);
        [at(along, height), if side == ChannelSide::Low { normal } else { -normal }]
    }

    /// Face of its blade that a wall of the channels is, by the sense of the turning.
    pub fn blade_side(&self, side: ChannelSide) -> BladeSide {
        let falling = self.beta_in_deg - self.beta_out_deg;
        if falling == 0.0 {
            BladeSide::Flat
        } else if (falling > 0.0) == (side == ChannelSide::Low) {
            BladeSide::Suction
        } else {
            BladeSide::Pressure
        }
    }

    /// The blade's section at radius `r`, with `x` counted from [`x_le`](Self::x_le).
    pub fn profile(&self, r: f64) -> BladeProfile {
        let scale = self.scale(r);
        let twist = self.twist_deg * (self.span_fraction(r) - 0.5);
        BladeProfile::new(&ProfileParams {
            chord: scale * self.chord_mm,
            beta_in: (self.beta_in_deg + twist).to_radians(),
            beta_out: (self.beta_out_deg + twist).to_radians(),
            wedge_in: self.wedge_in_deg.to_radians(),
            wedge_out: self.wedge_out_deg.to_radians(),
            thickness: scale * self.max_thickness_mm,
            leading_radius: scale * self.leading_radius_mm,
            trailing_radius: scale * self.trailing_radius_mm,
        })
    }

    fn span_fraction(&self, r: f64) -> f64 {
        (r - self.hub_radius_mm) / (self.shroud_radius_mm - self.hub_radius_mm)
    }

    fn scale(&self, r: f64) -> f64 {
        1.0 - self.taper * self.span_fraction(r)
    }

    /// Checks that the blisk can be built.
    pub fn validate(&self) -> Result<(), ParametricError> {
        let within = |name, value: f64, from: f64, to: f64| {
            if (from..=to).contains(&value) {
                return Ok(());
            }
            Err(ParametricError::OutOfRange { name, value, must: format!("from {from} to {to}") })
        };
        within("blades", self.blades as f64, 3.0, 1000.0)?;
        within("bore_radius_mm", self.bore_radius_mm, 0.5, 5000.0)?;
        within("hub_slope", self.hub_slope, -1.0, 1.0)?;
        within("shroud_slope", self.shroud_slope, -1.0, 1.0)?;
        within("wall_mm", self.wall_mm, 0.5, 500.0)?;
        within("chord_mm", self.chord_mm, 1.0, 500.0)?;
        within("width_mm", self.width_mm, self.chord_mm * (1.0 + self.taper.max(0.0)) + 0.2, 1000.0)?;
        within("wedge_in_deg", self.wedge_in_deg, 0.0, 60.0)?;
        within("wedge_out_deg", self.wedge_out_deg, 0.0, 60.0)?;
        within("twist_deg", self.twist_deg, -60.0, 60.0)?;
        let steepest = 75.0 - 0.5 * self.twist_deg.abs() - 0.5 * self.wedge_in_deg.max(self.wedge_out_deg);
        within("beta_in_deg", self.beta_in_deg, -steepest, steepest)?;
        within("beta_out_deg", self.beta_out_deg, -steepest, steepest)?;
        within("lean_deg", self.lean_deg, -45.0, 45.0)?;
        within("taper", self.taper, -0.5, 0.5)?;
        within("max_thickness_mm", self.max_thickness_mm, 0.1, 0.5 * self.chord_mm)?;
        within("leading_radius_mm", self.leading_radius_mm, 0.02, 0.2 * self.chord_mm)?;
        within("trailing_radius_mm", self.trailing_radius_mm, 0.02, 0.2 * self.chord_mm)?;
        let hub_least = self.faces_x().map(|x| self.radii(x).0).into_iter().fold(f64::INFINITY, f64::min);
        within("bore_radius_mm", self.bore_radius_mm, 0.5, hub_least - 0.5)?;
        let passage = self.faces_x().map(|x| self.radii(x)).map(|(hub, tip)| tip - hub);
        let least = passage.into_iter().fold(f64::INFINITY, f64::min);
        if least.is_nan() || least < 0.5 {
            let must = format!("at least 0.5 mm above the hub at both faces, where it is {least:.3} mm above it");
            return Err(ParametricError::OutOfRange { name: "shroud_radius_mm", value: self.shroud_radius_mm, must });
        }
        self.validate_blades()
    }

    fn validate_blades(&self) -> Result<(), ParametricError> {
        let radii = self.faces_x().map(|x| self.radii(x));
        let lowest = radii[0].0.min(radii[1].0);
        let highest = radii[0].1.max(radii[1].1);
        for i in 0..=8 {
            let radius = lowest + (highest - lowest) * f64::from(i) / 8.0;
            let (thickness, x) = self.profile(radius).least_thickness();
            if thickness.is_nan() || thickness < self.leading_radius_mm.min(self.trailing_radius_mm) {
                return Err(ParametricError::SidesCross { radius, x: x + self.x_le(radius) });
            }
            for k in 0..=100 {
                let x = self.x_le(radius) + (self.x_te(radius) - self.x_le(radius)) * f64::from(k) / 100.0;
                let angle =
                    self.wall_theta(ChannelSide::High, x, radius) - self.wall_theta(ChannelSide::Low, x, radius);
                let passage = angle * radius;
                if passage < LEAST_PASSAGE {
                    return Err(ParametricError::BladesTouch { passage, x, radius });
                }
            }
        }
        Ok(())
    }

    /// The blisk as a closed mesh with shared vertices, normals outwards.
    ///
    /// # Errors
    /// A [`ParametricError`] that says which parameters do not go together.
    pub fn mesh(&self, resolution: &MeshResolution) -> Result<Mesh, ParametricError> {
        self.validate()?;
        for (name, value) in [
            ("edge", resolution.edge),
            ("chord", resolution.chord),
            ("span", resolution.span),
            ("pitch", resolution.pitch),
            ("ring", resolution.ring),
        ] {
            if !(1..=500).contains(&value) {
                let must = "from 1 to 500 intervals".to_owned();
                return Err(ParametricError::OutOfRange { name, value: value as f64, must });
            }
        }
        Ok(Mesher::new(self, *resolution).build())
    }
}

#[cfg(test)]
pub(crate) mod tests;
