//! Cutters with straight flutes: cylinders and cones, and what holds them.

use serde::{Deserialize, Serialize};

use super::FlankError;
use super::ruled_surface::RuledSurface;

/// A cylinder or a cone that widens upwards. Heights are measured along the axis from the centre of its bottom circle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FlankCutter {
    /// Name in lists; may be empty.
    #[serde(default)]
    pub name: String,
    /// Radius of the bottom circle (mm), P4's r0.
    pub radius_mm: f64,
    /// Angle between axis and flute (deg), P4's alpha; 0 for a cylinder.
    #[serde(default)]
    pub taper_deg: f64,
    /// Length of the flutes (mm).
    pub length_mm: f64,
    /// Shank, holder and spindle nose above the flutes, from below upwards; empty if unknown.
    #[serde(default)]
    pub holder: Vec<HolderPart>,
}

/// A cylinder or a piece of a cone of the holder.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HolderPart {
    /// Length along the axis (mm).
    pub length_mm: f64,
    /// Radius of its lower end (mm).
    pub lower_radius_mm: f64,
    /// Radius of its upper end (mm).
    pub upper_radius_mm: f64,
}

impl FlankCutter {
    /// Radii and lengths that a cutter may have (mm).
    const LENGTHS: [f64; 2] = [1e-3, 1e4];
    /// The greatest angle between axis and flute (deg).
    pub const GREATEST_TAPER_DEG: f64 = 45.0;

    /// A cylinder without a holder.
    pub fn cylinder(radius_mm: f64, length_mm: f64) -> Self {
        Self { name: String::new(), radius_mm, taper_deg: 0.0, length_mm, holder: Vec::new() }
    }

    /// Name, shape and length of the flutes in a few words.
    pub fn words(&self) -> String {
        let shape = if self.taper_deg == 0.0 {
            format!("cylinder R{} mm", self.radius_mm)
        } else {
            format!("cone, bottom R{} mm, {} deg from axis to flute", self.radius_mm, self.taper_deg)
        };
        let name = if self.name.is_empty() { String::new() } else { format!("{}: ", self.name) };
        format!("{name}{shape}, flutes {} mm", self.length_mm)
    }

    /// A cone without a holder.
    pub fn cone(radius_mm: f64, taper_deg: f64, length_mm: f64) -> Self {
        Self { taper_deg, ..Self::cylinder(radius_mm, length_mm) }
    }

    /// Angle between axis and flute (rad).
    pub fn half_angle(&self) -> f64 {
        self.taper_deg.to_radians()
    }

    /// Cutter above a height (mm): the one that touches with that height as its bottom.
    ///
    /// # Errors
    /// [`FlankError::Parameter`] if there are no flutes above it.
    pub fn above(&self, height_mm: f64) -> Result<Self, FlankError> {
        if height_mm >= self.length_mm {
            let wanted = "less than the length of the flutes";
            return Err(FlankError::Parameter { name: "below_mm", value: height_mm, wanted });
        }
        let (radius_mm, length_mm) = (self.radius_at(height_mm), self.length_mm - height_mm);
        Ok(Self { radius_mm, length_mm, ..self.clone() })
    }

    /// Length of flutes and holder together (mm).
    pub fn tool_length(&self) -> f64 {
        self.length_mm + self.holder.iter().map(|part| part.length_mm).sum::<f64>()
    }

    /// Forgets its name where it is still that of `before`, whose flutes had another form: it would say what the cutter
    /// no longer is.
    pub fn forget_stale_name(&mut self, before: &Self) {
        let is_other = self.radius_mm != before.radius_mm || self.taper_deg != before.taper_deg;
        if is_other && self.name == before.name {
            self.name.clear();
        }
    }

    /// Radius of its cross-section at a height (mm).
    pub fn radius_at(&self, height: f64) -> f64 {
        self.radius_mm + height * self.half_angle().tan()
    }

    /// Distance from the axis at a height to the flutes, along their normal (mm): the radius of the inscribed sphere.
    pub fn sphere_at(&self, height: f64) -> f64 {
        self.radius_mm * self.half_angle().cos() + height * self.half_angle().sin()
    }

    /// Height of the circle (mm) in which the sphere around the axis at `height` touches the flutes.
    pub fn contact_height(&self, height: f64) -> f64 {
        let (sin, cos) = self.half_angle().sin_cos();
        height * cos * cos - self.radius_mm * sin * cos
    }

    /// Whether its numbers are those of a cutter.
    ///
    /// # Errors
    /// [`FlankError::Parameter`] with the name of what is wrong.
    pub fn validate(&self) -> Result<(), FlankError> {
        let [from, to] = Self::LENGTHS;
        let length = |name, value: f64, least: f64| {
            let fits = value.is_finite() && (least..=to).contains(&value);
            fits.then_some(()).ok_or(FlankError::Parameter { name, value, wanted: "a length in mm, up to 10000" })
        };
        length("cutter radius_mm", self.radius_mm, from)?;
        length("cutter length_mm", self.length_mm, from)?;
        if !(0.0..=Self::GREATEST_TAPER_DEG).contains(&self.taper_deg) {
            let wanted = "an angle from 0 (cylinder) to 45 deg, measured from the axis to the flute";
            return Err(FlankError::Parameter { name: "cutter taper_deg", value: self.taper_deg, wanted });
        }
        for part in &self.holder {
            length("holder length_mm", part.length_mm, from)?;
            length("holder lower_radius_mm", part.lower_radius_mm, 0.0)?;
            length("holder upper_radius_mm", part.upper_radius_mm, 0.0)?;
        }
        Ok(())
    }

    /// Whether it is long enough for `surface` and fits into its hollows, judged with its axis along the rulings and
    /// its bottom `below_mm` below the lower guide.
    ///
    /// # Errors
    /// [`FlankError::CutterTooShort`] or [`FlankError::CutterTooThick`] with the place; or as [`Self::validate`] and
    /// [`Self::above`].
    pub fn fits(&self, surface: &RuledSurface, below_mm: f64) -> Result<(), FlankError> {
        const PLACES: usize = 65;
        const ACROSS: usize = 8;
        self.validate()?;
        let touching = self.above(below_mm)?;
        for u in surface.places_along(PLACES) {
            let ruling = surface.point(u, 1.0) - surface.point(u, 0.0);
            let highest = self.contact_height_needed(ruling.length());
            let needed_mm = below_mm + highest;
            if needed_mm > self.length_mm {
                return Err(FlankError::CutterTooShort { length_mm: self.length_mm, needed_mm, u });
            }
            for j in 0..=ACROSS {
                let v = j as f64 / ACROSS as f64;
                let radius_mm = touching.radius_at(v * highest) / self.half_angle().cos();
                let hollow_mm = surface.hollow_radius(u, v);
                if radius_mm > hollow_mm {
                    return Err(FlankError::CutterTooThick { radius_mm, hollow_mm, u, v });
                }
            }
        }
        Ok(())
    }

    /// Height of the contact circle (mm) at the upper end of a ruling of this length that the flute lies along.
    fn contact_height_needed(&self, ruling: f64) -> f64 {
        ruling * self.half_angle().cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_only_kept_by_a_cutter_of_the_same_form() {
        let named = FlankCutter { name: "cone R1".to_owned(), ..FlankCutter::cone(1.0, 5.0, 30.0) };
        let renamed = |change: &dyn Fn(&mut FlankCutter)| {
            let mut cutter = named.clone();
            change(&mut cutter);
            cutter.forget_stale_name(&named);
            cutter.name
        };
        assert_eq!(renamed(&|c| c.radius_mm = 1.2), "");
        assert_eq!(renamed(&|c| c.taper_deg = 4.0), "");
        assert_eq!(renamed(&|c| c.length_mm = 40.0), "cone R1");
        assert_eq!(renamed(&|c| (c.radius_mm, c.name) = (1.2, "cone R1.2".to_owned())), "cone R1.2");
    }
}
