//! Cameras on a part: standard views, and the view into a channel.

use glam::DVec3;

use geometry::mesh::Bounds;
use render::camera::{Camera, Projection};
use render::scene::{Scene, SectionPlane};
use render::view::{StandardView, looking};
use wheel::channel::Channel;
use wheel::electrode::EntrySide;

/// Width and height of a picture of a report (pixels).
pub const PICTURE_SIZE: [u32; 2] = [1400, 900];

/// A named view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NamedView {
    /// A standard view of engineering drawing.
    Standard(StandardView),
    /// The view from outside into the channel: see [`into_channel`].
    Channel,
}

impl NamedView {
    const CHANNEL: &'static str = "channel";

    /// The view of this name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        if name.eq_ignore_ascii_case(Self::CHANNEL) {
            return Some(Self::Channel);
        }
        StandardView::from_name(name).map(Self::Standard)
    }

    /// The names of all views.
    pub fn names() -> Vec<&'static str> {
        StandardView::ALL.into_iter().map(StandardView::name).chain([Self::CHANNEL]).collect()
    }
}

/// The box around the bodies of `scene`, without the grid and the lines that reach far out (mm).
pub fn bodies(scene: &Scene) -> Bounds {
    let only = Scene { objects: scene.objects.clone(), ..Scene::default() };
    only.bounds()
}

/// `camera` turned to a standard view of all bodies in a picture `aspect` times as wide as high.
pub fn standard(view: StandardView, scene: &Scene, camera: Camera, aspect: f64) -> Camera {
    let mut camera = Camera { orientation: view.orientation(), ..camera };
    camera.fit(&bodies(scene), aspect);
    camera
}

/// `camera` turned to look from the side of entry, through where the shroud is, into `channel`, whose walls fill the
/// picture.
pub fn into_channel(channel: &Channel, side: EntrySide, camera: Camera, aspect: f64) -> Camera {
    let bounds = walls(channel);
    onto(channel, side, &bounds.grown(0.25 * bounds.size().length()), camera, aspect)
}

/// A camera with the direction of view of [`into_channel`] and all of an electrode in the picture: `electrode` is the
/// box around it or around its poses in the coordinates of the loaded mesh (mm).
pub fn electrode_in_channel(channel: &Channel, side: EntrySide, electrode: &Bounds, aspect: f64) -> Camera {
    let walls = walls(channel);
    let both = Bounds { min: walls.min.min(electrode.min), max: walls.max.max(electrode.max) };
    onto(channel, side, &both, Camera::default(), aspect)
}

fn onto(channel: &Channel, side: EntrySide, bounds: &Bounds, camera: Camera, aspect: f64) -> Camera {
    let frame = &channel.frame;
    let towards_viewer = frame.z * 0.8 - frame.y * 0.45 + frame.x * (0.4 * beside_hub(channel, side));
    let mut camera = Camera { orientation: looking(towards_viewer, frame.z), ..camera };
    camera.fit(bounds, aspect);
    camera
}

/// The direction along X from which one looks past the hub into the channel.
fn beside_hub(channel: &Channel, side: EntrySide) -> f64 {
    match side {
        EntrySide::Outward | EntrySide::Inward => channel.line_at(channel.middle().along).up.x.signum(),
        side => side.sign(),
    }
}

/// A camera square to a section, with `up` upwards, `at` in the middle, and a picture `height` high (mm).
pub fn onto_section(plane: &SectionPlane, up: DVec3, at: DVec3, height: f64) -> Camera {
    let camera = Camera { projection: Projection::Orthographic, target: at, ..Camera::default() };
    let distance = 0.5 * height / (0.5 * camera.field_of_view).tan();
    Camera { orientation: looking(plane.normal, up), distance, ..camera }
}

/// A camera on the whole part from the side of entry, with `channel` on top.
pub fn from_entry(channel: &Channel, side: EntrySide, scene: &Scene, aspect: f64) -> Camera {
    let frame = &channel.frame;
    let towards_viewer = match side {
        EntrySide::Outward | EntrySide::Inward => {
            frame.z * 0.8 - frame.y * 0.45 + frame.x * (0.4 * beside_hub(channel, side))
        }
        side => frame.x * (0.9 * side.sign()) + frame.z * 0.45 - frame.y * 0.55,
    };
    let mut camera = Camera { orientation: looking(towards_viewer, frame.z), ..Camera::default() };
    camera.fit(&bodies(scene), aspect);
    camera
}

/// The box around the walls of `channel` in the coordinates of the loaded mesh (mm).
fn walls(channel: &Channel) -> Bounds {
    let points = channel.low.points.iter().chain(&channel.high.points);
    Bounds::of(points.map(|p| channel.frame.to_parent(*p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_is_seen_from_the_side_that_is_taken_away_in_the_height_asked_for() {
        let plane = SectionPlane { point: DVec3::new(1.0, 2.0, 3.0), normal: DVec3::Y };
        let camera = onto_section(&plane, DVec3::X, plane.point, 10.0);
        assert!((camera.backward() - plane.normal).length() < 1e-12 && (camera.up() - DVec3::X).length() < 1e-12);
        let top = camera.project(plane.point + 5.0 * DVec3::X, [200, 100]).unwrap().pixel;
        assert!((top - glam::DVec2::new(100.0, 0.0)).length() < 1e-9, "half the height above the middle: {top}");
    }

    #[test]
    fn every_name_names_a_view_and_nothing_else_does() {
        for name in NamedView::names() {
            assert!(NamedView::from_name(&name.to_uppercase()).is_some(), "{name}");
        }
        assert_eq!(NamedView::from_name("channel"), Some(NamedView::Channel));
        assert_eq!(NamedView::from_name("top"), Some(NamedView::Standard(StandardView::Top)));
        assert_eq!(NamedView::from_name("sideways"), None);
    }
}
