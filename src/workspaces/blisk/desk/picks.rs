//! Points that are picked in the view where recognition needs help: on hub, shroud and blades, and on a circle about the
//! axis.

use glam::DVec3;

use super::BliskDesk;
use crate::widgets::theme::{AXIS, BLADE, HUB, SHROUD};
use crate::workspaces::blisk::document::job_file::PlanJob;
use crate::workspaces::blisk::document::job_file::field_table::FIELDS;
use crate::workspaces::blisk::document::stage::Stage;
use geometry::circle::Circle;
use render::colour::Colour;
use render::scene::Marker;
use wheel::options::{AxisChoice, AxisLine, BliskOptions};

/// Points of an axis that are further than this share of the radius from one circle are not on one.
const OFF_CIRCLE: f64 = 0.01;
/// A circular edge of the mesh has corners that are no further off its circle than this share of the radius.
const ON_CIRCLE: f64 = 1e-4;
/// Corners that a circular edge has at least: a circle through three corners of different edges has no more.
const LEAST_CORNERS: usize = 12;

/// What a picked point lies on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Picked {
    /// The hub.
    Hub,
    /// The shroud, or the blade tips.
    Shroud,
    /// Walls of blades.
    Blades,
    /// A circle about the axis.
    Axis,
}

impl Picked {
    /// All, in the order of their buttons.
    pub const ALL: [Self; 4] = [Self::Hub, Self::Shroud, Self::Blades, Self::Axis];

    /// Name of the surface.
    pub fn name(self) -> &'static str {
        ["Hub", "Shroud", "Blades", "Axis"][self as usize]
    }

    /// Colour of its points.
    pub fn colour(self) -> Colour {
        [HUB, SHROUD, BLADE, AXIS][self as usize]
    }

    /// Points that are needed at least.
    pub fn least(self) -> usize {
        [2, 2, 1, 3][self as usize]
    }

    /// What to click on, for the line over the view.
    pub fn asks(self) -> &'static str {
        [
            "Click points on the hub, from inlet to outlet.",
            "Click points on the shroud, or on the blade tips, from inlet to outlet.",
            "Click points on the walls of blades; the first one bounds channel 0.",
            "Click three or more places around one circular edge of a turned face. The nearest corner of the mesh is taken.",
        ][self as usize]
    }

    /// The list of the parameters that its points stand in; none for the axis, which is worked out from them.
    fn list(self, options: &mut BliskOptions) -> Option<&mut Vec<[f64; 3]>> {
        match self {
            Self::Hub => Some(&mut options.hub_points_mm),
            Self::Shroud => Some(&mut options.shroud_points_mm),
            Self::Blades => Some(&mut options.blade_points_mm),
            Self::Axis => None,
        }
    }
}

/// State of picking.
#[derive(Debug, Default)]
pub struct Picking {
    /// What is being picked.
    pub of: Option<Picked>,
    /// Points on a circle about the axis, in the coordinates of the mesh (mm).
    circle: Vec<DVec3>,
    /// The circle through them, with the greatest distance of one from it (mm), or what is wrong with them.
    found: Option<Result<(Circle, f64), String>>,
}

impl BliskDesk {
    /// Begins or ends picking points of `of`.
    pub fn toggle_picking(&mut self, of: Picked) {
        let is_on = self.picking.of != Some(of);
        self.picking = Picking { of: is_on.then_some(of), ..Default::default() };
        if is_on {
            self.step = Stage::Channel;
            self.measuring = false;
        }
    }

    /// What is being picked, in the step Channel.
    pub fn picking(&self) -> Option<Picked> {
        self.picking.of.filter(|_| self.step == Stage::Channel)
    }

    /// The picked points, in the coordinates of the mesh (mm).
    pub fn picked(&self, of: Picked) -> Vec<DVec3> {
        let options = &self.document.params().blisk.options;
        let list = match of {
            Picked::Hub => &options.hub_points_mm,
            Picked::Shroud => &options.shroud_points_mm,
            Picked::Blades => &options.blade_points_mm,
            Picked::Axis => return self.picking.circle.clone(),
        };
        list.iter().map(|p| DVec3::from_array(*p)).collect()
    }

    /// Adds a point of what is being picked.
    pub fn add_picked(&mut self, at: DVec3) {
        match self.picking() {
            Some(Picked::Axis) => {
                self.picking.circle.push(self.nearest_corner(at));
                self.take_axis();
            }
            Some(of) => self.change_picked(of, |list| list.push(at.to_array().map(|c| rounded(c, 1e-4)))),
            None => {}
        }
    }

    /// Takes a point away again.
    pub fn remove_picked(&mut self, of: Picked, index: usize) {
        if index >= self.picked(of).len() {
            return;
        }
        if of == Picked::Axis {
            self.picking.circle.remove(index);
            return self.take_axis();
        }
        self.change_picked(of, |list| {
            list.remove(index);
        });
    }

    /// Takes the last point of what is being picked away again.
    pub fn remove_last_picked(&mut self) {
        let Some(of) = self.picking() else { return };
        if let Some(last) = self.picked(of).len().checked_sub(1) {
            self.remove_picked(of, last);
        }
    }

    /// Takes all points of `of` away.
    pub fn clear_picked(&mut self, of: Picked) {
        self.picking = Picking { of: self.picking.of, ..Default::default() };
        self.change_picked(of, Vec::clear);
    }

    /// Dots of the picked points, in the step Channel.
    pub fn picked_markers(&self) -> Vec<Marker> {
        let is_shown = self.step == Stage::Channel;
        let of =
            |of: Picked| self.picked(of).into_iter().map(move |at| Marker { at, colour: of.colour(), radius_px: 5.0 });
        Picked::ALL.into_iter().filter(|_| is_shown).flat_map(of).collect()
    }

    /// The circle through the points of the axis, with the greatest distance of one from it (mm), or what is wrong with
    /// them; none as long as there are too few.
    pub fn picked_circle(&self) -> Option<&Result<(Circle, f64), String>> {
        self.picking.found.as_ref()
    }

    fn find_circle(&self) -> Result<(Circle, f64), String> {
        let points = &self.picking.circle;
        let circle = Circle::through(points).ok_or("these points lie on a line: pick points around a circle")?;
        let off = points.iter().map(|p| circle.distance(*p)).fold(0.0, f64::max);
        if off > OFF_CIRCLE * circle.radius {
            return Err(format!("these points are not on one circle: one is {off:.3} mm off; remove it"));
        }
        let corners = self.work.part().into_iter().flat_map(|part| &part.mesh.vertices);
        let near = off.max(ON_CIRCLE * circle.radius);
        if corners.filter(|p| circle.distance(**p) <= near).take(LEAST_CORNERS).count() < LEAST_CORNERS {
            return Err("no edge of the wheel runs along the circle through these points: remove those that are on \
                        another edge"
                .to_owned());
        }
        Ok((circle, off))
    }

    fn change_picked(&mut self, of: Picked, change: impl FnOnce(&mut Vec<[f64; 3]>)) {
        self.change_job(|job| {
            if let Some(list) = of.list(&mut job.blisk.options) {
                change(list);
            }
        });
    }

    /// Makes the axis of the picked circle the axis of the parameters.
    fn take_axis(&mut self) {
        self.picking.found = (self.picking.circle.len() >= Picked::Axis.least()).then(|| self.find_circle());
        let Some(Ok((Circle { centre, normal, .. }, _))) = self.picking.found else { return };
        // As W: towards the positive side of the axis of the mesh that it is nearest to.
        let main = normal.abs().max_position();
        let direction = if normal[main] < 0.0 { -normal } else { normal };
        let line = AxisLine {
            direction: direction.to_array().map(|c| rounded(c, 1e-9)),
            point: centre.to_array().map(|c| rounded(c, 1e-6)),
        };
        self.change_job(|job| job.blisk.options.axis = AxisChoice::Line(line));
    }

    /// Changes the parameters in one step that can be undone.
    pub fn change_job(&mut self, change: impl FnOnce(&mut PlanJob)) {
        let mut job = self.document.params().clone();
        change(&mut job);
        if job != *self.document.params() {
            let label = FIELDS.change(self.document.params(), &job);
            self.edit(&label, job, false);
        }
    }

    /// The corner of the part's mesh that is nearest to `at`: corners lie on the surface that the mesh stands for.
    fn nearest_corner(&self, at: DVec3) -> DVec3 {
        let corners = self.work.part().into_iter().flat_map(|part| &part.mesh.vertices).copied();
        corners.min_by(|a, b| a.distance_squared(at).total_cmp(&b.distance_squared(at))).unwrap_or(at)
    }
}

/// `value` rounded to a multiple of `unit`, without a negative zero.
fn rounded(value: f64, unit: f64) -> f64 {
    let digits = (1.0 / unit).round();
    (value * digits).round() / digits + 0.0
}
