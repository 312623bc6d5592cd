//! Where a picture is taken from, in f64. Pixels count from the upper left corner, x to the right and y down;
//! the centre of the first pixel is (0.5, 0.5).

use glam::{DMat3, DMat4, DQuat, DVec2, DVec3, DVec4};

use geometry::mesh::Bounds;

/// The vertical field of view a camera starts with (rad), 30 degrees.
pub const DEFAULT_FIELD_OF_VIEW: f64 = std::f64::consts::FRAC_PI_6;
/// Nearest and furthest distance to the target (mm).
const DISTANCES: [f64; 2] = [1e-4, 1e8];
/// Margin around what is fitted into the picture, as a factor.
const FIT_MARGIN: f64 = 1.08;

/// Projection of depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Projection {
    /// Far things look smaller.
    #[default]
    Perspective,
    /// Parallel: lengths across the view can be compared.
    Orthographic,
}

/// Style of turning the view by dragging.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OrbitStyle {
    /// About the scene's Z axis and the view's horizontal; Z stays upright.
    #[default]
    Turntable,
    /// About the view's own axes.
    Free,
}

/// A camera. It sees at the target's depth a height of `2 distance tan(field_of_view / 2)` in either
/// projection, so that changing the projection keeps the size of things there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Point looked at, in the middle of the picture.
    pub target: DVec3,
    /// From the eye to the target (mm), positive.
    pub distance: f64,
    /// From the camera's axes (x right, y up, z towards the viewer) to the scene's; a unit quaternion.
    pub orientation: DQuat,
    /// Projection of depth.
    pub projection: Projection,
    /// Vertical field of view (rad), between 0 and pi.
    pub field_of_view: f64,
}

/// A half line into the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewRay {
    /// Origin of the ray: the eye, or in an orthographic view a point of the plane through the eye.
    pub origin: DVec3,
    /// Unit vector away from the viewer.
    pub direction: DVec3,
}

/// A point in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// In the picture (pixels), possibly outside.
    pub pixel: DVec2,
    /// Distance before the eye, along the view (mm).
    pub depth: f64,
}

impl Default for Camera {
    /// Isometric, 100 mm before the origin.
    fn default() -> Self {
        Self {
            target: DVec3::ZERO,
            distance: 100.0,
            orientation: super::view::StandardView::Isometric.orientation(),
            projection: Projection::default(),
            field_of_view: DEFAULT_FIELD_OF_VIEW,
        }
    }
}

impl Camera {
    /// The position of the eye.
    pub fn eye(&self) -> DVec3 {
        self.target + self.backward() * self.distance
    }

    /// Unit vector to the right of the picture.
    pub fn right(&self) -> DVec3 {
        self.orientation * DVec3::X
    }

    /// Unit vector to its top.
    pub fn up(&self) -> DVec3 {
        self.orientation * DVec3::Y
    }

    /// Unit vector towards the viewer.
    pub fn backward(&self) -> DVec3 {
        self.orientation * DVec3::Z
    }

    /// From the scene to camera coordinates: x right, y up, z towards the viewer, origin at the eye.
    pub fn to_view(&self, p: DVec3) -> DVec3 {
        // About the target, which is near what is drawn, while the eye may be far off.
        self.view_rotation() * (p - self.target) - DVec3::Z * self.distance
    }

    /// The rotation from scene to camera axes.
    pub fn view_rotation(&self) -> DMat3 {
        DMat3::from_quat(self.orientation.inverse())
    }

    /// Height of the picture at the target's depth (mm).
    pub fn visible_height(&self) -> f64 {
        2.0 * self.distance * (0.5 * self.field_of_view).tan()
    }

    /// Size of a pixel (mm) at `depth` before the eye, in a picture `height` pixels high.
    pub fn pixel_size(&self, depth: f64, height: u32) -> f64 {
        let visible = match self.projection {
            Projection::Perspective => 2.0 * depth.max(0.0) * (0.5 * self.field_of_view).tan(),
            Projection::Orthographic => self.visible_height(),
        };
        visible / f64::from(height.max(1))
    }

    /// The ray through a pixel position in a picture of `size` pixels.
    pub fn ray(&self, pixel: DVec2, size: [u32; 2]) -> ViewRay {
        let across = self.across(pixel, size);
        let on_target_plane = self.target + self.right() * across.x + self.up() * across.y;
        match self.projection {
            Projection::Perspective => {
                let origin = self.eye();
                ViewRay { origin, direction: (on_target_plane - origin).normalize_or(-self.backward()) }
            }
            Projection::Orthographic => {
                ViewRay { origin: on_target_plane + self.backward() * self.distance, direction: -self.backward() }
            }
        }
    }

    /// Position of `p` in a picture of `size` pixels; `None` behind the eye of a perspective view.
    pub fn project(&self, p: DVec3, size: [u32; 2]) -> Option<Projected> {
        let view = self.to_view(p);
        let depth = -view.z;
        let across = match self.projection {
            Projection::Perspective if depth <= 0.0 => return None,
            Projection::Perspective => view.truncate() * (self.distance / depth),
            Projection::Orthographic => view.truncate(),
        };
        let [width, height] = size.map(|s| f64::from(s.max(1)));
        let offset = across * (height / self.visible_height());
        Some(Projected { pixel: DVec2::new(0.5 * width + offset.x, 0.5 * height - offset.y), depth })
    }

    /// Turns the view by a drag of `pixels` over a picture `height` pixels high; half the height is a quarter
    /// turn. `pivot` keeps its place in the picture: the target, or a point picked where the drag began.
    pub fn orbit(&mut self, pixels: DVec2, height: u32, style: OrbitStyle, pivot: DVec3) {
        let angles = pixels * (std::f64::consts::PI / f64::from(height.max(1)));
        let turn = match style {
            OrbitStyle::Free => DQuat::from_axis_angle(self.up(), -angles.x) * self.about_right(-angles.y),
            OrbitStyle::Turntable => {
                DQuat::from_rotation_z(-angles.x) * self.about_right(self.pitch_allowed(-angles.y))
            }
        };
        self.orientation = (turn * self.orientation).normalize();
        self.target = pivot + turn * (self.target - pivot);
    }

    /// Turns the picture about its middle by `angle` (rad), counter-clockwise as seen.
    pub fn roll(&mut self, angle: f64) {
        self.orientation = (self.orientation * DQuat::from_rotation_z(-angle)).normalize();
    }

    /// Moves what is seen by `pixels`, exactly so at the depth of the target.
    pub fn pan(&mut self, pixels: DVec2, size: [u32; 2]) {
        let scale = self.visible_height() / f64::from(size[1].max(1));
        self.target += (self.up() * pixels.y - self.right() * pixels.x) * scale;
    }

    /// Makes things `factor` times as large; what is seen under `pixel` at the target's depth stays there.
    pub fn zoom(&mut self, factor: f64, pixel: DVec2, size: [u32; 2]) {
        if !(factor > 0.0 && factor.is_finite()) {
            return;
        }
        let distance = (self.distance / factor).clamp(DISTANCES[0], DISTANCES[1]);
        let kept = 1.0 - distance / self.distance;
        let across = self.across(pixel, size);
        self.target += (self.right() * across.x + self.up() * across.y) * kept;
        self.distance = distance;
    }

    /// Moves target and eye, without turning, so that all of `bounds` is seen with a little room around it, in
    /// a picture `aspect` times as wide as high. Does nothing for bounds without a finite extent.
    pub fn fit(&mut self, bounds: &Bounds, aspect: f64) {
        let size = bounds.size();
        if !(size.is_finite() && size.min_element() >= 0.0 && aspect > 0.0) {
            return;
        }
        self.target = bounds.center();
        let tan_y = (0.5 * self.field_of_view).tan();
        let tan = DVec2::new(tan_y * aspect, tan_y) / FIT_MARGIN;
        let rotation = self.view_rotation();
        let needed = bounds.corners().map(|c| {
            let v = rotation * (c - self.target);
            let towards_viewer = if self.projection == Projection::Perspective { v.z } else { 0.0 };
            towards_viewer + (v.truncate().abs() / tan).max_element()
        });
        let distance = needed.into_iter().fold(0.0, f64::max);
        let least = if size.length() > 0.0 { DISTANCES[0] } else { 1.0 };
        self.distance = distance.clamp(least, DISTANCES[1]);
    }

    /// Depths (mm) between which all of `bounds` lies, for the planes at which a picture is clipped; the first
    /// is positive in a perspective view, and small against the second only as far as a depth buffer bears it.
    pub fn depth_range(&self, bounds: &Bounds) -> [f64; 2] {
        let [near, far] = self.depth_extent(bounds);
        if !(near <= far && far.is_finite()) {
            return [0.5 * self.distance, 2.0 * self.distance];
        }
        let room = 0.01 * (far - near) + 1e-3 * self.distance;
        let (near, far) = (near - room, far + room);
        match self.projection {
            Projection::Orthographic => [near, far],
            Projection::Perspective => {
                let far = far.max(1e-3 * self.distance);
                [near.max(far * 5e-4), far]
            }
        }
    }

    /// Depths (mm) of the nearest and the furthest corner of `bounds`.
    pub fn depth_extent(&self, bounds: &Bounds) -> [f64; 2] {
        let rotation = self.view_rotation();
        let depths = bounds.corners().map(|c| -((rotation * (c - self.target)).z - self.distance));
        depths.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], d| [a.min(d), b.max(d)])
    }

    /// The matrix from camera coordinates to clip space (x and y from -1 to 1, z from 0 at `near` to 1 at
    /// `far`).
    pub fn projection_matrix(&self, aspect: f64, [near, far]: [f64; 2]) -> DMat4 {
        let depth = near - far;
        match self.projection {
            Projection::Perspective => {
                let scale = 1.0 / (0.5 * self.field_of_view).tan();
                DMat4::from_cols(
                    DVec4::new(scale / aspect, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, scale, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, far / depth, -1.0),
                    DVec4::new(0.0, 0.0, near * far / depth, 0.0),
                )
            }
            Projection::Orthographic => {
                let scale = 2.0 / self.visible_height();
                DMat4::from_cols(
                    DVec4::new(scale / aspect, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, scale, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, 1.0 / depth, 0.0),
                    DVec4::new(0.0, 0.0, near / depth, 1.0),
                )
            }
        }
    }

    /// The view a part `t` (0 to 1) of the way from `self` to `other`, starting and ending gently. The
    /// projection changes half way.
    pub fn towards(&self, other: &Self, t: f64) -> Self {
        let t = t.clamp(0.0, 1.0);
        let s = t * t * (3.0 - 2.0 * t);
        Self {
            target: self.target.lerp(other.target, s),
            // By ratio, so that a long zoom is as fast at its start as at its end.
            distance: self.distance * (other.distance / self.distance).powf(s),
            orientation: self.orientation.slerp(other.orientation, s).normalize(),
            projection: if t < 0.5 { self.projection } else { other.projection },
            field_of_view: self.field_of_view + (other.field_of_view - self.field_of_view) * s,
        }
    }

    /// Whether every number in it can be drawn with.
    pub fn is_valid(&self) -> bool {
        self.target.is_finite()
            && self.orientation.is_normalized()
            && self.distance > 0.0
            && self.distance.is_finite()
            && (1e-3..3.1).contains(&self.field_of_view)
    }

    /// Where the ray through `pixel` meets the plane across the view through the target: right and up (mm).
    fn across(&self, pixel: DVec2, size: [u32; 2]) -> DVec2 {
        let [width, height] = size.map(|s| f64::from(s.max(1)));
        let scale = self.visible_height() / height;
        DVec2::new(pixel.x - 0.5 * width, 0.5 * height - pixel.y) * scale
    }

    fn about_right(&self, angle: f64) -> DQuat {
        DQuat::from_axis_angle(self.right(), angle)
    }

    /// `angle` cut short where the view would go over a pole and stand on its head.
    fn pitch_allowed(&self, angle: f64) -> f64 {
        let up = self.up();
        let pitch = self.backward().z.clamp(-1.0, 1.0).asin();
        if up.z < -1e-9 {
            return angle;
        }
        // A turn about the right axis by `angle` lowers the eye by as much.
        let quarter = std::f64::consts::FRAC_PI_2;
        -((pitch - angle).clamp(-quarter, quarter) - pitch)
    }
}

#[cfg(test)]
mod tests;
